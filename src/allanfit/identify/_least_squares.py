"""Least squares for coefficients that may be zero."""

import itertools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import lineax as lx
import numpy as np
import optimistix as optx
from jaxtyping import Array, Bool, Float

from ._elimination import solve_positive
from ._likelihood import Powers, deviance_residuals, fisher_information, log_likelihood

# Every choice of terms that are present, the empty one left out.
_FACES = np.array([face for face in itertools.product((False, True), repeat=4) if any(face)])
# Exponents of the largest value of each term, from which searches start.
_GRID = np.array(list(itertools.product((0.0, 0.5, 1.0), repeat=4)))
_SEARCH_STEPS, _BEST = 60, 4
_SCORING_STEPS = 40
_STEP_LENGTHS = np.array([1.0, 0.5, 0.2, 0.05, 0.01, 0.0])
_POLISHING_STEPS = 64
# Sums of squares change by no more than that when a coefficient changes by a factor of e.
_FLAT = 1e-4


class LeastSquares(NamedTuple):
    """The solution, and what it costs to leave each term out."""

    #: Squared coefficients, exactly zero where that fits best, shape (4,).
    power: Powers
    #: Sum of squares at the solution, and with each term left out, shapes () and (4,).
    deviance: Float[Array, ""]
    deviance_without: Float[Array, " terms"]
    #: Whether the solver met its tolerance, or hardly anything is to be gained any more.
    converged: Bool[Array, ""]


def least_squares(
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
) -> LeastSquares:
    """Fit non-negative squared coefficients to a binned spectrum.

    A coefficient that wants to be zero sits on a bound. Fisher scoring with the bounds inside
    finds which ones do: each step solves its quadratic problem exactly, by trying every face of
    the positive orthant, so that it cannot stop at a wrong corner. Optimistix then solves the
    least-squares problem in the logarithms of the others, to full precision and with derivatives
    by the implicit function theorem.
    """
    scale, largest = _envelopes(density, expected, shape)
    scaled = expected * scale
    constants = jax.lax.stop_gradient((density, scaled, shape))
    starts = _search(*constants, largest / scale)
    # All terms from each start, and each term left out.
    allowed = jnp.concatenate([jnp.ones(starts.shape, bool), ~jnp.eye(4, dtype=bool)])
    starts = jnp.concatenate([starts, jnp.tile(starts[0], (4, 1))])
    powers = jax.vmap(_score, (None, None, None, 0, 0))(*constants, allowed, starts)
    deviances = jax.vmap(
        lambda power: jnp.sum(deviance_residuals(power, density, scaled, shape) ** 2)
    )(powers)
    # Where two terms look alike scoring creeps; a solution on a face may then be ahead.
    start = powers[jnp.argmin(deviances)]
    # Rounding decides between zero and what is as good as zero; so it is made zero.
    part = jnp.max(scaled * start / (scaled @ start)[:, None], axis=0)
    present = part > float(jnp.finfo(density.dtype).eps) ** 0.75

    def residuals(log_power, data):
        misfit = deviance_residuals(
            jnp.where(present, jnp.exp(log_power), 0.0), data, scaled, shape
        )
        # Absent terms have no influence; holding them keeps the normal equations regular.
        return misfit, jnp.where(present, 0.0, log_power)

    tolerance = 10 * float(jnp.finfo(density.dtype).eps) ** 0.6
    solution = optx.least_squares(
        residuals,
        optx.LevenbergMarquardt(tolerance, tolerance, linear_solver=lx.Normal(lx.Cholesky())),
        jnp.where(present, jnp.log(jnp.where(present, start, 1.0)), 0.0),
        args=density,
        max_steps=_POLISHING_STEPS,
        throw=False,
    )
    power = jnp.where(present, jnp.exp(solution.value), 0.0)
    deviance = jnp.sum(deviance_residuals(power, density, scaled, shape) ** 2)
    # Where two terms look alike it creeps along a floor that is flat; there it has arrived too.
    slope = jax.grad(lambda log_power: jnp.sum(residuals(log_power, constants[0])[0] ** 2))
    flat = jnp.sum(jnp.abs(slope(jax.lax.stop_gradient(solution.value)))) < _FLAT
    return LeastSquares(
        power * scale,
        deviance,
        jnp.maximum(deviances[-4:], deviance),
        ((solution.result == optx.RESULTS.successful) | flat) & jnp.isfinite(deviance),
    )


