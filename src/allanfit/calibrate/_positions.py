"""Readings of a triad at rest, from a table of means, an array, or a recording cut into rests."""

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy.typing import ArrayLike

from ..recording import Recording, is_recording, load
from ..recording._channel_units import about_replaced
from ..recording._csv import read_csv
from ..recording._files import require_file
from ..recording._timestamps import time_columns
from ..recording._units import Unit, parse_given, parse_unit
from ._data import as_numbers
from ._still import still_means

# A table of means has a row a position; nobody turns a sensor this often by hand.
_MOST_POSITIONS = 1000
_AXIS = re.compile(r"(?!ref).*?(?:^|[_a])([xyz])", re.IGNORECASE)
_REFERENCE = re.compile(r"ref_?([xyz])", re.IGNORECASE)
_TEXT = (".csv", ".csv.gz", ".txt", ".txt.gz")
_NEEDED = "a table of positions has the columns ax, ay, az, and may have ref_x, ref_y, ref_z"


class Positions(NamedTuple):
    """Means at rest."""

    name: str
    unit: Unit
    axes: tuple[str, ...]
    """Three names, in the order x, y, z."""
    readings: Float64[np.ndarray, "positions 3"]
    """In SI."""
    reference: Float64[np.ndarray, "positions 3"] | None
    """Unit vectors of the specific force along the axes of the body, where they are known."""
    findings: tuple[str, ...]


#: A file, a `Recording`, or means of shape (positions, 3), in any array or list.
PositionData = Recording | ArrayLike | str | os.PathLike[str]


def read_positions(
    data: PositionData,
    *,
    unit: str | None,
    rate_hz: float | None,
    channels: Sequence[str] | None,
    topic: str | None,
    reference: np.ndarray | None,
    gravity: float,
) -> Positions:
    """Means in SI, whatever they come from.

    **Raises:** `ValueError` for missing columns, what is not a number, a unit that is not one of
    an acceleration, and directions that are none.
    """
    if isinstance(data, Recording):
        return _cut(data, gravity)
    if not isinstance(data, str | os.PathLike):
        own = _unit({}, ("x", "y", "z"), unit)
        return _table("data", ("x", "y", "z"), as_numbers(data), own, reference, ())
    path = Path(data)
    if not (path.is_dir() and is_recording(path)):
        require_file(path)
    table = read_csv(path) if path.name.lower().endswith(_TEXT) else None
    if rate_hz is not None or table is None or time_columns(table.columns, table.units):
        found = load(path, rate_hz=rate_hz, channels=channels, unit=unit, topic=topic)
        return _cut(found, gravity)
    columns = table.columns
    if channels:
        kept = {*channels, *(name for name in columns if _REFERENCE.fullmatch(name))}
        columns = {name: column for name, column in columns.items() if name in kept}
    return _from_columns(path.name, columns, table.units, unit, reference, table.findings)


def _from_columns(
    name: str,
    columns: dict[str, np.ndarray],
    units: dict[str, str],
    unit: str | None,
    reference: np.ndarray | None,
    findings: tuple[str, ...],
) -> Positions:
    if list(columns) == ["channel_1", "channel_2", "channel_3"]:
        columns = dict(zip("xyz", columns.values(), strict=True))
    axes = _letters(name, columns, _AXIS, needed=True)
    given = _letters(name, columns, _REFERENCE, needed=False)
    ignored = [column for column in columns if column not in (*axes, *given)]
    if ignored:
        findings += (f"{name}: left out {', '.join(ignored)}.",)
    for column in (*axes, *given):
        bad = np.flatnonzero(~np.isfinite(columns[column].astype(np.float64)))
        if len(bad):
            raise ValueError(
                f"{name}: the column {column} has no number in row {bad[0] + 1}; fill it in or "
                "leave the row out."
            )
    own = _unit(units, axes, unit)
    findings += tuple(about_replaced(dict.fromkeys(axes, own), units))
    readings = np.stack([columns[axis].astype(np.float64) for axis in axes], axis=1)
    if given:
        reference = np.stack([columns[each].astype(np.float64) for each in given], axis=1)
    return _table(name, axes, readings, own, reference, findings)


def _letters(
    name: str, columns: dict[str, np.ndarray], pattern: re.Pattern[str], *, needed: bool
) -> tuple[str, ...]:
    """The three columns that the pattern finds, in the order x, y, z."""
    found: dict[str, str] = {}
    for column in columns:
        match = pattern.fullmatch(column)
        if match is None:
            continue
        letter = match[1].lower()
        if letter in found:
            raise ValueError(
                f"{name} has two columns for {letter}, {found[letter]} and {column}; {_NEEDED}."
            )
        found[letter] = column
    missing = [letter for letter in "xyz" if letter not in found]
    if missing and (needed or found):
        lacking = f"for {missing[0]}" if needed else f"ref_{missing[0]}"
        raise ValueError(
            f"{name} has no column {lacking}, only {', '.join(columns) or 'none'}; {_NEEDED}."
        )
    return tuple(found[letter] for letter in "xyz" if letter in found)


