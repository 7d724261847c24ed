"""Does the model fit? The probability of a sum of squares as large as the one found."""

import jax
import jax.numpy as jnp
from jax.scipy.special import digamma, gammaincc, polygamma
from jaxtyping import Array, Float, Int

from ._likelihood import Powers, fisher_information

#: p-value below which a model is said not to fit.
MISFIT = 0.01


def goodness_of_fit(
    deviance: Float[Array, ""], shape: Float[Array, " bins"], fitted: Float[Array, ""]
) -> Float[Array, ""]:
    """p-value of the deviance of Gamma bins, after `fitted` parameters took their share.

    Where a bin has one degree of freedom its squared residual is no chi-square: it has mean
    2 a (ln a - psi(a)) and variance 4 a^2 (psi'(a) - 1/a) at shape a, cumulants of the Gamma
    distribution. The sum over bins is close to a scaled chi-square with the same two moments.
    """
    used = shape > 0
    shape = jnp.where(used, shape, 1.0)
    means = 2 * shape * (jnp.log(shape) - digamma(shape))
    variances = 4 * shape**2 * (polygamma(1, shape) - 1 / shape)
    mean = jnp.sum(means, where=used) - fitted
    variance = jnp.sum(variances, where=used) - 2 * fitted
    freedom = 2 * mean**2 / variance
    return gammaincc(freedom / 2, deviance * freedom / (2 * mean))


def score(
    power: Powers,
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
) -> Float[Array, " terms"]:
    """How many standard deviations of more, or less, of each term the data ask for.

    Rao's score of each squared coefficient with those that are present refitted. Negative for a
    term at zero: the data fall short of the others alone, which no noise of this kind can mend.
    """
    mean = expected @ power
    gradient = expected.T @ (shape * (density - mean) / mean**2)
    information = fisher_information(power, expected, shape)
    unit = jnp.sqrt(jnp.diag(information))
    correlation = information / unit / unit[:, None]
    present = power > 0

    def one(k: Int[Array, ""]) -> Float[Array, ""]:
        others = present & (jnp.arange(len(power)) != k)
        block = jnp.where(others[:, None] & others, correlation, jnp.eye(len(power)))
        row = jnp.where(others, correlation[k], 0.0)
        left = 1 - row @ jnp.linalg.solve(block, row)
        return gradient[k] / unit[k] / jnp.sqrt(jnp.maximum(left, 1e-9))

    return jax.vmap(one)(jnp.arange(len(power)))
