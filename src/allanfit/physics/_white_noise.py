"""Angle or velocity random walk: white noise in the rate or acceleration."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._term import AbstractNoiseTerm, Names, Sampling


class WhiteNoise(AbstractNoiseTerm):
    """White noise of density N [u/sqrt(Hz)]; integrated, the angle or velocity random walk.

    S(f) = 2 N^2 and sigma^2(tau) = N^2/tau (IEEE Std 952, annex C, angle random walk).
    """

    coefficient: Float[Array, ""]
    symbol: ClassVar[str] = "N"
    names: ClassVar[Names] = Names("angle random walk", "velocity random walk", "white noise")
    seconds_power: ClassVar[float] = 0.5

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """2 N^2 at every frequency [u^2/Hz]."""
        return 2 * self.coefficient**2 * jnp.ones_like(frequency)

    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """N^2/tau [u^2]."""
        return self.coefficient**2 / (cluster_size * dt)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Independent normal samples of variance N^2/dt."""
        return self.coefficient * dt**-0.5 * jax.random.normal(key, (samples,))
