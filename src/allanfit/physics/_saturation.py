"""Saturation: the end of the range."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractEffect, Parameter
from ._term import Sampling


class Saturation(AbstractEffect):
    """Samples stop at -limit and +limit [u]."""

    limit: Float[Array, ""]
    name: ClassVar[str] = "saturation"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("limit", "u"),)
    what: ClassVar[str] = "saturation"
    origin: ClassVar[str] = "a range that is too narrow"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples clipped."""
        return jnp.clip(samples, -self.limit, self.limit)
