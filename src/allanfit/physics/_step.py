"""Steps of the bias."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._effect import AbstractMean, Parameter


class Step(AbstractMean):
    """The mean changes by `amplitude` at each of `times`, for good.

    The amplitude is one for all, or one for each; it has a sign. With `heights`, one for each, it
    is their mean size and no more.
    """

    amplitude: Float[Array, "*times"]
    times: Float[Array, " times"]
    heights: Float[Array, " times"] | None = None
    name: ClassVar[str] = "step"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u"),
        Parameter("times", "s"),
        Parameter("heights", "u"),
    )
    what: ClassVar[str] = "a step of the bias"
    origin: ClassVar[str] = "a part that has slipped, or a trap that has emptied"

    def mean(self, time: Float[Array, " samples"]) -> Float[Array, " samples"]:
        """Sum of the amplitudes of the steps taken by each time [u]."""
        order = jnp.argsort(self.times)
        given = self.amplitude if self.heights is None else self.heights
        heights = jnp.broadcast_to(given, self.times.shape)[order]
        level = jnp.concatenate([jnp.zeros(1, heights.dtype), jnp.cumsum(heights)])
        return level[jnp.searchsorted(self.times[order], time, side="right")]
