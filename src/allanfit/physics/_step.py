"""Steps of the bias."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._effect import AbstractMean, Parameter


class Step(AbstractMean):
    """The mean changes by `amplitude` at each of `times`, for good.

    The amplitude is one for all, or one for each; it has a sign.
    """

    amplitude: Float[Array, "*times"]
    times: Float[Array, " times"]
    name: ClassVar[str] = "step"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u"),
        Parameter("times", "s"),
    )
    what: ClassVar[str] = "a step of the bias"
    origin: ClassVar[str] = "a part that has slipped, or a trap that has emptied"

    def mean(self, time: Float[Array, " samples"]) -> Float[Array, " samples"]:
        """Sum of the amplitudes of the steps taken by each time [u]."""
        order = jnp.argsort(self.times)
        heights = jnp.broadcast_to(self.amplitude, self.times.shape)[order]
        level = jnp.concatenate([jnp.zeros(1, heights.dtype), jnp.cumsum(heights)])
        return level[jnp.searchsorted(self.times[order], time, side="right")]
