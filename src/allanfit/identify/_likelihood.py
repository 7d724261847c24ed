"""The likelihood of a binned spectrum, and its form as a sum of squares.

Each bin is the mean of nu independent ordinates, so that it is a Gamma variate of shape nu/2
about the model's mean. The model's mean is linear in the squared coefficients, which are called
`power` here: shape (4,) for Q, N, B, K.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

Powers = Float[Array, " terms"]


def log_likelihood(
    power: Powers,
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
) -> Float[Array, ""]:
    """Gamma log-likelihood, less that of a perfect fit: minus half the sum of squares below.

    In this form it is small near its maximum, so that float32 keeps its differences.
    """
    ratio = density / (expected @ power)
    # A third faster than log1p of the excess, and as exact: the ratio is what has been rounded.
    return -jnp.sum(shape * (ratio - 1 - jnp.log(ratio)))


def deviance_residuals(
    power: Powers,
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
) -> Float[Array, " bins"]:
    """Residuals whose sum of squares is -2 ln of the likelihood ratio to a perfect fit.

    The least-squares solution in them is the maximum-likelihood solution, skewness and all, which
    it is not for relative or logarithmic residuals where a bin has few degrees of freedom. For a
    Gamma variate, r^2 = 2 shape (y/m - 1 - ln(y/m)) (McCullagh and Nelder 1989, section 8.3).
    """
    excess = density / (expected @ power) - 1
    return jnp.sqrt(2 * shape) * excess * jnp.sqrt(_half_square(excess))


def _half_square(u: Float[Array, " bins"]) -> Float[Array, " bins"]:
    """(u - ln(1 + u))/u^2, from its series where the difference would cancel."""
    small = jnp.abs(u) < 0.02
    safe = jnp.where(small, 1.0, jnp.maximum(u, -1 + 1e-12))
    direct = (safe - jnp.log1p(safe)) / safe**2
    series = 1 / 2 - u * (1 / 3 - u * (1 / 4 - u * (1 / 5 - u * (1 / 6 - u / 7))))
    return jnp.where(small, series, direct)


def fisher_information(
    power: Powers, expected: Float[Array, "bins terms"], shape: Float[Array, " bins"]
) -> Float[Array, "terms terms"]:
    """Information on the powers: sum over bins of shape dm dm'/m^2."""
    # One product of a vector and a matrix that stays the same while powers change.
    row, column = np.triu_indices(len(power))
    upper = (shape / (expected @ power) ** 2) @ (expected[:, row] * expected[:, column])
    place = np.zeros((len(power), len(power)), int)
    place[row, column] = place[column, row] = np.arange(len(row))
    return upper[place]
