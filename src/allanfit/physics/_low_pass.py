"""A low-pass filter between the sensor and its samples."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractFilter, Parameter
from ._filtering import filtered
from ._term import Sampling

# Aliases summed on each side; an integral is taken for the rest.
_ALIASES = 16


class LowPass(AbstractFilter):
    """|H|^2 = 1/(1 + (f/f_c)^(2 order)): Butterworth, f_c at -3 dB, of any order above 1/2.

    White noise through an analogue filter keeps what passes beyond the Nyquist frequency as
    aliases. The density N of a sensor with a filter is what it shows at low frequency, aliases
    included, so that the gain is one there whatever the cut-off. Those up to 8 sampling rates have
    their aliases right.

    A `digital` filter, in the sensor's processor, comes after the samples are taken: nothing folds,
    and by the bilinear transform its frequencies are those of tan(pi f dt)/(pi dt). With `averaged`
    samples are averages over their interval, whatever is said of the terms.
    """

    cutoff_frequency: Float[Array, ""]
    order: Float[Array, ""]
    digital: bool = eqx.field(static=True, default=False)
    averaged: bool = eqx.field(static=True, default=False)
    name: ClassVar[str] = "low_pass"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("cutoff_frequency", "Hz"),
        Parameter("order", ""),
        Parameter("digital", ""),
        Parameter("averaged", ""),
    )
    what: ClassVar[str] = "a low-pass filter"
    origin: ClassVar[str] = "the sensor's own digital or analogue filter"

    def gain(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling = "point"
    ) -> Float[Array, "*shape"]:
        """The folded |H|^2, as a multiple of what it is at zero frequency."""
        if self.digital:
            return self.passed(frequency, dt)
        sampling = "averaged" if self.averaged else sampling
        still = jnp.zeros_like(frequency, shape=())
        return self.folded(frequency, dt, sampling) / self.folded(still, dt, sampling)

    def folded(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling = "point"
    ) -> Float[Array, "*shape"]:
        """Sum over j of |H(f + j/dt)|^2, times sinc^2 there where samples are averages."""

        def add(total, alias):
            image = frequency + alias / dt
            seen = jnp.sinc(image * dt) ** 2 if sampling == "averaged" else 1.0
            return total + self.passed(image, dt) * seen, None

        aliases = jnp.arange(-_ALIASES, _ALIASES + 1, dtype=frequency.dtype)
        near = jax.lax.scan(add, jnp.zeros_like(frequency * self.order), aliases)[0]
        if sampling == "averaged":
            return near
        edge = (_ALIASES + 0.5) / dt
        return near + dt * (self._beyond(edge + frequency) + self._beyond(edge - frequency))

    def passed(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """1/(1 + (f/f_c)^(2 order)), as a logistic function: neither it nor its slope overflows."""
        at, cutoff = jnp.abs(frequency), self.cutoff_frequency
        if self.digital:
            at, cutoff = (jnp.tan(jnp.pi * jnp.minimum(f * dt, 0.4999)) for f in (at, cutoff))
        # Zero frequency has no logarithm; this one, in cut-off frequencies, passes as well.
        ratio = jnp.maximum(at / cutoff, 1e-18)
        return jax.nn.sigmoid(-2 * self.order * jnp.log(ratio))

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """White noise filtered, aliases and all; nothing is drawn."""
        return filtered(samples, lambda frequency: self.gain(frequency, dt, sampling), dt)

    def _beyond(self, edge: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        """Integral of |H|^2 from `edge` on, by its series in falling powers [Hz]."""
        power = 2 * self.order
        ratio = jnp.exp(-power * jnp.log(edge / self.cutoff_frequency))
        terms = ((-1) ** (k + 1) * ratio**k / (k * power - 1) for k in range(1, 7))
        return edge * sum(terms, jnp.zeros_like(edge))
