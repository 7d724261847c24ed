"""Checks that every curve makes of the array that it is given."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


def as_series(
    data: Float[Array, "*sensors samples"] | np.ndarray, rate_hz: float
) -> Float[Array, "*sensors samples"]:
    """`data` as a floating array of one or two axes, in the dtype it has.

    Values are not looked at, since they may be traced: a NaN in a sensor makes that sensor's
    result NaN and leaves the others as they are.
    """
    if isinstance(data, np.ndarray) and data.dtype == np.float64 and data.ndim in (1, 2):
        # Without x64, JAX rounds to float32: a large mean would drown the noise. No curve needs it.
        finite = np.isfinite(data)
        total = np.sum(data, axis=-1, keepdims=True, where=finite)
        data = data - total / np.maximum(np.sum(finite, axis=-1, keepdims=True), 1)
    series = jnp.asarray(data)
    if series.ndim not in (1, 2):
        raise ValueError(
            "data must have shape (samples,) for one sensor or (sensors, samples) for several; "
            f"got shape {series.shape}"
        )
    if jnp.iscomplexobj(series) or series.dtype == bool:
        raise ValueError(f"data must be real numbers; got {series.dtype}")
    if not jnp.issubdtype(series.dtype, jnp.floating):
        series = series.astype(float)
    if series.shape[-1] < 3:
        raise ValueError(f"data has {series.shape[-1]} samples; an Allan variance needs at least 3")
    if isinstance(rate_hz, int | float) and not rate_hz > 0:
        raise ValueError(f"rate_hz must be positive, in samples per second; got {rate_hz}")
    return series
