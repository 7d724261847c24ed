"""Saturation: the end of the range."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractEffect, Parameter
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
        Parameter("limit", "u"),
        Parameter("low", "u"),
        Parameter("high", "u"),
    )
    what: ClassVar[str] = "saturation"
    origin: ClassVar[str] = "a range that is too narrow"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples clipped."""
        if self.low is None and self.high is None:
            return jnp.clip(samples, -self.limit, self.limit)
        return jnp.clip(samples, self.low, self.high)