def _unit(units: dict[str, str], axes: tuple[str, ...], given: str | None) -> Unit:
    """The unit of all three axes; m/s^2 without any, which gravity then confirms."""
    stated = {axis: units[axis] for axis in axes if units.get(axis)}
    names = set(stated.values())
    if len(names) > 1:
        raise ValueError(f"The axes are in different units, {', '.join(sorted(names))}; use one.")
    unit, *_ = found = parse_given(given if given is not None else next(iter(names), "m/s^2"))
    if len(found) > 1:
        raise ValueError(f"The axes are in one unit; got {given!r}. Give one, as m/s^2, g or mg.")
    if unit.kind != "accelerometer":
        raise ValueError(
            f"The unit {unit.name or given!r} is not one of an acceleration; give m/s^2, g or mg."
        )
    return unit


def _table(
    name: str,
    axes: tuple[str, ...],
    readings: np.ndarray,
    unit: Unit,
    reference: np.ndarray | None,
    findings: tuple[str, ...],
) -> Positions:
    readings = np.asarray(readings, np.float64)
    if readings.ndim != 2 or readings.shape[1] != 3 or not np.isfinite(readings).all():
        raise ValueError(
            f"positions must be finite numbers of shape (positions, 3); got {readings.shape}."
        )
    if len(readings) > _MOST_POSITIONS:
        raise ValueError(
            f"{name} has {len(readings)} rows, one for each position if it is a table of means; "
            "if it is a recording, give its rate with --rate."
        )
    copied = len(readings) - len(np.unique(readings, axis=0))
    if copied:
        raise ValueError(
            f"{name} holds {copied} position{'s' * (copied > 1)} twice, to the last digit; a copy "
            "is no second measurement: leave it out."
        )
    if reference is not None:
        reference = _directions(name, np.asarray(reference, np.float64), readings.shape)
    return Positions(name, unit, axes, readings * unit.scale * unit.factor, reference, findings)


def _directions(
    name: str, reference: np.ndarray, shape: tuple[int, ...]
) -> Float64[np.ndarray, "positions 3"]:
    """Unit vectors; the lengths, which say nothing, must yet be alike."""
    if reference.shape != shape or not np.isfinite(reference).all():
        raise ValueError(f"the reference must be finite numbers of shape {shape}, as the readings.")
    length = np.linalg.norm(reference, axis=1)
    if not length.min() > 0 or length.max() > 1.02 * length.min():
        raise ValueError(
            f"{name}: the reference vectors are {length.min():.4g} to {length.max():.4g} long, and "
            "each must be the specific force along x, y, z, so equally long in every position."
        )
    return reference / length[:, None]


def _cut(recording: Recording, gravity: float) -> Positions:
    """The rests of a recording."""
    if len(recording.channels) != 3:
        raise ValueError(
            f"{recording.name} has the channels "
            f"{', '.join(channel.name for channel in recording.channels)}; a triad has three: "
            "choose them with --channel."
        )
    recording, findings = _in_order(recording)
    names = tuple(channel.name for channel in recording.channels)
    first = recording.channels[0]
    unit = Unit(first.unit, first.factor, first.si_unit, first.kind)
    if not unit.name:
        unit = parse_unit("m/s^2")
    if unit.kind != "accelerometer" or any(
        channel.unit != first.unit for channel in recording.channels
    ):
        raise ValueError(
            f"The channels of {recording.name} are not all in one unit of an acceleration; give it "
            "with --unit, as m/s^2 or g."
        )
    means, shortest = still_means(recording, gravity)
    found = f"{recording.name}: {len(means)} rests found"
    # Whatever repeats or is rounded in a sensor that is moved matters little to means.
    return Positions(
        recording.name,
        unit,
        names,
        means,
        None,
        (*findings, f"{found}, the shortest {shortest:.3g} s long." if len(means) else f"{found}."),
    )


def _in_order(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """The channels as x, y, z, whose angles they are to have; as they stand if no name tells."""
    letters = {}
    for channel in recording.channels:
        match = _AXIS.fullmatch(channel.name)
        letters[match[1].lower() if match else channel.name] = channel
    if set(letters) == set("xyz"):
        return replace(recording, channels=tuple(letters[letter] for letter in "xyz")), ()
    names = ", ".join(channel.name for channel in recording.channels)
    return recording, (f"{recording.name}: {names} are taken as x, y, z, in this order.",)
