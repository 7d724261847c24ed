"""Does the model fit? The probability of a sum of squares as large as the one found."""

import jax
import jax.numpy as jnp
from jax.scipy.special import digamma, gammaincc, polygamma
from jaxtyping import Array, Float, Int

from ._likelihood import Powers, fisher_information

#: p-value below which a model is said not to fit.
MISFIT = 0.01
# From this shape on three terms of a series are exact to 1e-7.
_LARGE = 30.0


@jax.jit
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
    # Their series where differences would cancel.
    small = jnp.minimum(shape, _LARGE)
    means = 2 * small * (jnp.log(small) - digamma(small))
    variances = 4 * small**2 * (polygamma(1, small) - 1 / small)
    large = jnp.maximum(shape, _LARGE)
    means = jnp.where(shape < _LARGE, means, 1 + 1 / (6 * large) - 1 / (60 * large**3))
    variances = jnp.where(shape < _LARGE, variances, 2 + 2 / (3 * large) - 2 / (15 * large**3))
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
