"""A noise model: the sum of its terms."""

from collections.abc import Mapping

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._bias_instability import BiasInstability
from ._quantization import QuantizationNoise
from ._rate_ramp import RateRamp
from ._rate_random_walk import RateRandomWalk
from ._term import AbstractNoiseTerm, Sampling
from ._white_noise import WhiteNoise

#: The five standard terms in the order in which every table prints them.
STANDARD_TERMS: tuple[type[AbstractNoiseTerm], ...] = (
    QuantizationNoise,
    WhiteNoise,
    BiasInstability,
    RateRandomWalk,
    RateRamp,
)
SYMBOLS = tuple(term.symbol for term in STANDARD_TERMS)


class NoiseModel(eqx.Module):
    """Independent terms whose densities and Allan variances add."""

    terms: tuple[AbstractNoiseTerm, ...]

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """One-sided spectral density of the sum [u^2/Hz]."""
        return sum(
            (term.density(frequency, dt, sampling) for term in self.terms),
            jnp.zeros_like(frequency),
        )

    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """Expected Allan variance of the sum [u^2]."""
        return sum(
            (term.allan_variance(cluster_size, dt, sampling) for term in self.terms),
            jnp.zeros_like(cluster_size),
        )

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Draw the sum; each term has a key of its own, so adding one leaves the others alone."""
        return sum(
            (
                term.sample(jax.random.fold_in(key, index), samples, dt, sampling)
                for index, term in enumerate(self.terms)
            ),
            jnp.zeros(samples),
        )


def standard_model(coefficients: Mapping[str, float | Float[Array, ""]]) -> NoiseModel:
    """The five-term model from coefficients by symbol; what is not named is zero."""
    unknown = sorted(set(coefficients) - set(SYMBOLS))
    if unknown:
        raise ValueError(f"unknown coefficient {unknown[0]!r}; the five are {', '.join(SYMBOLS)}")
    return NoiseModel(
        tuple(term(jnp.asarray(coefficients.get(term.symbol, 0.0))) for term in STANDARD_TERMS)  # pyright: ignore[reportCallIssue]  (every term has this one field)
    )
