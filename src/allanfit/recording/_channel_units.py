"""The unit of each channel, and what its name tells of the sensor: `units_of`, `about_units`."""

import math
import re
from collections.abc import Iterable, Mapping

import numpy as np

from ..formatting import significant
from ._no_sensor import why_flag
from ._other_sensors import is_field_or_attitude, is_other_sensor
from ._recording import RecordingError, Table
from ._temperature import is_temperature
from ._timestamps import time_columns
from ._unit_endings import unit_in_name
from ._units import Unit, parse_given, parse_unit, ratio

_KIND_BY_NAME = (
    ("gyro", re.compile(r"gyr|omega|ang(ular)?_?(rate|vel)|^w[_ ]?[xyz]$", re.IGNORECASE)),
    ("accelerometer", re.compile(r"acc|^a[_ ]?[xyz]$", re.IGNORECASE)),
)
# Beside `ax` a gyro; alone perhaps gravity.
_RATE_OR_GRAVITY = re.compile(r"g([_ ]?[xyz])", re.IGNORECASE)


def units_of(
    names: list[str], aside: set[str], table: Table, override: str | None
) -> dict[str, Unit]:
    """The unit of each channel, `override` put in place where it fits.

    Where one of the units given fits, another may be for channels of the file that are not asked
    for.

    **Raises** `RecordingError` for an unknown unit, and one given that fits nothing.
    """
    given = [] if override is None else parse_given(override)
    units = {
        name: Unit(table.unit(name), si_unit=table.unit(name))
        if name in aside
        else _unit(name, table.units.get(name, ""), given, names)
        for name in names
    }
    fitting = list(units.values())
    if any(each in fitting for each in given):
        others = [name for name in _channels(table) if name not in names]
        everything = [*names, *others]
        fitting += [_unit(name, table.units.get(name, ""), given, everything) for name in others]
    for each in given:
        if each not in fitting:
            raise RecordingError(
                f"The unit {each.name} fits none of the channels: "
                + ", ".join(
                    f"{name} is in {unit.name or 'no unit'}" for name, unit in units.items()
                )
                + "."
            )
    return units


def _channels(table: Table) -> list[str]:
    """What is neither a time nor of a sensor beside."""
    times = time_columns(table.columns, table.units)
    return [
        name
        for name in table.columns
        if name not in times
        and not is_temperature(name, table.unit(name), table)
        and not is_field_or_attitude(name)
        and not is_beside(name, table)
    ]


def _unit(name: str, stated: str, given: list[Unit], names: list[str]) -> Unit:
    try:
        unit = parse_unit(stated or unit_in_name(name))
    except RecordingError as error:
        if is_other_sensor(name, stated):
            return Unit(stated, si_unit=stated)
        if not given:
            what = f"The column {name}: {error} Or say with --channel which columns to analyse."
            raise RecordingError(what) from error
        unit, stated = Unit(""), ""
    measured = None if unit.kind == "other" else unit.kind
    kind = unit.kind if stated else _kind_by_name(name, names) or measured
    if _are_codes(stated):
        # What one of them is worth says the user.
        worth = [each for each in given if each.scale != 1]
        sensor = _kind_by_name(name, names)
        unit = next((each for each in worth if sensor in (None, each.kind)), unit)
    fitting = (
        each for each in given if kind in (None, each.kind) or (each.kind == "other" and not stated)
    )
    return next(fitting, unit)


def _are_codes(stated: str) -> bool:
    """Whether a file's unit is that of raw codes, as counts or LSB."""
    return bool(stated) and ratio(stated, "counts") is not None


def _kind_by_name(name: str, names: Iterable[str] = ()) -> str | None:
    rate = _RATE_OR_GRAVITY.fullmatch(name)
    if rate and f"a{rate[1]}".casefold() in map(str.casefold, names):
        return "gyro"
    return next((kind for kind, pattern in _KIND_BY_NAME if pattern.search(name)), None)


def why_state(name: str, samples: np.ndarray, unit: Unit, wanted: bool) -> str:
    """Why a channel is a flag, "" if nothing says so or if something says that it is a sensor."""
    sensor = wanted or unit.kind != "other" or _kind_by_name(name) is not None
    return "" if sensor else why_flag(samples)


def about_units(units: dict[str, Unit], table: Table, override: str | None) -> list[str]:
    """Findings on units that are missing, in names, or do not go with the name of their channel."""
    findings, ends = [], {}
    given = [each.name for each in parse_given(override)] if override else []
    for name, unit in units.items():
        if not table.units.get(name) and unit.name not in ("", *given):
            ends[unit.name] = [*ends.get(unit.name, []), name]
    if ends:
        told = "; ".join(f"{', '.join(names)} in {unit}" for unit, names in ends.items())
        findings.append(f"Units are taken from the names: {told}.")
    findings += about_replaced(units, table.units)
    bare = [name for name, unit in units.items() if not unit.name]
    if bare:
        findings.append(
            f"No unit is known for {', '.join(bare)}: results are in the unit of the samples; "
            "give one, as in --unit deg/s or --unit m/s^2, for those of a data sheet."
        )
    for name, unit in units.items():
        expected = _kind_by_name(name, units)
        if unit.kind != "other" and expected not in (None, unit.kind):
            findings.append(f"The unit {unit.name} of {name} is not one of a {expected}.")
    return findings


def about_replaced(units: Mapping[str, Unit], stated: Mapping[str, str]) -> list[str]:
    """Findings on units of the file, `stated`, that the user's were put in place of."""
    replaced: dict[tuple[str, str], list[str]] = {}
    for name, unit in units.items():
        known = stated.get(name, "")
        if _means_another(known, unit):
            scale = "" if unit.scale == 1 else f"{significant(unit.scale)} "
            replaced.setdefault((known, f"{scale}{unit.name}"), []).append(name)
    return [
        f"The file says {known} for {', '.join(names)}; --unit {used} was used instead."
        for (known, used), names in replaced.items()
    ]


def _means_another(stated: str, used: Unit) -> bool:
    """Whether a file's unit is known, and not the one that is used, however that is spelled."""
    if (stated in ("", used.name) and used.scale == 1) or (_are_codes(stated) and used.scale != 1):
        return False
    try:
        known = parse_unit(stated)
    except RecordingError:
        # Put right by the unit that was given.
        return False
    size = ratio(stated, used.name)
    return bool(known.si_unit) and (size is None or not math.isclose(size, used.scale))


def is_beside(name: str, table: Table) -> bool:
    """Whether a column is of another sensor, by name or unit, and of no inertial one."""
    return _kind_by_name(name) is None and is_other_sensor(name, table.unit(name))
