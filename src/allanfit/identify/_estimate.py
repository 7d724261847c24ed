"""From the samples of one sensor to its coefficients: least squares, then a posterior.

Everything here is pure JAX for one sensor; `vmap` serves many. Derivatives with respect to the
samples are those of the least-squares solution: a posterior's width is held fixed.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from ..compilation import platform, quick_to_compile
from ..curves import Design, Statistics, statistics, statistics_on_host, unit_scale
from ._ensemble import ensemble
from ._goodness import goodness_of_fit, score
from ._least_squares import LeastSquares, least_squares
from ._posterior import Target, coarse, coordinates, log_posterior, starting_points
from ._ramp import RampData, draw_ramps, ramp_data, ramp_posterior

# Twice the log-likelihood that a term must add to count as seen: 2.5 % of records without the
# term reach it, since half of them prefer the coefficient at zero.
RESOLVED_DEVIANCE = 3.84
# A ramp is claimed more reluctantly: what drives it is a mean, and every slow effect has one.
RESOLVED_RAMP_P = 0.005

# More lengths of stretches than that are not worth compiling for; more samples are, with which the
# host takes seconds longer.
_MOST_COMPILED, _MOST_ON_HOST = 4, 2**22
# More bins than 30 million samples make.
_BINS_AT_A_TIME = 112
_WALKERS = 32
_BURN_IN = 200
_DRAWS = 100
_THIN = 8


class Estimate(eqx.Module):
    """What is known of one sensor's coefficients, Q, N, B, K, R along axes of terms.

    All numbers are in the unit of the samples and seconds.
    """

    statistics: Statistics
    #: Least-squares coefficients, shape (5,); the ramp's is signed.
    least_squares: Float[Array, " terms"]
    #: Draws from the posterior, shape (draws, 5); the ramp's is signed.
    draws: Float[Array, "draws terms"]
    #: Sum of squares, and its rise when Q, N, B or K is left out, shapes () and (4,).
    deviance: Float[Array, ""]
    deviance_rise: Float[Array, " noise_terms"]
    #: Two-sided p-value of a zero ramp, and of a misfit as large as this one.
    ramp_p_value: Float[Array, ""]
    goodness_of_fit: Float[Array, ""]
    #: Standard deviations of Q^2 that the data ask for at zero Q: negative for a low-pass filter.
    quantization_score: Float[Array, ""]
    #: Whether the solver converged on finite data, and the sampler's acceptance.
    converged: Bool[Array, ""]
    acceptance: Float[Array, ""]

    @property
    def resolved(self) -> Bool[Array, "*sensors terms"]:
        """Which terms the record shows: the model with it is preferred to the one without."""
        seen = self.deviance_rise > RESOLVED_DEVIANCE
        ramp = self.ramp_p_value < RESOLVED_RAMP_P
        return jnp.concatenate([seen, ramp[..., None]], axis=-1)


def as_design_dtype(design: Design, dtype) -> Design:
    """The design with its floating arrays in the dtype of the samples."""
    return jax.tree.map(
        lambda leaf: jnp.asarray(leaf, dtype if jnp.issubdtype(leaf.dtype, jnp.floating) else None),
        design,
    )


def padded_bins(bins: int) -> int:
    """A number of bins that nearly all records share, for one compilation of what follows."""
    return bins + -bins % _BINS_AT_A_TIME


def target(found: Statistics, design: Design) -> Target:
    """The spectrum that the coefficients are fitted to.

    Bins of no weight fill it up, since what follows takes the longest to compile.
    """
    # A power of two, which rounds nothing.
    _, doublings = jnp.frexp(jax.lax.stop_gradient(jnp.median(found.density)))
    unit = jnp.ldexp(jnp.ones((), found.density.dtype), doublings // 2)
    padding = padded_bins(len(design.ordinates)) - len(design.ordinates)
    return Target(
        jnp.pad(found.density / unit**2, (0, padding), constant_values=1),
        jnp.pad(jnp.asarray(design.density), ((0, padding), (0, 0)), constant_values=1),
        jnp.pad(jnp.asarray(design.ordinates) / 2, (0, padding)),
        unit,
    )


@jax.jit
def solve(data: Target) -> LeastSquares:
    """The least-squares solution."""
    return least_squares(data.density, data.expected, data.shape)


def estimate(
    stretches: tuple[Float[Array, " _"], ...],
    design: Design,
    dt: float | Float[Array, ""],
    key: PRNGKeyArray,
) -> Estimate:
    """Identify one sensor from the stretches of its record, sampled every `dt` seconds.

    In two steps: the first depends on the lengths of the stretches, the second only on about how
    many bins they make. Where a program for these lengths is not worth its compilation the first is
    taken on the host, unless JAX traces it.
    """
    traced = any(isinstance(each, Tracer) for each in stretches)
    short = sum(each.size for each in stretches) <= _MOST_ON_HOST
    here = (short and platform() == "cpu") or len(stretches) > _MOST_COMPILED
    if here and not traced:
        found = statistics_on_host(tuple(map(np.asarray, stretches)), design)
        found = jax.tree.map(lambda leaf: leaf.astype(stretches[0].dtype), found)
    else:
        found = _reduce(stretches, design)
    return estimate_from(found, design, dt, key)


def estimate_from(
    found: Statistics, design: Design, dt: float | Float[Array, ""], key: PRNGKeyArray
) -> Estimate:
    """Identify one sensor from what its record left behind."""
    dtype = found.density.dtype
    data, ramp = prepare(found, design)
    return Estimate(statistics=found, **conclude(data, ramp, jnp.asarray(dt, dtype), key))


@quick_to_compile(eqx.filter_jit)
def _reduce(stretches: tuple[Float[Array, " _"], ...], design: Design) -> Statistics:
    return statistics(stretches, as_design_dtype(design, stretches[0].dtype))


@quick_to_compile(eqx.filter_jit)
def prepare(found: Statistics, design: Design) -> tuple[Target, RampData]:
    """What the fit asks of a record, in shapes that records of many lengths share."""
    design = as_design_dtype(design, found.density.dtype)
    data = target(found, design)
    return data, ramp_data(found.odd_modes / data.unit, design)


@quick_to_compile(jax.jit)
def conclude(
    data: Target, ramp: RampData, dt: Float[Array, ""], key: PRNGKeyArray
) -> dict[str, Array]:
    """All of an `Estimate` but its statistics."""
    solution, scale = solve(data), unit_scale(dt) * data.unit
    power = jax.lax.stop_gradient(solution.power)
    powers, acceptance = _fast_posterior(key, *jax.lax.stop_gradient((solution.power, data)))
    ramp_key = jax.random.fold_in(key, 1)
    ramps, ramp_p_value = draw_ramps(ramp_key, jax.lax.stop_gradient(ramp), powers)
    slope, _ = ramp_posterior(ramp, solution.power)
    # A square root has no derivative at zero; a coefficient at zero stays there.
    positive = solution.power > 0
    coefficients = jnp.where(positive, jnp.sqrt(jnp.where(positive, solution.power, 1.0)), 0.0)
    fitted = jnp.sum(positive)
    # Of samples that are NaN, or all alike, nothing is known.
    scale = jnp.where(jnp.isfinite(solution.deviance), scale, jnp.nan)
    return {
        "least_squares": jnp.append(coefficients, slope) * scale,
        "draws": jnp.concatenate([jnp.sqrt(powers), ramps[:, None]], axis=1) * scale,
        "deviance": solution.deviance,
        "deviance_rise": solution.deviance_without - solution.deviance,
        "ramp_p_value": ramp_p_value,
        "goodness_of_fit": goodness_of_fit(
            solution.deviance, data.shape, fitted.astype(scale.dtype)
        ),
        "quantization_score": score(power, data.density, data.expected, data.shape)[0],
        "converged": solution.converged,
        "acceptance": acceptance,
    }


def _fast_posterior(
    key: PRNGKeyArray, power: Float[Array, " terms"], data: Target
) -> tuple[Float[Array, "draws terms"], Float[Array, ""]]:
    space = coordinates(data, power)
    start_key, chain_key = jax.random.split(key)
    rough = coarse(data, power)

    def where_positive(x: Float[Array, " terms"]) -> Float[Array, ""]:
        # The posterior is even: walkers on one side of zero have smaller differences to go by.
        return jnp.where(jnp.all(x > 0), log_posterior(x, rough, space), -jnp.inf)

    chain, acceptance = ensemble(
        chain_key,
        lambda x: log_posterior(x, data, space),
        where_positive,
        starting_points(start_key, power, space, _WALKERS),
        burn_in=_BURN_IN,
        draws=_DRAWS,
        thin=_THIN,
    )
    return jax.vmap(space.power)(chain.reshape(-1, chain.shape[-1])), acceptance
