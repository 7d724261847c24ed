"""A straight line through readings, with the covariance of what it says."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ._outlier import studentized


class Line(NamedTuple):
    """Least squares of reading - reference = bias + slope reference, errors of equal size."""

    #: Bias and slope error, shape (2,), and their covariance, shape (2, 2).
    value: Float[Array, " 2"]
    covariance: Float[Array, "2 2"]
    #: What is left of the readings, shape (readings,).
    residual: Float[Array, " readings"]
    #: Each residual over a standard deviation estimated without it, shape (readings,).
    studentized: Float[Array, " readings"]


def straight_line(
    reference: Float[Array, " readings"],
    reading: Float[Array, " readings"],
    rounding: float | Float[Array, ""],
) -> Line:
    """Fit bias and slope error; the covariance has readings - 2 degrees of freedom.

    `rounding` is the least standard deviation that a reading has, for `studentized`.
    """
    unit = jnp.max(jnp.abs(reference))
    columns = jnp.stack([jnp.ones_like(reference), reference / unit], axis=1)
    inverse = jnp.linalg.inv(columns.T @ columns)
    value = inverse @ columns.T @ (reading - reference)
    residual = reading - reference - columns @ value
    freedom = reference.shape[0] - 2
    squares = jnp.sum(residual**2)
    leverage = jnp.sum((columns @ inverse) * columns, axis=1)
    scale = jnp.stack([jnp.ones_like(unit), 1 / unit])
    return Line(
        value=value * scale,
        covariance=squares / jnp.maximum(freedom, 1) * inverse * scale[:, None] * scale,
        residual=residual,
        studentized=studentized(residual, leverage, freedom, rounding),
    )
