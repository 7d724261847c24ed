"""Times at which the sensor was not at rest."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractEffect, Parameter
from ._intervals import backwards
from ._term import Sampling


class Disturbance(AbstractEffect):
    """Within `intervals` [s] the samples are of a motion, and say nothing about the sensor.

    They are to be left out; a motion that was never known cannot be made again, so that
    `apply` returns its samples as they are.
    """

    intervals: Float[Array, "intervals 2"]
    name: ClassVar[str] = "disturbance"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("intervals", "s", kind="intervals"),)
    what: ClassVar[str] = "a disturbance: the sensor was moved or knocked"
    origin: ClassVar[str] = "handling, a door, a passer-by"

    def contradiction(self) -> str:
        """Intervals that end before they start."""
        return backwards(self.intervals)

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The samples themselves."""
        return jnp.asarray(samples)
