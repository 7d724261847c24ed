"""An excess or lack of noise about one frequency: the shape of what has no name."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, AbstractFilter, Parameter
from ._filtering import filtered
from ._term import Sampling

# Frequencies in cycles per sample from which on a notch has a gain.
_LOWEST = 1e-12


class Bump(AbstractFilter):
    """The density times exp(height exp(-ln(f/f_0)^2/(2 width^2))), a Gaussian in ln f.

    A description and no physics; a lack of noise has a negative height. The width is in e-folds
    of frequency.

    A `flat` one has the power 8 instead of 2 of the distance, and so a flat top and steep flanks:
    a band of noise from f_0 exp(-width) to f_0 exp(width).

    A `high_pass` is the lack toward zero frequency that alternating-current coupling leaves, or a
    mean that is estimated and taken off all the time: the density is multiplied by
    1/(1 + (f_0/f)^(1/width)), a Butterworth filter of order 1/(2 width), whatever the height.

    A `notch` is what a digital filter of two poles and two zeros takes out about one frequency: the
    density is multiplied by 1 - (1 - exp(height))/(1 + x^2), where

        x = (T/T_0 - T_0/T) sin(2 pi f_0 dt)/(2 tan(pi f_0 width dt)),  T = tan(pi f dt),

    by the bilinear transform. Where height is large and negative, half of the power is left at
    frequencies f_0 width apart, so that the quality factor is 1/width.

    An `echo` adds to each sample such a part of the one a time 1/f_0 before as the height says, and
    so makes ripples that are f_0 apart: the density is multiplied by
    |1 + height exp(-2 pi i f/f_0)|^2, whatever the width.
    """

    height: Float[Array, ""]
    frequency: Float[Array, ""]
    width: Float[Array, ""]
    high_pass: bool = eqx.field(static=True, default=False)
    flat: bool = eqx.field(static=True, default=False)
    notch: bool = eqx.field(static=True, default=False)
    echo: bool = eqx.field(static=True, default=False)
    name: ClassVar[str] = "bump"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("height", "", range=SIGNED),
        Parameter("frequency", "Hz"),
        Parameter("width", ""),
        Parameter("high_pass", "", kind="flag"),
        Parameter("flat", "", kind="flag"),
        Parameter("notch", "", kind="flag"),
        Parameter("echo", "", kind="flag"),
    )
    what: ClassVar[str] = "a bump or dip of the noise about one frequency"
    origin: ClassVar[str] = "nothing that the catalogue has a name for"

    def gain(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """The factor, aliases and all: it is about the noise as sampled."""
        return self.passed(frequency, dt)

    def passed(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """The factor: what is sampled already does not fold."""
        if self.notch:
            return 1 + jnp.expm1(self.height) / (1 + self._detuning(frequency, dt) ** 2)
        if self.echo:
            turn = 2 * jnp.pi * frequency / self.frequency
            return 1 + self.height**2 + 2 * self.height * jnp.cos(turn)
        distance = jnp.log(jnp.maximum(frequency / self.frequency, 1e-18)) / self.width
        if self.high_pass:
            return jax.nn.sigmoid(distance)
        return jnp.exp(self.height * jnp.exp(-(distance ** (8 if self.flat else 2)) / 2))

    def _detuning(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        middle = jnp.pi * self.frequency * dt
        turn = jnp.tan(jnp.pi * jnp.maximum(frequency * dt, _LOWEST)) / jnp.tan(middle)
        return (turn - 1 / turn) * jnp.sin(2 * middle) / (2 * jnp.tan(middle * self.width))

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples filtered; nothing is drawn."""
        return filtered(samples, lambda frequency: self.gain(frequency, dt), dt)
