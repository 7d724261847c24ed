"""Columns of other sensors beside inertial ones: magnetometers, barometers, batteries."""

import re
from collections.abc import Iterable

from ._recording import RecordingError
from ._units import parse_unit

_MAGNETOMETER = re.compile(r"(?:.*_)?mag(?!nitude)", re.IGNORECASE)
# What a filter made of the sensors, in a message of ROS.
_ORIENTATION = re.compile(r"(?:.*[./])?orientation[./][xyzw]")
# Words anywhere in a name, and those that are part of others.
_NAME = re.compile(
    r"pressure|baromet|humid|batter|voltage|altitude|illumin|latitude|longitude|satellite"
    r"|(?:^|[\W_])(?:press|baro|rh|batt?|vbatt?|v[cd][cd]|volts?|alt|lat|lon|lux|light|gps|gnss)"
    r"(?:$|[\W_\d])",
    re.IGNORECASE,
)
_UNIT = re.compile(
    r"%|%\s*rh|rh\s*%|[hkm]?pa|m?bar|psi|atm|(?:mm|in)hg|torr|lx|lux|ppm", re.IGNORECASE
)


def is_field_or_attitude(name: str) -> bool:
    """Whether a column is of a magnetometer, or an orientation."""
    return bool(_MAGNETOMETER.match(name) or _ORIENTATION.fullmatch(name))


def is_other_sensor(name: str, unit: str) -> bool:
    """Whether a column in this unit is a pressure, humidity, voltage, position or the like."""
    if _UNIT.fullmatch(unit.strip()):
        return True
    try:
        inertial = parse_unit(unit).kind != "other"
    except RecordingError:
        inertial = False
    return not inertial and _NAME.search(name) is not None


def about_others(names: Iterable[str]) -> tuple[str, ...]:
    """A finding on the columns of other sensors that are left beside the channels."""
    told = ", ".join(names)
    return (f"Not analysed, as of other sensors: {told}; --channel asks for one.",) if told else ()
