"""Rate tables as files: rates and readings, clockwise and counter-clockwise, in SI and signed."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from ..recording._csv import read_csv
from ..recording._files import require_file
from ..recording._units import Unit, parse_unit

_EXAMPLE = "`rate, cw, ccw`, or a pair for each axis, `rate, roll_cw, roll_ccw, ...`"
_NEEDED = f"a rate table has the columns {_EXAMPLE}"


class RatePairs(NamedTuple):
    """The readings of one axis; all arrays have shape (rates,), in SI."""

    name: str
    unit: Unit
    clockwise: Float64[np.ndarray, " rates"]
    counter_clockwise: Float64[np.ndarray, " rates"]
    """Signed: negative where the sensor reads a counter-clockwise rate."""


class RateTable(NamedTuple):
    """A file as it was read."""

    name: str
    rate: Float64[np.ndarray, " rates"] | None
    """Of the table, positive [SI]; None where the file has no such column."""
    axes: tuple[RatePairs, ...]
    findings: tuple[str, ...]


#: A CSV file, or its columns by name.
RateData = Mapping[str, object] | str | os.PathLike[str]


def read_rate_table(data: RateData, unit: str | None, signed: bool = False) -> RateTable:
    """Columns into signed readings of each axis.

    Counter-clockwise readings may be printed as magnitudes or with their sign: a table without a
    single negative number holds magnitudes, unless `signed` says otherwise.

    **Raises:** `ValueError` for a missing, lonely, empty or wordy column, and an unknown unit.
    """
    name, columns, units = _columns(data)
    own = parse_unit(unit) if unit is not None else Unit("")
    if unit is not None and own.kind != "gyro":
        raise ValueError(
            f"The unit {own.name or unit!r} is not one of an angular rate; give rpm, deg/s or "
            "rad/s."
        )
    known = {column: _unit_of(column, units.get(column, ""), own) for column in columns}
    _refuse_half_known(name, known)
    pairs = _pairs(name, columns)
    negative = signed or any((columns[each] < 0).any() for pair in pairs.values() for each in pair)
    axes = tuple(
        RatePairs(
            axis,
            known[cw],
            columns[cw] * known[cw].factor,
            columns[ccw] * known[ccw].factor * (1 if negative else -1),
        )
        for axis, (cw, ccw) in pairs.items()
    )
    rate = columns["rate"] * known["rate"].factor if "rate" in columns else None
    findings = ()
    if not any(each.name for each in known.values()):
        findings += (
            "No unit is known: results are in the unit of the table; give it, as in --unit rpm.",
        )
    return RateTable(name, rate, axes, findings)


def _columns(data: RateData) -> tuple[str, dict[str, np.ndarray], dict[str, str]]:
    """Name, columns in lower case and units; nothing but finite numbers, all equally many."""
    if isinstance(data, Mapping):
        name, units = "data", {}
        columns = {str(key): np.asarray(value) for key, value in data.items()}
        for key, column in columns.items():
            if column.ndim != 1 or column.dtype.kind not in "iuf":
                raise ValueError(f"The column {key} must be a list of numbers, one for each rate.")
        if len({len(column) for column in columns.values()}) > 1:
            raise ValueError("The columns of a rate table must be equally long.")
        if any(len(column) == 0 for column in columns.values()):
            raise ValueError("The columns of the rate table are empty; give a row for each rate.")
    else:
        path = Path(data)
        require_file(path)
        table = read_csv(path)
        if table.findings:
            raise ValueError(f"{path.name}: {table.findings[0]} A rate table holds numbers alone.")
        name, columns, units = path.name, table.columns, table.units
    for key, column in columns.items():
        bad = np.flatnonzero(~np.isfinite(column.astype(np.float64)))
        if len(bad):
            raise ValueError(
                f"{name}: the column {key} has no number in row {bad[0] + 1}; fill it in or leave "
                "the row out."
            )
    lower: dict[str, np.ndarray] = {}
    for key, column in columns.items():
        if _plain(key) in lower:
            raise ValueError(f"{name} has two columns {_plain(key)}, for case makes no difference.")
        lower[_plain(key)] = column.astype(np.float64)
    return name, lower, {_plain(key): unit for key, unit in units.items()}


def _plain(key: str) -> str:
    return key.strip().lower()


def _unit_of(column: str, stated: str, given: Unit) -> Unit:
    if not stated:
        return given
    unit = parse_unit(stated)
    if unit.kind != "gyro":
        raise ValueError(f"The column {column} is in {stated}, which is not an angular rate.")
    return unit


def _refuse_half_known(name: str, known: Mapping[str, Unit]) -> None:
    bare = [column for column, unit in known.items() if not unit.name]
    if bare and len(bare) < len(known):
        raise ValueError(f"{name} gives no unit for {', '.join(bare)}; give it with --unit.")


def _pairs(name: str, columns: Mapping[str, np.ndarray]) -> dict[str, tuple[str, str]]:
    """Names of the clockwise and counter-clockwise column of each axis."""
    readings = [column for column in columns if column != "rate"]
    pairs = {}
    for column in readings:
        axis, mark, side = column.rpartition("_")
        if side not in ("cw", "ccw") or (mark and not axis):
            raise ValueError(f"{name} has a column {column!r}, and {_NEEDED}.")
        other = f"{axis}{mark}{'ccw' if side == 'cw' else 'cw'}"
        if other not in columns:
            raise ValueError(f"{name} has a column {column} but no {other}; {_NEEDED}.")
        pairs[axis or "data"] = (f"{axis}{mark}cw", f"{axis}{mark}ccw")
    if not pairs:
        raise ValueError(f"{name} has the columns {', '.join(columns) or 'none'}; {_NEEDED}.")
    return pairs
