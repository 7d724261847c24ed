"""The temperature of the sensor."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, AbstractEffect, Parameter
from ._gauss_markov import GaussMarkov
from ._term import Sampling

# Heating and air conditioning take 10 to 60 minutes.
_ROOM_S = 1800.0


class Temperature(AbstractEffect):
    """The bias follows the temperature with `sensitivity` [u/K], over `time_scale` [s].

    With a `quadratic` [u/K^2] it follows the square of the temperature's distance from its mean
    too. A recording with a temperature channel gives these, one without a time scale alone. A
    simulation has no room: `apply` draws the temperature as a Gauss-Markov process of 1 K rms with
    the time scale, half an hour if none is known. Without either nothing is known of the size, and
    it adds nothing.
    """

    sensitivity: Float[Array, ""] | None = None
    time_scale: Float[Array, ""] | None = None
    quadratic: Float[Array, ""] | None = None
    name: ClassVar[str] = "temperature"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("sensitivity", "u/K", range=SIGNED),
        Parameter("time_scale", "s"),
        Parameter("quadratic", "u/K^2", range=SIGNED),
    )
    what: ClassVar[str] = "a bias that follows the temperature"
    origin: ClassVar[str] = "the room, or the heat of the electronics"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples and the bias of a drawn temperature."""
        if self.sensitivity is None and self.quadratic is None:
            return samples
        linear, quadratic = (0.0 if x is None else x for x in (self.sensitivity, self.quadratic))
        scale = jnp.asarray(_ROOM_S) if self.time_scale is None else self.time_scale
        kelvin = GaussMarkov(jnp.ones(()), scale).sample(key, samples.shape[0], dt, sampling)
        return samples + linear * kelvin + quadratic * (kelvin**2 - 1)
