"""Units of inertial sensors, by name, to SI.

The registry is our own, with angle as a dimension: in a general one `g` is a gram, `au` a length,
and rad/s cannot be told from Hz.
"""

import math
import re
from dataclasses import dataclass, replace
from tokenize import TokenError

import numpy as np
import pint
from jaxtyping import Float64, Num

from ._recording import RecordingError

_DEFINITIONS = f"""
nano- = 1e-9 = n-
micro- = 1e-6 = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
kilo- = 1e3 = k-
second = [time] = s = sec
minute = 60 * second = min
hour = 3600 * second = h = hr
meter = [length] = m = metre
foot = 0.3048 * meter = ft
radian = [angle] = rad
degree = {math.pi / 180!r} * radian = deg
arcminute = degree / 60 = arcmin
arcsecond = degree / 3600 = arcsec
revolution = 360 * degree = rev
revolutions_per_minute = revolution / minute = rpm
degrees_per_second = degree / second = dps
degrees_per_hour = degree / hour = dph
standard_gravity = 9.80665 * meter / second ** 2 = g = gn
galileo = 0.01 * meter / second ** 2 = Gal
hertz = 1 / second = Hz
root_s = second ** 0.5
root_h = hour ** 0.5
root_hz = hertz ** 0.5
volt = [voltage] = V
kelvin = [temperature] = K
celsius = [temperature] = degC = C
fahrenheit = [temperature] = degF = F
tesla = [magnetic_field] = T
gauss = 1e-4 * tesla = Gs
pascal = [pressure] = Pa
count = [count] = cts = LSB = lsb = digit = digits = code
arbitrary_unit = [arbitrary] = au = u
"""

# Spellings met in headers, as patterns and what the registry knows them by.
_SPELLINGS = (
    (re.compile("[°º]"), "deg"),
    (re.compile("[µμ]"), "u"),  # the micro sign and the Greek letter
    (re.compile("²"), "^2"),
    (re.compile("[·⋅.]"), "*"),
    (re.compile(r"(?<=s)(-?)([12])$"), r"^\1\2"),  # m/s2, m s-2
    (re.compile(r"^ms(?=\^-2$)"), "m s"),  # ms-2, which nobody means as milliseconds
)

# The parser evaluates what it is given, so a tower of powers would never end: one digit is plenty.
_PLAUSIBLE = re.compile(r"(?:[A-Za-z_]++|[*/ ]|(?:\^|\*\*)-?[1-9](?![\d^]|\*\*))+")

# Roots of the time units in which noise is quoted, in any spelling: √Hz, sqrt(h), rt-hr, root hour.
_ROOT = re.compile(
    r"(?:√|sqrt|rt|root)[\s-]*(\()?\s*(hz|hours?|hr|h|seconds?|sec|s)\b\s*(?(1)\))", re.IGNORECASE
)
# A number, perhaps by another, and a unit.
_SCALED = re.compile(r"\s*([\d.][\d.eE+-]*)\s*(?:/\s*([\d.][\d.eE+-]*))?\s*[* ]\s*(\D.*)")
_COMPOUND = re.compile(_PLAUSIBLE.pattern.replace("[*/ ]", "[*/ ()]"))

# The parser fails in many ways on what is no unit; all mean the same here.
_UNPARSED = (
    pint.PintError,
    AttributeError,
    AssertionError,
    ValueError,
    TypeError,
    SyntaxError,
    TokenError,
)

_KNOWN = (
    "rad/s, deg/s, deg/h, dps, mdps or rpm for an angular rate, m/s^2, g, mg or ug for an "
    "acceleration, counts for neither"
)


@dataclass(frozen=True)
class Unit:
    """A unit and its way to SI."""

    name: str
    """As the user wrote it."""
    factor: float = 1.0
    """One such unit in SI; 1 when `kind` is `other`."""
    si_unit: str = ""
    """`rad/s`, `m/s^2`, or the name itself."""
    kind: str = "other"
    """`gyro`, `accelerometer` or `other`."""
    scale: float = 1.0
    """How many of it one in the file is: other than 1 for raw codes."""

    def read(self, column: Num[np.ndarray, " samples"]) -> Float64[np.ndarray, " samples"]:
        """Values of a file in this unit."""
        # Bytes that are no number give a NaN that warns.
        with np.errstate(invalid="ignore", over="ignore"):
            return column.astype(np.float64) * self.scale


