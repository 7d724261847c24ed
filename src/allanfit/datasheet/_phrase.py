"""A data sheet's phrase, such as `0.15 °/√hr` or `60 µg/√Hz rms`, as a number of SI."""

import math
import re
from typing import NamedTuple

from ..coefficient_units import UNITS, Measured, measured_by

_PHRASE = re.compile(r"([<≤]?)\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)(.*)", re.IGNORECASE)
# What says only that the number is a standard deviation.
_STANDARD_DEVIATION = re.compile(r",?\s*\(?\b(?:rms|1[\s-]?(?:σ|sigma))\)?\s*$", re.IGNORECASE)
_BANDWIDTH = re.compile(r"\b(?:bandwidth|bw|at|over)\b|@", re.IGNORECASE)


class DatasheetError(ValueError):
    """A data sheet cannot be used; one sentence says why and what to do."""


class Quantity(NamedTuple):
    """A number with the unit in which it was written."""

    number: float
    unit: str
    measured: Measured
    bounded: bool
    """Whether `<` or `≤` stands before it, so that it is no typical value."""

    @property
    def si(self) -> float:
        """The same in SI."""
        return self.number * self.measured.factor


def parse_phrase(phrase: object, example: str = "deg/sqrt(h)") -> Quantity:
    """The quantity that a phrase states; `example` is a unit for it, for messages.

    **Raises** `DatasheetError` for what is no positive number with a unit of a coefficient.
    """
    text = str(phrase).strip()
    found = None if isinstance(phrase, bool) else _PHRASE.fullmatch(text)
    if found is None:
        raise DatasheetError(f"{text!r} is not a number with a unit; write 0.15 {example}")
    number, unit = float(found[2]), found[3].strip()
    if unit[:1] == "," and unit[1:2].isdigit():
        raise DatasheetError(f"{text!r} has a comma in its number: write a decimal point")
    if not (math.isfinite(number) and number > 0):
        raise DatasheetError(f"{text!r} must be above zero")
    if _BANDWIDTH.search(unit):
        raise DatasheetError(
            f"{text!r} depends on the shape of a filter, which a bandwidth does not tell; give "
            "the noise density or the random walk instead"
        )
    unit = _STANDARD_DEVIATION.sub("", unit).strip()
    if not unit:
        raise DatasheetError(f"{text!r} has no unit; write {text} {example}, for example")
    measured = measured_by(unit)
    if measured is None:
        raise DatasheetError(f"the unit {unit!r} is not known; {_understood()}")
    return Quantity(number, unit, measured, bool(found[1]))


def units_of(kind: str, symbol: str) -> str:
    """The units in which a coefficient may be stated, for a message."""
    known = UNITS[kind][symbol]
    return ", ".join(dict.fromkeys((*known.field, known.si)))


def _understood() -> str:
    kinds = (
        f"{' or '.join(units[s].field[0] for s in 'NBK')} for a {name}"
        for name, units in (("gyro", UNITS["gyro"]), ("n accelerometer", UNITS["accelerometer"]))
    )
    return f"understood are such as {', '.join(kinds)}".replace("a n ", "an ")
