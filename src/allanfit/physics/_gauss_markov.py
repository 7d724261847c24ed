"""Exponentially correlated noise, the first-order Gauss-Markov process."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractAddedNoise, Parameter
from ._term import Sampling


class GaussMarkov(AbstractAddedNoise):
    """Autocovariance sigma^2 exp(-|t|/T_c): S(f) = 4 sigma^2 T_c/(1 + (2 pi f T_c)^2).

    IEEE Std 952, annex C, correlated noise; here with the aliases of its sampled form. Its Allan
    deviation peaks at 0.62 sigma near tau = 1.9 T_c.
    """

    sigma: Float[Array, ""]
    correlation_time: Float[Array, ""]
    name: ClassVar[str] = "gauss_markov"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("sigma", "u"),
        Parameter("correlation_time", "s"),
    )
    scale: ClassVar[tuple[str, int]] = ("sigma", 2)
    what: ClassVar[str] = "exponentially correlated noise (a Gauss-Markov process)"
    origin: ClassVar[str] = "trapped charge, a control loop or a package that relaxes"

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """2 dt sigma^2 (1 - phi^2)/(1 - 2 phi cos(2 pi f dt) + phi^2), phi = exp(-dt/T_c)."""
        rate = dt / self.correlation_time
        decay, gap = jnp.exp(-rate), -jnp.expm1(-rate)
        sine = jnp.sin(jnp.pi * frequency * dt) ** 2
        point = 2 * dt * -jnp.expm1(-2 * rate) / (gap**2 + 4 * decay * sine)
        if sampling == "point":
            return self.sigma**2 * point
        # The mean over the interval: the same shape and a white part (integrals of exp(-|t|/T_c)).
        variance = 2 * (rate - gap) / rate**2
        shaped = 2 * (jnp.cosh(rate) - 1) / rate**2
        return self.sigma**2 * (2 * dt * (variance - shaped) + shaped * point)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The exact recursion, begun in its stationary state."""
        decay = jnp.exp(-dt / self.correlation_time)
        drive = jax.random.normal(key, (samples,))
        drive = drive.at[1:].multiply(jnp.sqrt(-jnp.expm1(-2 * dt / self.correlation_time)))

        def step(state, noise):
            state = decay * state + noise
            return state, state

        return self.sigma * jax.lax.scan(step, jnp.zeros(()), drive)[1]
