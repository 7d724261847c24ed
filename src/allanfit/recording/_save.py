"""Write a recording in the formats that are read."""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import polars as pl

from ..whole_file import replacing
from ._recording import RecordingError


def save(
    path: str | Path,
    columns: Mapping[str, np.ndarray],
    units: Mapping[str, str],
    rate_hz: float,
) -> None:
    """Write channels sampled together to `.npz`, `.npy` or `.csv`, whole or not at all.

    **Arguments:**

    - `columns`: samples by channel name, 1-D arrays of one length, in the channel's unit.
    - `units`: the unit of each channel; "" for none. An `.npy` file has no room for them, nor
      for the rate.
    - `rate_hz`: samples a second. A `.csv` file gets a column of times in its place.

    **Raises:** `RecordingError` when there are no channels, or some of unequal lengths or with
    more than one axis, when the file cannot hold a name, for another ending, and if the file
    cannot be written.
    """
    path = Path(path)
    arrays = {name: np.asarray(column) for name, column in columns.items()}
    _check_together(path, arrays)
    try:
        with replacing(path) as part:
            if path.suffix == ".npz":
                _refuse_reserved(arrays)
                text = json.dumps({name: unit for name, unit in units.items() if unit})
                np.savez(part, **arrays, rate_hz=rate_hz, units=text)  # pyright: ignore[reportArgumentType]
            elif path.suffix == ".npy":
                stacked = np.stack(list(arrays.values()), axis=1)
                np.save(part, stacked[:, 0] if stacked.shape[1] == 1 else stacked)
            elif path.suffix == ".csv":
                table = {"time_s": np.arange(len(next(iter(arrays.values())))) / rate_hz}
                for name, column in arrays.items():
                    header = f"{name} [{units[name]}]" if units.get(name) else name
                    if header in table:
                        raise RecordingError(
                            f"{path.name} would have two columns named {header}: rename one."
                        )
                    table[header] = column
                pl.DataFrame(table).write_csv(part)
            else:
                raise RecordingError(
                    f"Cannot write {path.name}: give a name that ends in .npz, .npy or .csv."
                )
    except OSError as error:
        raise RecordingError(
            f"Cannot write {path} ({error.strerror or error}): give a path in a folder that "
            "exists, is writable and has space."
        ) from error


def _check_together(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    if not arrays:
        raise RecordingError(f"Cannot write {path.name} without a channel: give one at least.")
    first, column = next(iter(arrays.items()))
    for name, other in arrays.items():
        if other.ndim != 1:
            raise RecordingError(
                f"Cannot write {path.name}: channel {name} has the shape {other.shape}, and a "
                "channel is a 1-D array."
            )
        if other.size != column.size:
            raise RecordingError(
                f"Cannot write {path.name}: channels sampled together have equally many samples, "
                f"but {first} has {column.size} and {name} has {other.size}."
            )


def _refuse_reserved(names: Iterable[str]) -> None:
    for name in names:
        # Two are arguments of NumPy, and dots may be taken for a way out of the folder in which
        # an archive is unpacked.
        reserved = name in ("file", "allow_pickle", "rate_hz", "units")
        if reserved or ".." in re.split(r"[/\\\\]", name):
            raise RecordingError(
                f"An .npz file cannot hold a channel named {name}: rename it, or write .csv."
            )
