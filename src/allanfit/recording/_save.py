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

    **Raises:** `RecordingError` for another ending, or if the file cannot be written.
    """
    path = Path(path)
    arrays = {name: np.asarray(column) for name, column in columns.items()}
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
                time = np.arange(len(next(iter(arrays.values())))) / rate_hz
                named = {
                    f"{name} [{units[name]}]" if units.get(name) else name: column
                    for name, column in arrays.items()
                }
                pl.DataFrame({"time_s": time, **named}).write_csv(part)
            else:
                raise RecordingError(
                    f"Cannot write {path.name}: give a name that ends in .npz, .npy or .csv."
                )
    except OSError as error:
        raise RecordingError(
            f"Cannot write {path} ({error.strerror or error}): give a path in a folder that "
            "exists, is writable and has space."
        ) from error


def _refuse_reserved(names: Iterable[str]) -> None:
    for name in names:
        # The last may be taken for a way out of the folder in which an archive is unpacked.
        if name in ("file", "rate_hz", "units") or ".." in re.split(r"[/\\\\]", name):
            raise RecordingError(
                f"An .npz file cannot hold a channel named {name}: rename it, or write .csv."
            )
