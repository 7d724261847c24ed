"""Generalised least squares of a record's slow changes on those of its temperature.

The cosine coefficients of the noise are nearly independent, each with the variance that the noise
model gives its frequency, so that least squares with these weights is generalised least squares
with the full covariance of the coloured noise (Aitken 1935, Proc. R. Soc. Edinb. 55:42).
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

# Draws of the slopes for each draw of the noise that is used.
_REPEATS = 8


class Modes(NamedTuple):
    """Slow cosine coefficients, the stretches of a record one after another."""

    #: Of the record [u].
    response: Float[Array, " modes"]
    #: Of what may move it, one column each.
    columns: Float[Array, "modes columns"]
    #: Variance of each coefficient per unit power of Q, N, B and K.
    variance: Float[Array, "modes terms"]


class Effects(NamedTuple):
    """What the noise leaves to be known of the last two columns."""

    #: Draws from the posterior under a uniform prior, [u per unit of the column].
    draws: Float[Array, "draws two"]
    #: Two-sided p-value of each being zero, and of both.
    p_values: Float[Array, " two"]
    p_value: Float[Array, ""]


def regress(
    modes: Modes, power: Float[Array, " terms"]
) -> tuple[Float[Array, " columns"], Float[Array, "columns columns"]]:
    """Slopes and their covariance for given noise powers."""
    whitened = modes.columns / jnp.sqrt(modes.variance @ power)[:, None]
    length = jnp.sqrt(jnp.sum(whitened**2, axis=0))
    unit = whitened / length
    inverse = jnp.linalg.inv(unit.T @ unit)
    slopes = inverse @ (unit.T @ (modes.response / jnp.sqrt(modes.variance @ power)))
    return slopes / length, inverse / length / length[:, None]


@jax.jit
def effects(key: PRNGKeyArray, modes: Modes, powers: Float[Array, "draws terms"]) -> Effects:
    """Slopes of the last two columns, averaged over draws of what the noise may be.

    Given the noise the slopes are normal. Over its posterior they are a mixture of normals, with
    the heavier tails that few degrees of freedom ask for; each p-value is the mixture's tail.
    """
    mean, covariance = jax.vmap(regress, (None, 0))(modes, powers)
    mean, covariance = mean[:, -2:], covariance[:, -2:, -2:]
    deviation = jnp.sqrt(jnp.diagonal(covariance, axis1=1, axis2=2))
    beyond = jnp.mean(jax.scipy.special.ndtr(-mean / deviation), axis=0)
    factor = jnp.linalg.cholesky(covariance)
    standardised = jax.scipy.linalg.solve_triangular(factor, mean[..., None], lower=True)[..., 0]
    # The tail of a chi-square with two degrees of freedom.
    joint = jnp.mean(jnp.exp(-jnp.sum(standardised**2, axis=1) / 2))
    normal = jax.random.normal(key, (_REPEATS, *mean.shape), mean.dtype)
    draws = mean + jnp.einsum("dij,rdj->rdi", factor, normal)
    return Effects(draws.reshape(-1, 2), 2 * jnp.minimum(beyond, 1 - beyond), joint)


@jax.jit
def share_of_ramp(modes: Modes, power: Float[Array, " terms"]) -> Float[Array, ""]:
    """Part of what would be known of the second column that is lost because the first is unknown.

    Between 0 and 1, which is where the two cannot be told apart.
    """
    _, covariance = regress(modes, power)
    _, alone = regress(modes._replace(columns=modes.columns[:, 1:]), power)
    return 1 - alone[0, 0] / covariance[1, 1]


@jax.jit
def explained(
    key: PRNGKeyArray,
    modes: Modes,
    slow: Float[Array, " modes"],
    slopes: Float[Array, " two"],
    power: Float[Array, " terms"],
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """The fraction of slow variance that two slopes explain, and what chance would explain.

    Both the record and the effect are taken without their straight line in time: beside a ramp
    that is free, a slope may make any line, and the ramp then takes it back. `slow` is 1 for the
    modes that count and 0 for the others. The second number is exceeded by one in twenty records
    of the same noise that temperature does not move.
    """
    ramp = slow * modes.columns[:, 0]

    def bent(response: Array) -> Array:
        seen = slow * response
        return seen - ramp * (ramp @ seen) / (ramp @ ramp)

    def fraction(response: Array, slopes: Array) -> Array:
        left = jnp.sum(bent(response - modes.columns[:, -2:] @ slopes) ** 2)
        # Weights that suit the noise are not those of this sum, which may grow.
        return jnp.maximum(0.0, 1 - left / jnp.sum(bent(response) ** 2))

    def by_chance(key: PRNGKeyArray) -> Array:
        shape, dtype = modes.response.shape, modes.response.dtype
        noise = jnp.sqrt(modes.variance @ power) * jax.random.normal(key, shape, dtype)
        found, _ = regress(modes._replace(response=noise), power)
        return fraction(noise, found[-2:])

    chance = jax.vmap(by_chance)(jax.random.split(key, 400))
    return fraction(modes.response, slopes), jnp.quantile(chance, 0.95)
