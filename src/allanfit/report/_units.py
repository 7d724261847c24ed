"""The units in which the field quotes each coefficient.

A channel in the unit u has Q in u s, N in u/sqrt(Hz), B in u, K in u/sqrt(s) and R in u/s. One
factor takes u to SI, a second takes the SI coefficient to the unit of a data sheet. The factors
are exact by definition (the degree, the hour, standard gravity), so a table is all it takes.
"""

import math
from typing import NamedTuple

_DEGREE = math.pi / 180
_HOUR = 3600.0
_STANDARD_GRAVITY = 9.80665  # m/s^2, exact: CGPM 1901, resolution 2

_SI_FACTORS = {
    "gyro": {
        "rad/s": 1.0,
        "mrad/s": 1e-3,
        "rad/h": 1 / _HOUR,
        "deg/s": _DEGREE,
        "mdeg/s": 1e-3 * _DEGREE,
        "deg/min": _DEGREE / 60,
        "deg/h": _DEGREE / _HOUR,
        "rpm": 2 * math.pi / 60,
    },
    "accelerometer": {
        "m/s^2": 1.0,
        "cm/s^2": 1e-2,
        "mm/s^2": 1e-3,
        "g": _STANDARD_GRAVITY,
        "mg": 1e-3 * _STANDARD_GRAVITY,
        "ug": 1e-6 * _STANDARD_GRAVITY,
    },
}

# Spellings met in headers of recordings, as replacements applied in this order.
_SPELLINGS = (
    (" ", ""),
    ("\N{DEGREE SIGN}", "deg"),
    ("dps", "deg/s"),
    ("/sec", "/s"),
    ("/hr", "/h"),
    ("**", "^"),
    ("\N{SUPERSCRIPT TWO}", "^2"),
    ("/s2", "/s^2"),
    ("\N{MICRO SIGN}", "u"),
    ("\N{GREEK SMALL LETTER MU}", "u"),
)

_MICRO_G = 1e6 / _STANDARD_GRAVITY
_FIELD_UNITS = {
    "gyro": {
        "Q": (("arcsec", _HOUR / _DEGREE),),  # 3600 arcsec in a degree
        "N": (("deg/sqrt(h)", math.sqrt(_HOUR) / _DEGREE),),
        "B": (("deg/h", _HOUR / _DEGREE),),
        "K": (("deg/h/sqrt(h)", _HOUR**1.5 / _DEGREE),),
        "R": (("deg/h^2", _HOUR**2 / _DEGREE),),
    },
    "accelerometer": {
        "Q": (("m/s", 1.0),),
        "N": (("m/s/sqrt(h)", math.sqrt(_HOUR)), ("ug/sqrt(Hz)", _MICRO_G)),
        "B": (("ug", _MICRO_G),),
        "K": (("ug/sqrt(s)", _MICRO_G),),
        "R": (("ug/s", _MICRO_G),),
    },
}

_SI_UNITS = {
    "gyro": {"Q": "rad", "N": "rad/s/sqrt(Hz)", "B": "rad/s", "K": "rad/s/sqrt(s)", "R": "rad/s^2"},
    "accelerometer": {
        "Q": "m/s",
        "N": "m/s^2/sqrt(Hz)",
        "B": "m/s^2",
        "K": "m/s^2/sqrt(s)",
        "R": "m/s^3",
    },
}


class Conversion(NamedTuple):
    """Multiply a coefficient in the channel's unit by `factor` to have it in `unit`."""

    unit: str
    factor: float


def _si_factor(kind: str, unit: str) -> float | None:
    for spelling, ours in _SPELLINGS:
        unit = unit.replace(spelling, ours)
    return _SI_FACTORS.get(kind, {}).get(unit)


def field_units(kind: str, unit: str, symbol: str) -> list[Conversion]:
    """The units in which data sheets and standards quote a coefficient.

    **Arguments**: `kind` is "gyro", "accelerometer" or "other"; `unit` is the channel's unit;
    `symbol` is one of Q, N, B, K, R. **Returns** none for a unit that is not known, nor one in
    which the number would be the same as in the channel's own unit.
    """
    to_si = _si_factor(kind, unit)
    if to_si is None:
        return []
    conversions = [
        Conversion(name, to_si * factor) for name, factor in _FIELD_UNITS[kind].get(symbol, ())
    ]
    return [each for each in conversions if not math.isclose(each.factor, 1.0, rel_tol=1e-12)]


def si_unit(kind: str, unit: str, symbol: str) -> Conversion | None:
    """The SI unit of a coefficient, None where the channel's unit is not known."""
    to_si = _si_factor(kind, unit)
    name = _SI_UNITS.get(kind, {}).get(symbol)
    return None if to_si is None or name is None else Conversion(name, to_si)


def squared_per_hertz(unit: str) -> str:
    """The unit of a power spectral density, `(deg/s)^2/Hz` for a channel in deg/s."""
    if not unit:
        return "1/Hz"
    return f"{unit}^2/Hz" if unit.isalnum() else f"({unit})^2/Hz"


def typeset(unit: str) -> str:
    """A unit as it is set in print: roots, powers and micro as signs, `deg/\N{SQUARE ROOT}h`."""
    for root in ("Hz", "s", "h"):
        unit = unit.replace(f"sqrt({root})", f"\N{SQUARE ROOT}{root}")
    unit = unit.replace("^2", "\N{SUPERSCRIPT TWO}").replace("^3", "\N{SUPERSCRIPT THREE}")
    return f"\N{MICRO SIGN}{unit[1:]}" if unit.startswith("ug") else unit
