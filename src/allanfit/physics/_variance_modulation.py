"""Noise that is stronger at some times than at others."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractEffect, Parameter
from ._filtering import running_mean
from ._intervals import backwards, inside
from ._term import Sampling


class VarianceModulation(AbstractEffect):
    """Within `intervals` [s] the fast noise is `ratio` times as strong as outside.

    With `strengths` it is so many times as strong as the model at `times` [s], and in a straight
    line between these; `ratio` and `intervals` then say no more than how far that goes, and when it
    is loud.

    In a recording that is drawn, the white and the quantization noise; of samples, what differs
    from the running mean over a second.
    """

    ratio: Float[Array, ""]
    intervals: Float[Array, "intervals 2"]
    times: Float[Array, " times"] | None = None
    strengths: Float[Array, " times"] | None = None
    name: ClassVar[str] = "variance_modulation"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", ""),
        Parameter("intervals", "s", kind="intervals"),
        Parameter("times", "s", kind="series"),
        Parameter("strengths", "", kind="series"),
    )
    what: ClassVar[str] = "noise whose strength changes with time"
    origin: ClassVar[str] = "people, machines or a supply that come and go"

    def contradiction(self) -> str:
        """Intervals that end before they start, or a course of which half is missing."""
        lengths = [0 if each is None else each.size for each in (self.times, self.strengths)]
        if lengths[0] != lengths[1]:
            return f"has {lengths[0]} times and {lengths[1]} strengths; give one for each time"
        return backwards(self.intervals)

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples, the fast part of some of them enlarged; nothing is drawn."""
        fast = samples - running_mean(samples, dt)
        return samples + (self.strength(samples.shape[0], dt) - 1) * fast

    def strength(self, samples: int, dt: float) -> Float[Array, " samples"]:
        """How many times as strong the noise is at each sample."""
        time = dt * jnp.arange(samples)
        if self.times is not None and self.strengths is not None:
            return jnp.interp(time, self.times, self.strengths)
        return jnp.where(inside(time, self.intervals), self.ratio, 1.0)
