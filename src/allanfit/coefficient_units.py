"""The units in which the field quotes each coefficient: the one table of them.

A channel in the unit u has Q in u s, N in u/sqrt(Hz), B in u, K in u/sqrt(s) and R in u/s. No two
of these ten, five of an angular rate and five of an acceleration, have the same dimension, so
that a unit alone tells which coefficient of which kind of sensor it measures.
"""

import math
from functools import cache
from typing import NamedTuple

from .recording import RecordingError
from .recording._units import parse_compound, parse_unit, ratio


class CoefficientUnits(NamedTuple):
    """Where a coefficient is quoted: in SI, then in data sheets, the commonest first."""

    si: str
    field: tuple[str, ...]


UNITS = {
    "gyro": {
        "Q": CoefficientUnits("rad", ("arcsec",)),
        "N": CoefficientUnits("rad/s/sqrt(Hz)", ("deg/sqrt(h)",)),
        "B": CoefficientUnits("rad/s", ("deg/h",)),
        "K": CoefficientUnits("rad/s/sqrt(s)", ("deg/h/sqrt(h)",)),
        "R": CoefficientUnits("rad/s^2", ("deg/h^2",)),
    },
    "accelerometer": {
        "Q": CoefficientUnits("m/s", ("m/s",)),
        "N": CoefficientUnits("m/s^2/sqrt(Hz)", ("m/s/sqrt(h)", "ug/sqrt(Hz)")),
        "B": CoefficientUnits("m/s^2", ("ug",)),
        "K": CoefficientUnits("m/s^2/sqrt(s)", ("ug/sqrt(s)",)),
        "R": CoefficientUnits("m/s^3", ("ug/s",)),
    },
}


class Conversion(NamedTuple):
    """Multiply a coefficient in the channel's unit by `factor` to have it in `unit`."""

    unit: str
    factor: float


class Measured(NamedTuple):
    """What a unit measures: `factor` of SI of the coefficient `symbol` of a `kind` of sensor."""

    kind: str
    symbol: str
    factor: float


@cache
def measured_by(unit: str) -> Measured | None:
    """The coefficient that a unit measures, None for a unit of none or no unit at all.

    >>> measured_by("deg/sqrt(h)")[:2], measured_by("ug")[:2]
    (('gyro', 'N'), ('accelerometer', 'B'))
    """
    if parse_compound(unit) is None:
        return None
    for kind, units in UNITS.items():
        for symbol, known in units.items():
            factor = ratio(unit, known.si)
            if factor is not None:
                return Measured(kind, symbol, factor)
    return None


def field_units(kind: str, unit: str, symbol: str) -> list[Conversion]:
    """The units in which data sheets and standards quote a coefficient.

    **Arguments**: `kind` is "gyro", "accelerometer" or "other"; `unit` is the channel's unit;
    `symbol` is one of Q, N, B, K, R. **Returns** none for a unit that is not known, nor one in
    which the number would be the same as in the channel's own unit.
    """
    si = si_unit(kind, unit, symbol)
    if si is None:
        return []
    found = [Conversion(name, si.factor * _per_si(name)) for name in UNITS[kind][symbol].field]
    return [each for each in found if not math.isclose(each.factor, 1.0, rel_tol=1e-12)]


def si_unit(kind: str, unit: str, symbol: str) -> Conversion | None:
    """The SI unit of a coefficient, None where the channel's unit is not known."""
    try:
        known = parse_unit(unit)
    except RecordingError:
        return None
    if known.kind != kind or kind not in UNITS or symbol not in UNITS[kind]:
        return None
    return Conversion(UNITS[kind][symbol].si, known.factor)


def _per_si(unit: str) -> float:
    """Units of the table in one of SI."""
    known = measured_by(unit)
    if known is None:
        raise KeyError(unit)
    return 1 / known.factor
