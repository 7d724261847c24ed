"""Arrays in memory as the columns of a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._recording import RecordingError, Table


def table_of(data: Mapping[str, ArrayLike] | ArrayLike, units: Mapping[str, str]) -> Table:
    """Columns by name, as a dictionary or a data frame has them, or an array of one or two axes.

    **Raises** `RecordingError` for what is neither, a column that is no series of real numbers,
    and a unit of a column that is not there.
    """
    given = {name: np.asarray(each) for name, each in _named(data).items()}
    columns = {name: _series(name, each) for name, each in given.items()}
    strange = [name for name in units if name not in columns]
    if strange:
        raise RecordingError(
            f"units names {strange[0]!r}, and the columns are {', '.join(columns)}."
        )
    dated = {name: "ns" for name, each in given.items() if each.dtype.kind == "M"}
    return Table(columns, dated | dict(units))


def _named(data: Any) -> dict[str, Any]:
    if isinstance(data, Mapping) or hasattr(data, "items"):
        return {str(name): each for name, each in data.items()}
    # Those of Polars.
    if hasattr(data, "get_columns"):
        return {each.name: each for each in data.get_columns()}
    array = np.asarray(data)
    if array.ndim == 1:
        return {"data": array}
    if array.ndim == 2 and array.shape[0] <= array.shape[1]:
        return {f"channel_{k}": row for k, row in enumerate(array, start=1)}
    raise RecordingError(
        "A recording is columns by name, or an array of shape (samples,) or (channels, samples); "
        f"got one of shape {array.shape}."
    )


def _series(name: str, array: np.ndarray) -> np.ndarray:
    if array.dtype.kind == "M":
        # Time stamps of a data frame.
        return array.astype("datetime64[ns]").astype(np.int64)
    if array.ndim != 1 or array.dtype.kind not in "iuf":
        raise RecordingError(
            f"The column {name} must be a series of real numbers of shape (samples,); got "
            f"{array.dtype} of shape {array.shape}."
        )
    return array