# In words, or after a degree sign or `deg`; letters alone are capitals, since k and f are prefixes.
_TEMPERATURE = re.compile(
    r"(?:[°º]|deg(?:ree)?s?)?\s*(celsius|kelvin|fahrenheit)|(?:[°º]|deg(?:ree)?s?)\s*([ckf])",
    re.IGNORECASE,
)
# To degC: the size of a degree, and what is added.
_TEMPERATURES = {"c": (1.0, 0.0), "k": (1.0, -273.15), "f": (5 / 9, -160 / 9)}


def temperature_scale(name: str) -> tuple[float, float] | None:
    """Degrees C in one degree of the unit called `name`, and what to add; None if it has none."""
    text = name.strip().replace("℃", "degC").replace("℉", "degF")
    spelled = _TEMPERATURE.fullmatch("deg" + text if text in ("C", "K", "F") else text)
    return _TEMPERATURES[(spelled[1] or spelled[2])[0].lower()] if spelled else None


def _registry() -> pint.UnitRegistry:
    # None is the documented way to an empty registry, against the annotation.
    registry = pint.UnitRegistry(None)  # pyright: ignore[reportArgumentType]
    for line in _DEFINITIONS.strip().splitlines():
        registry.define(line)
    return registry


_REGISTRY = _registry()
_SI = (
    ("gyro", "rad/s", _REGISTRY.parse_units("radian / second")),
    ("accelerometer", "m/s^2", _REGISTRY.parse_units("meter / second ** 2")),
)


def parse_unit(name: str) -> Unit:
    """The unit called `name`.

    A unit that is known but measures neither an angular rate nor an acceleration passes through
    as it is, and so does an empty name.

    **Raises** `RecordingError` listing the known units when the name is none of them.
    """
    text = name.strip()
    if text in ("", "1", "-"):
        return Unit(text, si_unit=text)
    parsed = _parse(text)
    if parsed is None:
        raise RecordingError(f"The unit {text!r:.60} is not known: give {_KNOWN}.")
    for kind, si_unit, target in _SI:
        if parsed.dimensionality == target.dimensionality:
            factor = _REGISTRY.Quantity(1.0, parsed).to(target).magnitude
            return Unit(text, float(factor), si_unit, kind)
    return Unit(text, si_unit=text)


def parse_given(text: str) -> list[Unit]:
    """The units that a user gives, with commas between, each perhaps behind a scale factor.

    As in `deg/s, g` for channels of both kinds, and in `1/131 deg/s` or `61e-6 g` for raw codes.

    **Raises** `RecordingError` as `parse_unit` does, and for a factor that is not positive.
    """
    found = []
    for each in text.split(","):
        number = _SCALED.fullmatch(each)
        if number is None:
            found.append(parse_unit(each))
            continue
        try:
            scale = float(number[1]) / float(number[2] or 1.0)
        except (ValueError, ZeroDivisionError):
            scale = math.nan
        if not 0 < scale < math.inf:
            raise RecordingError(
                f"The scale factor in {text!r:.60} is no positive number: write it before the "
                "unit, as in --unit '1/131 deg/s' or --unit '61e-6 g'."
            )
        found.append(replace(parse_unit(number[3]), scale=scale))
    return found


def parse_compound(name: str) -> pint.Unit | None:
    """The unit called `name`, which may hold roots and brackets as in `(deg/h)/√Hz`; else None."""
    return _parse(_ROOT.sub(_as_name, name.strip()), _COMPOUND)


def _as_name(root: re.Match[str]) -> str:
    unit = root[2].lower()
    return "root_hz" if unit == "hz" else f"root_{unit[0]}"


def ratio(unit: str, other: str) -> float | None:
    """How many of `other` one `unit` is, None where they measure different things."""
    numerator, denominator = parse_compound(unit), parse_compound(other)
    if numerator is None or denominator is None:
        return None
    if numerator.dimensionality != denominator.dimensionality:
        return None
    return float(_REGISTRY.Quantity(1.0, numerator).to(denominator).magnitude)


def _parse(text: str, plausible: re.Pattern[str] = _PLAUSIBLE) -> pint.Unit | None:
    spelled = text
    for pattern, known in _SPELLINGS:
        spelled = pattern.sub(known, spelled)
    # Exactly as written first: `Gal` and `G`, `mV` and `MV` differ in case alone.
    for candidate in (spelled, spelled.lower()):
        if len(candidate) <= 40 and plausible.fullmatch(candidate):
            try:
                return _REGISTRY.parse_units(candidate)
            except _UNPARSED:
                continue
    return None
