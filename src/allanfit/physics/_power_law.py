"""Noise whose density is a power of frequency, other than those of the five terms."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import ZERO_OR_MORE, AbstractAddedNoise, Parameter, Range
from ._stationary import sample_from_eigenvalues
from ._term import Sampling

# From this exponent on, increments are drawn and summed.
_SUMMED = 0.5
# How many aliases are summed before the Euler-Maclaurin formula takes the rest.
_DIRECT = 8


class PowerLaw(AbstractAddedNoise):
    """S(f) = h f^-alpha of exponent alpha, 0 to 3, and density h at 1 Hz [u^2/Hz].

    A point-sampled power law needs a rule for what lies beyond the Nyquist frequency; ours is
    fractional differencing of order alpha/2 (Kasdin 1995, Proc. IEEE 83:802), as for flicker
    noise: S(f) = h (sin(pi f dt)/(pi dt))^-alpha.
    """

    exponent: Float[Array, ""]
    #: The parameter `density`.
    level: Float[Array, ""]
    name: ClassVar[str] = "power_law"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("exponent", "", range=Range(0.0, 3.0, "between 0 and 3")),
        Parameter("density", "u^2/Hz", field="level", range=ZERO_OR_MORE),
    )
    scale: ClassVar[tuple[str, int]] = ("level", 1)
    what: ClassVar[str] = "noise whose density falls as a power of frequency"
    origin: ClassVar[str] = "many relaxations at once, in the material or in the electronics"

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """H (sin(pi f dt)/(pi dt))^-alpha, or all aliases of sinc^2(f dt) h f^-alpha [u^2/Hz]."""
        cycles = frequency * dt
        sine = jnp.sin(jnp.pi * cycles) / jnp.pi
        if sampling == "point":
            return self.level * (sine / dt) ** -self.exponent
        aliases = _hurwitz(2 + self.exponent, cycles) + _hurwitz(2 + self.exponent, 1 - cycles)
        return self.level * dt**self.exponent * sine**2 * aliases

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """From the density on a period of twice the length, up to a constant.

        Above an exponent of one half it is the increments that are drawn so, which have little
        power at low frequency; their sum does not close on itself as a periodic noise would.
        """
        bins = jnp.arange(1, samples + 1) / (2 * samples * dt)
        eigenvalues = self.density(bins, dt, sampling) / (2 * dt)
        summed = self.exponent >= _SUMMED
        steps = 4 * jnp.sin(jnp.pi * bins * dt) ** 2
        eigenvalues = jnp.where(summed, eigenvalues * steps, eigenvalues)
        # The mean of f^-power over the half bin at zero, where the power itself may be infinite.
        power = self.exponent - jnp.where(summed, 2.0, 0.0)
        lowest = eigenvalues[:1] * 2**power / jnp.maximum(1 - power, 0.05)
        drawn = sample_from_eigenvalues(key, jnp.concatenate([lowest, eigenvalues]))[:samples]
        return jnp.where(summed, jnp.cumsum(drawn), drawn)


def _hurwitz(power: Float[Array, ""], start: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Sum over j >= 0 of (j + start)^-power, by Euler and Maclaurin (DLMF 25.11.5).

    Good to 1e-9 for powers of 2 to 5; that of JAX has no derivative by the power.
    """
    total = sum(((start + j) ** -power for j in range(_DIRECT)), jnp.zeros_like(start))
    end = start + _DIRECT
    tail = end / (power - 1) + 1 / 2 + power / (12 * end)
    tail -= power * (power + 1) * (power + 2) / (720 * end**3)
    return total + tail * end**-power
