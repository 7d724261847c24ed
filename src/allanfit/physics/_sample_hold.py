"""Sample and hold: values that are sent more than once."""

import math
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractFilter, Parameter, Range
from ._term import Sampling

# Frequencies over which a mean over the band is taken.
_PLACES = 2048


class SampleHold(AbstractFilter):
    """Each fresh value fills `repeat` samples on average.

    A whole `repeat` is taken as periodic. Any other is taken as random: each sample is fresh with
    probability 1/repeat, and its values have the autocovariance p^k with p = 1 - 1/repeat; unless
    `regular` is set, where a sensor has a steady clock of its own, and a value is held for
    the whole number of samples below `repeat` or above it, in a beat of the two clocks.
    """

    repeat: Float[Array, ""]
    regular: bool = eqx.field(static=True, default=False)
    name: ClassVar[str] = "sample_hold"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("repeat", "", range=Range(1.0, math.inf, "1 or more")),
        Parameter("regular", "", kind="flag"),
    )
    what: ClassVar[str] = "values that are repeated"
    origin: ClassVar[str] = "a sensor that is read faster than it measures"

    def gain(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """sin^2(pi f r dt)/(r sin^2(pi f dt)), or (1 - p^2)/(1 - 2 p cos(2 pi f dt) + p^2).

        Its mean over the band is one: holding changes no variance. In a beat the autocovariance
        is a triangle as wide as `repeat`, the mean of two such of whole widths.
        """
        cycles = frequency * dt
        below = jnp.floor(self.repeat)
        above = (self.repeat - below) * (below + 1) / self.repeat
        periodic = (1 - above) * _whole_hold(below, cycles) + above * _whole_hold(below + 1, cycles)
        held = 1 - 1 / self.repeat
        sine = jnp.sin(jnp.pi * cycles) ** 2
        random = (1 - held) * (1 + held) / ((1 - held) ** 2 + 4 * held * sine)
        return jnp.where(self._steady(), periodic, random)

    def passed(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """One: what changes slowly is held without loss."""
        return jnp.ones_like(frequency)

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The last fresh sample in place of each."""
        index = jnp.arange(samples.shape[0])
        # The sample of the log at which a value of the sensor's clock is first seen.
        seen = jnp.floor(index / self.repeat) != jnp.floor((index - 1) / self.repeat)
        random = jax.random.uniform(key, samples.shape) < 1 / self.repeat
        fresh = jnp.where(self._steady(), seen, random)
        return samples[jax.lax.cummax(jnp.where(fresh, index, 0))]

    def _steady(self):
        return self.regular | (jnp.abs(self.repeat - jnp.round(self.repeat)) < 1e-6)


def _whole_hold(samples, cycles):
    """What holding each value for so many samples does to the density of white noise."""
    return samples * (jnp.sinc(samples * cycles) / jnp.sinc(cycles)) ** 2


def held_factor(
    repeat: float, regular: bool, before: AbstractFilter | None = None, rate_hz: float = 1.0
) -> float:
    """N at low frequency over N of the fresh values at the rate of the log, for held values.

    Each value counts `repeat` times for a filter that takes every sample, and one that takes fresh
    values alone has fewer of them: for both the density at low frequency is that of the hold.

    With the gain |H|^2 of the mean delay, noise of a density S that is held at random has |H|^2 S
    and, as white noise that is held, the mean of (1 - |H|^2) S over the band. Behind a filter
    `before`, of a recording at `rate_hz`, the latter is less.
    """
    hold = SampleHold(jnp.asarray(repeat), regular)
    factor = float(hold.gain(jnp.zeros(()), 1.0))
    if before is None or bool(hold._steady()):
        return factor**0.5
    cycles = (jnp.arange(_PLACES) + 0.5) / (2 * _PLACES)
    late = hold.gain(cycles, 1.0) / factor
    changing = jnp.mean((1 - late) * before.gain(cycles * rate_hz, 1 / rate_hz))
    return float(1 + factor * changing) ** 0.5
