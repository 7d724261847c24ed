"""Sample and hold: values that are sent more than once."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractFilter, Parameter
from ._term import Sampling


class SampleHold(AbstractFilter):
    """Each fresh value fills `repeat` samples on average.

    A whole `repeat` is taken as periodic. Any other is taken as random: each sample is fresh with
    probability 1/repeat, and its values have the autocovariance p^k with p = 1 - 1/repeat.
    """

    repeat: Float[Array, ""]
    name: ClassVar[str] = "sample_hold"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("repeat", ""),)
    what: ClassVar[str] = "values that are repeated"
    origin: ClassVar[str] = "a sensor that is read faster than it measures"

    def gain(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """sin^2(pi f r dt)/(r sin^2(pi f dt)), or (1 - p^2)/(1 - 2 p cos(2 pi f dt) + p^2).

        Its mean over the band is one: holding changes no variance.
        """
        cycles = frequency * dt
        periodic = self.repeat * (jnp.sinc(self.repeat * cycles) / jnp.sinc(cycles)) ** 2
        held = 1 - 1 / self.repeat
        sine = jnp.sin(jnp.pi * cycles) ** 2
        random = (1 - held) * (1 + held) / ((1 - held) ** 2 + 4 * held * sine)
        return jnp.where(self._whole(), periodic, random)

    def passed(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """One: what changes slowly is held without loss."""
        return jnp.ones_like(frequency)

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The last fresh sample in place of each."""
        index = jnp.arange(samples.shape[0])
        periodic = index % jnp.maximum(jnp.round(self.repeat), 1) == 0
        random = jax.random.uniform(key, samples.shape) < 1 / self.repeat
        fresh = jnp.where(self._whole(), periodic, random)
        return samples[jax.lax.cummax(jnp.where(fresh, index, 0))]

    def _whole(self):
        return jnp.abs(self.repeat - jnp.round(self.repeat)) < 1e-6
