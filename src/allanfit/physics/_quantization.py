"""Quantization noise: rounding of the angle or velocity that the sensor counts."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from ._term import AbstractNoiseTerm, Names, Sampling


class QuantizationNoise(AbstractNoiseTerm):
    """White error of rms Q [u s] on the integral of the signal, seen in its differences.

    S(f) = 8 Q^2 sin^2(pi f dt)/dt and sigma^2(tau) = 3 Q^2/tau^2 at every tau (IEEE Std 952,
    annex C; the density there is the approximation for small f). It has nothing to do with the
    rounding of the output, which is white and adds to N.
    """

    coefficient: Float[Array, ""]
    symbol: ClassVar[str] = "Q"
    names: ClassVar[Names] = Names("quantization", "quantization", "quantization")
    seconds_power: ClassVar[float] = 1

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """8 Q^2 sin^2(pi f dt)/dt [u^2/Hz]."""
        return 8 * self.coefficient**2 * jnp.sin(jnp.pi * frequency * dt) ** 2 / dt

    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """3 Q^2/tau^2 [u^2]."""
        return 3 * self.coefficient**2 / (cluster_size * dt) ** 2

    def low_mode_ratio(
        self, order: Float[Array, "*shape"], samples: int | Int[Array, ""]
    ) -> Float[Array, "*shape"]:
        """1 + cot^2(pi j/(2 N))/N: the first and last angle errors cancel with no neighbour.

        The sum of squares of the angle errors' weights in the cosine coefficient.
        """
        return 1 + 1 / (samples * jnp.tan(jnp.pi * order / (2 * samples)) ** 2)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Differences of a white sequence of rms Q, divided by dt."""
        angle_error = jax.random.normal(key, (samples + 1,))
        return self.coefficient / dt * jnp.diff(angle_error)
