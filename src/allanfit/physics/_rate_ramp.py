"""Rate or acceleration ramp: a constant drift, a mean and not a noise."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._term import AbstractNoiseTerm, Names, Sampling


class RateRamp(AbstractNoiseTerm):
    """The mean R t, R in u/s: sigma^2(tau) = R^2 tau^2/2.

    It has no spectral density: the R^2/(2 pi f)^3 that IEEE Std 952 prints does not lead to this
    Allan variance, and a periodogram cannot tell a ramp from a random walk with K^2 = R^2 T/2.
    """

    coefficient: Float[Array, ""]
    symbol: ClassVar[str] = "R"
    names: ClassVar[Names] = Names("rate ramp", "acceleration ramp", "ramp")
    seconds_power: ClassVar[float] = -1

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """Zero: a mean is no part of the density."""
        return jnp.zeros_like(frequency)

    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """R^2 tau^2/2 [u^2]."""
        return (self.coefficient * cluster_size * dt) ** 2 / 2

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """R t; nothing is drawn."""
        return self.coefficient * dt * jnp.arange(samples)
