"""The warming up of a sensor that has been switched on."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._effect import SIGNED, AbstractMean, Parameter


class WarmUp(AbstractMean):
    """A exp(-t/time_constant), t since the first sample: what is still to go of a settling."""

    amplitude: Float[Array, ""]
    time_constant: Float[Array, ""]
    name: ClassVar[str] = "warm_up"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u", range=SIGNED),
        Parameter("time_constant", "s"),
    )
    what: ClassVar[str] = "an exponential settling (a warm-up)"
    origin: ClassVar[str] = "a sensor that heats itself after it has been switched on"

    def mean(self, time: Float[Array, " samples"]) -> Float[Array, " samples"]:
        """A exp(-t/time_constant) [u]."""
        return self.amplitude * jnp.exp(-time / self.time_constant)
