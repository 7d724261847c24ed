"""Recordings out of whatever the caller has: a file, a `Recording` or an array."""

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..recording import Channel, Recording, load
from ..recording._units import parse_unit

#: A file, a `Recording`, or samples of shape (samples,) or (samples, 3), in any array or list.
Data = Recording | ArrayLike | str | os.PathLike[str]


def as_recording(
    data: Data,
    rate_hz: float | None,
    channels: Sequence[str] | None,
    unit: str | None,
    topic: str | None,
) -> Recording:
    """The recording, checked; arrays are in `unit`, m/s^2 if there is none.

    **Raises:** `ValueError` for an array without a rate or of a wrong shape, and what
    `allanfit.load` raises.
    """
    if isinstance(data, Recording):
        return data
    if isinstance(data, str | os.PathLike):
        return load(data, rate_hz=rate_hz, channels=channels, unit=unit, topic=topic)
    return _from_array(as_numbers(data), rate_hz, unit)


def as_numbers(data: ArrayLike) -> np.ndarray:
    """Anything like an array, as NumPy's.

    **Raises:** `ValueError` for what holds something other than real numbers.
    """
    try:
        found = np.asarray(data)
    except ValueError as error:
        raise ValueError("the rows of an array must be equally long.") from error
    if found.dtype.kind not in "iuf":
        raise ValueError(f"an array must hold real numbers; got {found.dtype}.")
    return found


def _from_array(data: np.ndarray, rate_hz: float | None, unit: str | None) -> Recording:
    if rate_hz is None or not rate_hz > 0:
        raise ValueError("an array needs rate_hz, in samples per second.")
    columns = data[:, None] if data.ndim == 1 else data
    if columns.ndim != 2 or columns.shape[1] not in (1, 3):
        raise ValueError(
            f"an array must have shape (samples,) or (samples, 3), one column an axis; "
            f"got {data.shape}."
        )
    if not np.isfinite(columns).all():
        raise ValueError("the array holds values that are not finite; leave these samples out.")
    own = parse_unit(unit or "m/s^2")
    names = ("x", "y", "z") if columns.shape[1] == 3 else ("data",)
    made = tuple(
        Channel(
            name=name,
            unit=own.name,
            factor=own.factor,
            si_unit=own.si_unit,
            kind=own.kind,
            samples=np.asarray(column, np.float64) * own.factor,
            stretches=((0, len(column)),),
            findings=(),
        )
        for name, column in zip(names, columns.T, strict=True)
    )
    return Recording("data", float(rate_hz), made, (), (), "")
