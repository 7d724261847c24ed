"""Does the model fit? The probability of a sum of squares as large as the one found."""

import jax.numpy as jnp
from jax.scipy.special import digamma, gammaincc, polygamma
from jaxtyping import Array, Float


def goodness_of_fit(
    deviance: Float[Array, ""], shape: Float[Array, " bins"], fitted: Float[Array, ""]
) -> Float[Array, ""]:
    """p-value of the deviance of Gamma bins, after `fitted` parameters took their share.

    Where a bin has one degree of freedom its squared residual is no chi-square: it has mean
    2 a (ln a - psi(a)) and variance 4 a^2 (psi'(a) - 1/a) at shape a, cumulants of the Gamma
    distribution. The sum over bins is close to a scaled chi-square with the same two moments.
    """
    mean = jnp.sum(2 * shape * (jnp.log(shape) - digamma(shape))) - fitted
    variance = jnp.sum(4 * shape**2 * (polygamma(1, shape) - 1 / shape)) - 2 * fitted
    freedom = 2 * mean**2 / variance
    return gammaincc(freedom / 2, deviance * freedom / (2 * mean))