def _envelopes(
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
) -> tuple[Powers, Powers]:
    """About the largest value of each term that nowhere stands above the data, or somewhere not.

    Five bins together have enough degrees of freedom not to touch zero by chance.
    """
    kernel = jnp.ones(5, density.dtype)
    together = jax.vmap(lambda column: jnp.convolve(column, kernel, "valid"), 1, 1)
    weight = shape[:, None]
    used = together(weight) > 0
    below = jnp.where(used, together(weight * expected), 1.0)
    ratio = together(weight * density[:, None]) / below
    lowest = jnp.min(ratio, axis=0, where=used, initial=jnp.inf)
    highest = jnp.max(ratio, axis=0, where=used, initial=0.0)
    return jax.lax.stop_gradient((lowest, highest))


def _search(
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
    largest: Powers,
) -> Float[Array, "starts terms"]:
    """Starts that reach the best maximum, the most likely one first, all terms positive.

    Where the model is right there is one maximum; where it is grossly wrong there are several, as
    a rule one for each choice of terms that could carry most of the record. From a grid of such
    choices multiplicative updates climb slowly, simply and never down (Févotte et al. 2009,
    Neural Comput. 21:793, section 4.1).
    """
    starts = largest ** jnp.asarray(_GRID, density.dtype)

    def step(power, _):
        mean = power @ expected.T
        ascent = (shape * density / mean**2) @ expected
        descent = (shape / mean) @ expected
        return power * jnp.sqrt(ascent / descent), None

    powers = jax.lax.scan(step, starts, None, length=_SEARCH_STEPS)[0]
    likelihood = jax.vmap(log_likelihood, (0, None, None, None))(powers, density, expected, shape)
    likelihood = jnp.where(jnp.isnan(likelihood), -jnp.inf, likelihood)
    return powers[jax.lax.top_k(likelihood, _BEST)[1]]


def _score(
    density: Float[Array, " bins"],
    expected: Float[Array, "bins terms"],
    shape: Float[Array, " bins"],
    allowed: Bool[Array, " terms"],
    start: Powers,
) -> Powers:
    """Fisher scoring within the positive orthant, the terms not `allowed` held at zero."""
    lengths = jnp.asarray(_STEP_LENGTHS, density.dtype)

    def step(power, _):
        mean = expected @ power
        gradient = expected.T @ (shape * (density - mean) / mean**2)
        target = _quadratic_maximum(
            fisher_information(power, expected, shape), gradient, power, allowed
        )
        candidates = power + lengths[:, None] * (target - power)
        likelihood = jax.vmap(log_likelihood, (0, None, None, None))(
            candidates, density, expected, shape
        )
        likelihood = jnp.where(jnp.isnan(likelihood), -jnp.inf, likelihood)
        return candidates[jnp.argmax(likelihood)], None

    return jax.lax.scan(step, jnp.where(allowed, start, 0.0), None, length=_SCORING_STEPS)[0]


def _quadratic_maximum(
    curvature: Float[Array, "terms terms"],
    gradient: Powers,
    power: Powers,
    allowed: Bool[Array, " terms"],
) -> Powers:
    """The maximum over non-negative powers of a quadratic, exactly, over its 15 faces."""
    linear = gradient + curvature @ power

    def on_face(face):
        free = face & allowed
        block = jnp.where(free[:, None] & free, curvature, jnp.diag(jnp.diag(curvature)))
        solution = solve_positive(block, jnp.where(free, linear, 0.0))
        value = linear @ solution - solution @ curvature @ solution / 2
        return solution, jnp.where(jnp.all(solution >= 0), value, -jnp.inf)

    solutions, values = jax.vmap(on_face)(jnp.asarray(_FACES))
    best = solutions[jnp.argmax(values)]
    return jnp.where(jnp.isfinite(jnp.max(values)), best, power)
