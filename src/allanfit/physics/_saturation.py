"""Saturation: the end of the range."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, ZERO_OR_MORE, AbstractEffect, Parameter
from ._term import Sampling


class Saturation(AbstractEffect):
    """Samples stop at -limit and +limit [u].

    With a `low` or a `high` [u], signed, they stop there instead: at both or at that one alone.
    """

    limit: Float[Array, ""]
    low: Float[Array, ""] | None = None
    high: Float[Array, ""] | None = None
    name: ClassVar[str] = "saturation"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("limit", "u", range=ZERO_OR_MORE),
        Parameter("low", "u", range=SIGNED),
        Parameter("high", "u", range=SIGNED),
    )
    what: ClassVar[str] = "saturation"
    origin: ClassVar[str] = "a range that is too narrow"

    def contradiction(self) -> str:
        """Rails the wrong way round."""
        if self.low is None or self.high is None or self.low < self.high:
            return ""
        return f"has its low at {self.low:g}, not below its high at {self.high:g}"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples clipped."""
        if self.low is None and self.high is None:
            return jnp.clip(samples, -self.limit, self.limit)
        return jnp.clip(samples, self.low, self.high)
