"""The posterior of the coefficients, in coordinates that any sampler can walk in.

The likelihood is that of the least-squares fit. The prior is Jeffreys's for N, B and K together,
so that intervals keep their coverage where few degrees of freedom stand behind a coefficient and
do not depend on whether one thinks of coefficients, their squares or their logarithms. For Q,
which many sensors do not have at all, it is uniform in the coefficient.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._likelihood import Powers, fisher_information, log_likelihood

_Q = 0


class Target(NamedTuple):
    """Data and expectations of one record, scaled so that every term matters near one."""

    density: Float[Array, " bins"]
    expected: Float[Array, "bins terms"]
    shape: Float[Array, " bins"]


class Coordinates(NamedTuple):
    """theta_k = scale_k sinh(x_k): linear where a term cannot be seen, logarithmic where it can.

    The sign of x means nothing. A term that may be zero then has no wall at zero and no tail
    toward minus infinity, both of which slow every sampler down.
    """

    scale: Float[Array, " terms"]

    def power(self, x: Float[Array, " terms"]) -> Powers:
        """Squared coefficients at x."""
        return (self.scale * jnp.sinh(x)) ** 2

    def position(self, power: Powers) -> Float[Array, " terms"]:
        """The non-negative x at these squared coefficients."""
        return jnp.arcsinh(jnp.sqrt(power) / self.scale)


def coordinates(target: Target, power: Powers) -> tuple[Coordinates, Powers]:
    """Coordinates fit for a posterior about `power`, and its standard deviations there."""
    information = fisher_information(power, target.expected, target.shape)
    unit = jnp.sqrt(jnp.diag(information))
    correlation = information / unit / unit[:, None]
    ridge = 1e-6 * jnp.eye(len(power), dtype=power.dtype)
    deviation = jnp.sqrt(jnp.diag(jnp.linalg.inv(correlation + ridge))) / unit
    return Coordinates(jnp.sqrt(deviation)), deviation


def log_posterior(
    x: Float[Array, " terms"], target: Target, space: Coordinates
) -> Float[Array, ""]:
    """Log-density of x, up to a constant; even in each component."""
    power = space.power(x)
    likelihood = log_likelihood(power, target.density, target.expected, target.shape)
    # Jeffreys: the root of the determinant of the information on the squares of N, B and K.
    information = fisher_information(power, target.expected, target.shape)[1:, 1:]
    jeffreys = _log_determinant(information) / 2
    # d power/dx = scale^2 sinh 2x; for Q, d theta/dx = scale cosh x.
    stretch = jnp.log(jnp.abs(jnp.sinh(2 * x[1:]))).sum() + jnp.log(jnp.cosh(x[_Q]))
    value = likelihood + jeffreys + stretch
    return jnp.where(jnp.isfinite(value), value, -jnp.inf)


def _log_determinant(matrix: Float[Array, "3 3"]) -> Float[Array, ""]:
    """Of a positive matrix, written out: LAPACK takes ten times as long for three by three."""
    variance = jnp.diag(matrix)
    unit = matrix * jax.lax.rsqrt(variance) * jax.lax.rsqrt(variance)[:, None]
    a, b, c = unit[0, 1], unit[0, 2], unit[1, 2]
    determinant = 1 + 2 * a * b * c - a**2 - b**2 - c**2
    return jnp.sum(jnp.log(variance)) + jnp.log(jnp.maximum(determinant, 1e-12))


def starting_points(
    key: PRNGKeyArray, power: Powers, deviation: Powers, space: Coordinates, walkers: int
) -> Float[Array, "walkers terms"]:
    """Positions scattered about an estimate as widely as its standard deviations say."""
    scatter = deviation * jax.random.normal(key, (walkers, len(power)), power.dtype)
    return jax.vmap(space.position)(jnp.abs(power + scatter))
