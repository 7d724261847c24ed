"""The rate ramp: a slope against coloured noise, given what the noise is."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ..curves import Design
from ._likelihood import Powers

# Several stretches are filled up to a multiple of these, to share what is compiled for them.
_STRETCHES_AT_A_TIME = 8


class RampData(NamedTuple):
    """What a record says of its slope, stretches one after another along the axis of modes."""

    #: Odd cosine coefficients [u], and those of a ramp of one u per sample.
    odd_modes: Float[Array, " modes"]
    ramp: Float[Array, " modes"]
    #: Variance of each coefficient for unit power of each noise term, shape (modes, 4).
    variance: Float[Array, "modes terms"]


def ramp_data(odd_modes: Float[Array, "stretches modes"], design: Design) -> RampData:
    """The odd modes of a record beside what its design expects of them.

    Stretches in which a ramp has no modes may follow.
    """
    stretches = len(odd_modes)
    empty = -stretches % _STRETCHES_AT_A_TIME if stretches > 1 else 0
    rows = ((0, empty), (0, 0))
    variance = jnp.pad(design.ramp_variance, (*rows, (0, 0)), constant_values=1)
    return RampData(
        jnp.pad(odd_modes, rows).ravel(),
        jnp.pad(design.ramp, rows).ravel(),
        variance.reshape(-1, variance.shape[-1]),
    )


def ramp_posterior(data: RampData, power: Powers) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Mean and standard deviation of the signed ramp [u per sample], noise powers given.

    Generalised least squares on the odd cosine coefficients, which are independent to a good
    approximation and hold all that a record knows of a slope. A random walk makes slopes of its
    own, of standard deviation K/sqrt(T): with K from the posterior, that is accounted for.
    """
    weight = data.ramp / (data.variance @ power)
    information = jnp.sum(weight * data.ramp)
    return jnp.sum(weight * data.odd_modes) / information, information**-0.5


@jax.jit
def draw_ramps(
    key: PRNGKeyArray, data: RampData, powers: Float[Array, "draws terms"]
) -> tuple[Float[Array, " draws"], Float[Array, ""]]:
    """One signed ramp for each draw of the noise, and the two-sided p-value of no ramp at all."""
    mean, deviation = jax.vmap(ramp_posterior, (None, 0))(data, powers)
    ramps = mean + deviation * jax.random.normal(key, mean.shape, mean.dtype)
    beyond = jnp.mean(jax.scipy.special.ndtr(-mean / deviation))
    return ramps, 2 * jnp.minimum(beyond, 1 - beyond)
