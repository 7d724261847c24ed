"""A triad in known attitudes: a straight line in three variables for each axis."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float


class AttitudeFit(NamedTuple):
    """Least squares of y = b + C a; everything in units of gravity, axes first."""

    #: b of each axis and the rows of C, shapes (3,) and (3, 3).
    bias: Float[Array, " 3"]
    matrix: Float[Array, "3 3"]
    #: Of (b, C_i1, C_i2, C_i3), without the variance of the noise: alike for each axis i.
    inverse: Float[Array, "4 4"]
    #: Shape (positions, 3).
    residual: Float[Array, "positions 3"]


def fit_attitudes(
    readings: Float[Array, "positions 3"], reference: Float[Array, "positions 3"]
) -> AttitudeFit:
    """Linear least squares; each axis has positions - 4 degrees of freedom."""
    columns = attitude_columns(reference)
    inverse = jnp.linalg.inv(columns.T @ columns)
    found = inverse @ columns.T @ readings
    return AttitudeFit(found[0], found[1:].T, inverse, readings - columns @ found)


def attitude_columns(reference: Float[Array, "positions 3"]) -> Float[Array, "positions 4"]:
    """What bias and matrix are multiplied with."""
    return jnp.concatenate([jnp.ones_like(reference[:, :1]), reference], axis=1)
