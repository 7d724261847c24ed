"""The rate ramp: a slope against coloured noise, given what the noise is."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ..curves import Design
from ._likelihood import Powers


def ramp_posterior(
    odd_modes: Float[Array, "stretches modes"], power: Powers, design: Design
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Mean and standard deviation of the signed ramp [u per sample], noise powers given.

    Generalised least squares on the odd cosine coefficients, which are independent to a good
    approximation and hold all that a record knows of a slope. A random walk makes slopes of its
    own, of standard deviation K/sqrt(T): with K from the posterior, that is accounted for.
    """
    weight = design.ramp / (jnp.asarray(design.ramp_variance, power.dtype) @ power)
    information = jnp.sum(weight * design.ramp)
    return jnp.sum(weight * odd_modes) / information, information**-0.5


def draw_ramps(
    key: PRNGKeyArray,
    odd_modes: Float[Array, "stretches modes"],
    powers: Float[Array, "draws terms"],
    design: Design,
) -> tuple[Float[Array, " draws"], Float[Array, ""]]:
    """One signed ramp for each draw of the noise, and the two-sided p-value of no ramp at all."""
    mean, deviation = jax.vmap(ramp_posterior, (None, 0, None))(odd_modes, powers, design)
    ramps = mean + deviation * jax.random.normal(key, mean.shape, mean.dtype)
    beyond = jnp.mean(jax.scipy.special.ndtr(-mean / deviation))
    return ramps, 2 * jnp.minimum(beyond, 1 - beyond)
