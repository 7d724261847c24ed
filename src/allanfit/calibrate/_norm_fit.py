"""A triad at rest reads gravity in every position: what that tells of its errors.

The model is that of Tedaldi, Pretto and Menegatti (2014, ICRA, A robust and easy to implement
method for IMU calibration without external equipments, eqs. 2 to 4 and 10):

    a = T K (y - b),   T = [[1, -alpha_yz, alpha_zy], [0, 1, -alpha_zx], [0, 0, 1]],

with the reading y, the bias b (there with the other sign) and K = diag(1/(1 + S)), so that a
single axis reads y = (1 + S) a + b. The x axis is the sensor's own, and y lies in the plane of
its x and y axes: three angles remain. |a| = g in every position whatever its attitude.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float

#: In the order of the parameters.
PARAMETERS = (
    *(f"bias of {axis}" for axis in "xyz"),
    *(f"scale factor of {axis}" for axis in "xyz"),
    "alpha_yz",
    "alpha_zy",
    "alpha_zx",
)
#: Without the three angles.
ORTHOGONAL = 6

# Far below any sensor, in units of gravity and radians, and above rounding.
_TOLERANCE = 1e-10
_MOST_STEPS = 100
# A parameter may be this much of its standard error from the solution, and no further.
_NEAR_ENOUGH = 1e-3
# No sensor is finer, in units of gravity; the residuals of an exact fit are.
_FINEST = 1e-7


class NormFit(NamedTuple):
    """Solution of a least-squares fit of the norm, in units of gravity and radians."""

    #: b/g, S and the angles, shape (9,) or (6,), and the inverse of J'J.
    value: Float[Array, " parameters"]
    inverse: Float[Array, "parameters parameters"]
    #: |a|/g - 1 in each position, shape (positions,).
    residual: Float[Array, " positions"]
    converged: Bool[Array, ""]


def correction_matrix(parameters: Float[Array, " parameters"]) -> Float[Array, "3 3"]:
    """T K; the angles are zero if there are none among the parameters."""
    yz, zy, zx = parameters[6:] if parameters.shape[0] > ORTHOGONAL else jnp.zeros(3)
    one, zero = jnp.ones_like(yz), jnp.zeros_like(yz)
    triangle = jnp.array([[one, -yz, zy], [zero, one, -zx], [zero, zero, one]])
    return triangle / (1 + parameters[3:6])


def norm_residual(
    parameters: Float[Array, " parameters"], readings: Float[Array, "positions 3"]
) -> Float[Array, " positions"]:
    """|T K (y - b)| - 1 of readings in units of gravity."""
    corrected = (readings - parameters[:3]) @ correction_matrix(parameters).T
    return jnp.linalg.norm(corrected, axis=1) - 1


def jacobian(
    parameters: Float[Array, " parameters"], readings: Float[Array, "positions 3"]
) -> Float[Array, "positions parameters"]:
    """Derivatives of the residuals."""
    return jax.jacfwd(norm_residual)(parameters, readings)


def fit_norm(readings: Float[Array, "positions 3"], start: Float[Array, " parameters"]) -> NormFit:
    """Levenberg-Marquardt from `start`, zeros of shape (9,) or (6,) for orthogonal axes."""
    solution = optx.least_squares(
        norm_residual,
        optx.LevenbergMarquardt(rtol=_TOLERANCE, atol=_TOLERANCE),
        start,
        args=readings,
        max_steps=_MOST_STEPS,
        throw=False,
    )
    slopes = jacobian(solution.value, readings)
    residual = norm_residual(solution.value, readings)
    inverse = jnp.linalg.inv(slopes.T @ slopes)
    # Where the sum of squares is flat to rounding the solver takes no step and never stops, so
    # that not its word counts but the length of the step that Gauss and Newton would take next.
    gradient = slopes.T @ residual
    variance = jnp.mean(residual**2) + _FINEST**2
    return NormFit(
        value=solution.value,
        inverse=inverse,
        residual=residual,
        converged=gradient @ inverse @ gradient < _NEAR_ENOUGH**2 * variance,
    )
