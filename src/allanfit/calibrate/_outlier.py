"""Which reading stands out from what fits the others."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.stats import t

# Family-wise, over the readings of a fit.
_FALSE_ALARM = 0.01


def studentized(
    residual: Float[Array, " readings"],
    leverage: Float[Array, " readings"],
    freedom: int,
    rounding: float | Float[Array, ""],
) -> Float[Array, " readings"]:
    """Each residual of least squares over a standard deviation estimated without it.

    The externally studentized residual of reading i is r_i/(s_i sqrt(1 - h_ii)), with the
    leverage h_ii and s_i^2 = (r'r - r_i^2/(1 - h_ii))/(freedom - 1): Student's t with
    freedom - 1 degrees of freedom (Belsley, Kuh and Welsch 1980, Regression Diagnostics, 2.1).
    `freedom` is readings less parameters, and `rounding` the standard deviation that no reading can
    have less of: of numbers that fit exactly, what rounding left would stand out.
    """
    share = residual**2 / (1 - leverage)
    # Rounding alone may leave less than nothing.
    without = jnp.maximum(jnp.sum(residual**2) - share, 0.0) / max(freedom - 1, 1)
    variance = jnp.maximum(without, rounding**2)
    return residual / jnp.sqrt(variance * (1 - leverage))


def rounding(readings: Float[np.ndarray, "..."]) -> float:
    """Standard deviation of the rounding of decimal numbers, uniform in the last digit of any.

    That of floating-point numbers if these are coarser.
    """
    spacing = float(np.spacing(np.abs(readings).max()))
    for places in range(16):
        scaled = readings * 10.0**places
        # A change of unit and back leaves a few units in the last place.
        if np.all(np.abs(scaled - np.rint(scaled)) <= 4 * np.spacing(np.abs(scaled))):
            return max(10.0**-places, 4 * spacing) / 12**0.5
    return 4 * spacing / 12**0.5


def stands_out(studentized: Float[np.ndarray, "*readings"], freedom: int) -> int | None:
    """The flat index of the largest, if one fit in a hundred would show such a one by chance."""
    sizes = np.where(np.isfinite(studentized), np.abs(studentized), 0.0)
    if freedom < 2 or 2 * t.sf(sizes.max(), freedom - 1) * sizes.size > _FALSE_ALARM:
        return None
    return int(np.argmax(sizes))
