"""The posterior of the coefficients, in coordinates that any sampler can walk in.

The likelihood is that of the least-squares fit. The prior is Jeffreys's for the four powers
together, so that intervals keep their coverage where few degrees of freedom stand behind a
coefficient and do not depend on whether one thinks of coefficients, their squares or their
logarithms. Below what the record can show, Jeffreys's prior is uniform in the power, which says
that a term is hardly ever much smaller than that; a factor

    (p + s)/(p + a s),  s: standard deviation of the power p

corrects this: between s and a s it makes the prior uniform in the logarithm. Most sensors have no
quantization noise to speak of, so that a = 1e-4 for Q, which amounts to even chances of its being
absent; white noise may drown in it, so that a = 1e-2 for N; some flicker and some random walk are
in every sensor, so that a = 0.3 for B and K. The values were chosen by the coverage of all
intervals, with each term absent, at the limit of what can be seen, and plain.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from ._elimination import log_determinant
from ._likelihood import Powers, fisher_information, log_likelihood

# a of the prior above, for Q, N, B and K.
_ABSENCE = np.array([1e-4, 1e-2, 0.3, 0.3])
# Bins that `coarse` makes one; a target is padded to a multiple of it.
_TOGETHER = 4


class Target(NamedTuple):
    """Data and expectations of one record, for powers in `unit`^2."""

    density: Float[Array, " bins"]
    expected: Float[Array, "bins terms"]
    shape: Float[Array, " bins"]
    #: In which the density is near one [u]: float32 has no squares of squares of other units.
    unit: Float[Array, ""]


def coarse(target: Target, power: Powers) -> Target:
    """The target with every four neighbouring bins in one, as if their ratios were known.

    Each bin is divided by its expectation at `power`. As expectations hardly bend within a bin of
    a quarter decade, the posterior is much the same, at a quarter of the cost.
    """

    def together(values: Float[Array, "bins *terms"]) -> Float[Array, "coarse_bins *terms"]:
        return jnp.sum(values.reshape(-1, _TOGETHER, *values.shape[1:]), axis=1)

    weight = target.shape / (target.expected @ power)
    shape = together(target.shape)
    used = shape > 0
    total = jnp.where(used, shape, 1.0)
    return Target(
        jnp.where(used, together(weight * target.density) / total, 1.0),
        jnp.where(used[:, None], together(weight[:, None] * target.expected) / total[:, None], 1.0),
        shape,
        target.unit,
    )


class Coordinates(NamedTuple):
    """theta_k = scale_k sinh(x_k): linear where a term cannot be seen, logarithmic where it can.

    The sign of x means nothing. A term that may be zero then has no wall at zero and no tail
    toward minus infinity, both of which slow every sampler down.
    """

    scale: Float[Array, " terms"]
    #: Standard deviations of the powers, s of the prior.
    deviation: Powers

    def power(self, x: Float[Array, " terms"]) -> Powers:
        """Squared coefficients at x."""
        return (self.scale * _sinh(x)) ** 2

    def position(self, power: Powers) -> Float[Array, " terms"]:
        """The non-negative x at these squared coefficients."""
        return jnp.arcsinh(jnp.sqrt(power) / self.scale)


def coordinates(target: Target, power: Powers) -> Coordinates:
    """Coordinates fit for a posterior about `power`."""
    information = fisher_information(power, target.expected, target.shape)
    unit = jnp.sqrt(jnp.diag(information))
    correlation = information / unit / unit[:, None]
    ridge = 1e-6 * jnp.eye(len(power), dtype=power.dtype)
    deviation = jnp.sqrt(jnp.diag(jnp.linalg.inv(correlation + ridge))) / unit
    return Coordinates(jnp.sqrt(jnp.asarray(_ABSENCE, power.dtype) * deviation), deviation)


def log_posterior(
    x: Float[Array, " terms"], target: Target, space: Coordinates
) -> Float[Array, ""]:
    """Log-density of x, up to a constant; even in each component."""
    sinh = _sinh(x)
    power = (space.scale * sinh) ** 2
    likelihood = log_likelihood(power, target.density, target.expected, target.shape)
    information = fisher_information(power, target.expected, target.shape)
    jeffreys = log_determinant(information) / 2
    absence = (power + space.deviation) / (power + space.scale**2)
    # d power/dx = scale^2 sinh 2x = 2 scale^2 sinh x cosh x, up to a constant.
    stretch = jnp.abs(sinh) * jnp.sqrt(1 + sinh**2)
    value = likelihood + jeffreys + jnp.sum(jnp.log(absence * stretch))
    return jnp.where(jnp.isfinite(value), value, -jnp.inf)


def _sinh(x: Float[Array, " terms"]) -> Float[Array, " terms"]:
    """Three times as fast as `jnp.sinh`, whose care for tiny x is not needed here."""
    growing = jnp.exp(x)
    return (growing - 1 / growing) / 2


def starting_points(
    key: PRNGKeyArray, power: Powers, space: Coordinates, walkers: int
) -> Float[Array, "walkers terms"]:
    """Positions scattered about an estimate as widely as its standard deviations say."""
    scatter = space.deviation * jax.random.normal(key, (walkers, len(power)), power.dtype)
    return jax.vmap(space.position)(jnp.abs(power + scatter))
