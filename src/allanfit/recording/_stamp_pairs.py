"""Time stamps in two columns: whole seconds, and the nanoseconds beyond them, as ROS has them."""

import re
from dataclasses import replace

import numpy as np

from ._recording import Table

_SECONDS = re.compile(r"(.*?)[._/]?(secs?|seconds?)", re.IGNORECASE)
_BEYOND = ("nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds")
_NS = 1_000_000_000


def joined(table: Table) -> Table:
    """The table with one column of nanoseconds in place of such a pair, if it has one."""
    lower = {name.lower(): name for name in table.columns}
    for name, seconds in table.columns.items():
        found = _SECONDS.fullmatch(name)
        if found is None:
            continue
        before = name[: found.start(2)].lower()
        beyond = next((lower[before + end] for end in _BEYOND if before + end in lower), None)
        if beyond is None or not _is_below_a_second(table.columns[beyond]):
            continue
        whole = _as_whole(seconds) * _NS + _as_whole(table.columns[beyond])
        stamp = found[1] or "stamp"
        columns = {
            stamp if each == name else each: whole if each == name else column
            for each, column in table.columns.items()
            if each != beyond and (each == name or each != stamp)
        }
        units = {each: unit for each, unit in table.units.items() if each not in (name, beyond)}
        return replace(table, columns=columns, units=units | {stamp: "ns"})
    return table


def _as_whole(column: np.ndarray) -> np.ndarray:
    """As integers, which keep nanoseconds since 1970, where none is missing."""
    return column.astype(np.int64) if np.isfinite(column).all() else column.astype(float)


def _is_below_a_second(column: np.ndarray) -> bool:
    kept = column[np.isfinite(column)]
    return bool(kept.size and kept.min() >= 0 and kept.max() < _NS and not (kept % 1).any())
