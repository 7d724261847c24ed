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
        Parameter("amplitude", "u", kind="each"),
        Parameter("times", "s", kind="series"),
        Parameter("heights", "u", kind="series"),
    )
    what: ClassVar[str] = "a step of the bias"
    origin: ClassVar[str] = "a part that has slipped, or a trap that has emptied"

    def contradiction(self) -> str:
        """Amplitudes or heights that are not as many as times."""
        given = self.amplitude if self.heights is None else self.heights
        if given.size in (1, self.times.size):
            return ""
        return f"has {given.size} amplitudes and {self.times.size} times; give one for each time"

    def mean(self, time: Float[Array, " samples"]) -> Float[Array, " samples"]:
        """Sum of the amplitudes of the steps taken by each time [u]."""
        order = jnp.argsort(self.times)
        given = self.amplitude if self.heights is None else self.heights
        heights = jnp.broadcast_to(given, self.times.shape)[order]
        level = jnp.concatenate([jnp.zeros(1, heights.dtype), jnp.cumsum(heights)])
        return level[jnp.searchsorted(self.times[order], time, side="right")]
