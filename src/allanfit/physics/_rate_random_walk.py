"""Rate or acceleration random walk."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._term import AbstractNoiseTerm, Names, Sampling


class RateRandomWalk(AbstractNoiseTerm):
    """Random walk of coefficient K [u/sqrt(s)]: sigma^2(tau) = K^2 tau/3.

    S(f) = K^2/(2 pi^2 f^2) (IEEE Std 952, annex C, one-sided), here with the aliases that the
    sampled walk has: K^2 dt^2/(2 sin^2(pi f dt)), less K^2 dt^2/3 when the sensor averages.
    """

    coefficient: Float[Array, ""]
    symbol: ClassVar[str] = "K"
    names: ClassVar[Names] = Names("rate random walk", "acceleration random walk", "random walk")
    seconds_power: ClassVar[float] = -0.5

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """K^2 dt^2/(2 sin^2(pi f dt)), less a white K^2 dt^2/3 when averaged [u^2/Hz]."""
        point = 0.5 / jnp.sin(jnp.pi * frequency * dt) ** 2
        white = 0.0 if sampling == "point" else 1 / 3
        return (self.coefficient * dt) ** 2 * (point - white)

    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """K^2 tau/3 [u^2], times 1 + 1/(2 n^2) when point-sampled."""
        excess = 0.5 / cluster_size**2 if sampling == "point" else 0.0
        return self.coefficient**2 * cluster_size * dt / 3 * (1 + excess)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Sum of independent steps of variance K^2 dt, or its means over each interval.

        The mean of a Wiener process over a unit interval is its start plus half the step plus an
        independent normal of variance 1/12.
        """
        step_key, mean_key = jax.random.split(key)
        step = jax.random.normal(step_key, (samples,))
        walk = jnp.cumsum(step)
        if sampling == "averaged":
            walk += -step / 2 + 12**-0.5 * jax.random.normal(mean_key, (samples,))
        return self.coefficient * dt**0.5 * walk
