"""Checks that every curve makes of the array that it is given."""

import math
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float


def as_series(
    data: Float[Array, "*sensors samples"] | np.ndarray | Sequence,
    rate_hz: float,
    *,
    single: bool = False,
) -> Float[Array, "*sensors samples"]:
    """`data` as a floating array of one or two axes, in the precision that JAX is set to.

    A fit needs all its numbers in one precision, and its design has that of JAX; a curve keeps
    float32 where `single` says so, and the memory that it saves.

    Values are not looked at, since they may be traced: a NaN in a sensor makes that sensor's
    result NaN and leaves the others as they are.

    **Raises:** `ValueError` for another shape, fewer than three samples, what is no real number,
    and a rate that is not above zero.
    """
    narrow = single or jnp.result_type(float) == np.float32
    series = data if isinstance(data, jax.Array) else _centred(np.asarray(data), narrow)
    if series.ndim not in (1, 2):
        raise ValueError(
            "data must have shape (samples,) for one sensor or (sensors, samples) for several; "
            f"got shape {series.shape}"
        )
    if jnp.iscomplexobj(series) or series.dtype == bool:
        raise ValueError(f"data must be real numbers; got {series.dtype}")
    fewest_bytes = 4 if narrow else 8
    if not jnp.issubdtype(series.dtype, jnp.floating) or series.dtype.itemsize < fewest_bytes:
        series = series.astype(float)
    if series.shape[-1] < 3:
        raise ValueError(f"data has {series.shape[-1]} samples; an Allan variance needs at least 3")
    if not (isinstance(rate_hz, Tracer) or _positive(rate_hz)):
        raise ValueError(
            f"rate_hz must be a positive number of samples per second; got {rate_hz!r}"
        )
    return series


def _centred(data: np.ndarray, narrow: bool) -> Array:
    """Less its mean, which no curve needs, in the precision that JAX is set to.

    Without x64, JAX rounds to float32, and wraps whole numbers: a large mean would drown the noise.
    Where that is `narrow`, float32 is subtracted from as it is, in half the memory.
    """
    if data.dtype.kind not in "iufcb":
        raise ValueError(f"data must be real numbers; got {data.dtype}")
    if data.dtype.kind in "iuf" and data.ndim:
        finite = np.isfinite(data)
        total = np.sum(data, axis=-1, keepdims=True, where=finite, dtype=float)
        mean = total / np.maximum(np.sum(finite, axis=-1, keepdims=True), 1)
        kind = np.float32 if narrow and data.dtype == np.float32 else np.float64
        data = np.subtract(data, mean.astype(kind), dtype=kind)
    return jnp.asarray(data)


def _positive(rate_hz: object) -> bool:
    try:
        return 0 < float(rate_hz) < math.inf and not isinstance(rate_hz, str)  # pyright: ignore
    except (TypeError, ValueError):
        return False
