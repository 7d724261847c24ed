"""Numbers as text: the one place where a value, its interval and its unit become characters.

The interval sets the digits: half its width is shown to two significant digits, and the value
and both bounds are rounded at that same decimal place, so rounding can never put the value
outside its interval.
"""

import math
from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Decimal
from typing import NamedTuple, SupportsFloat

Number = int | float  # JSON writes a whole number without a point

_SIGNIFICANT = 2
_NO_INTERVAL_DIGITS = 4
# Outside this range of magnitudes a plain decimal is harder to read than an exponent.
_PLAIN_EXPONENTS = range(-3, 6)
# Below this, a p-value from a chi-square tail has no digits worth printing.
_SMALLEST_P_VALUE = 1e-12


class Reading(NamedTuple):
    """One coefficient in one unit, ready to print."""

    value: str  # "0.300", or "< 0.013" for an upper limit
    interval: str  # "[0.298, 0.302]", or "" where there is none
    unit: str

    def __str__(self) -> str:
        return " ".join(part for part in self if part)


def finite(number: SupportsFloat) -> float | None:
    """The number, or nothing where JSON has no word for it."""
    return float(number) if math.isfinite(number) else None


def _finite(number: Number | None) -> bool:
    return number is not None and math.isfinite(number)


def _exact(number: Number) -> Decimal:
    # Twelve digits drop the residue of a change of unit, which rounding up would make visible.
    return Decimal(f"{number:.12g}")


def _rounded(number: Decimal, place: int, rounding: str = ROUND_HALF_EVEN) -> Decimal:
    return number.quantize(Decimal(1).scaleb(place), rounding=rounding)


def _characters(number: Decimal, scientific: bool) -> str:
    return f"{number:e}" if scientific else f"{number:f}"


def _is_scientific(number: Decimal) -> bool:
    return bool(number) and number.adjusted() not in _PLAIN_EXPONENTS


def significant(number: Number | None, digits: int = 4) -> str:
    """A number without an interval, to `digits` significant digits; "undefined" if it is none."""
    if number is None or not math.isfinite(number):
        return "undefined"
    exact = _exact(number)
    if not exact:
        return "0"
    # A decimal that is shorter than the digits asked for is shown as it is: 100 Hz, not 100.0.
    place = max(exact.adjusted() - digits + 1, exact.normalize().as_tuple().exponent)
    rounded = _rounded(exact, int(place))
    return _characters(rounded, _is_scientific(rounded))


def reading(
    value: Number | None,
    interval: Sequence[Number | None] | None,
    unit: str,
    *,
    signed: bool = False,
) -> Reading:
    """A value with its interval, both in `unit`.

    A number that would be rounded to zero beside a much larger one keeps two digits of its own,
    since a printed zero would claim what the data cannot show; not so one that is `signed`, of
    which zero is as good a value as its neighbours.
    """
    if value is None or not math.isfinite(value):
        return Reading("undefined", "", unit)
    low, high = interval if interval is not None and len(interval) == 2 else (None, None)
    if low is None or high is None or not (_finite(low) and _finite(high) and low < high):
        return Reading(significant(value, _NO_INTERVAL_DIGITS), "", unit)
    numbers = [_exact(number) for number in (value, low, high)]
    place = ((numbers[2] - numbers[1]) / 2).adjusted() - _SIGNIFICANT + 1
    scientific = _is_scientific(max(numbers, key=abs))

    def at_common_place(number: Decimal) -> str:
        rounded = _rounded(number, place)
        if signed and not rounded:
            return "0"
        if number and not rounded:
            own = _rounded(number, number.adjusted() - _SIGNIFICANT + 1)
            return _characters(own, _is_scientific(own))
        return _characters(rounded, scientific)

    middle, lower, upper = map(at_common_place, numbers)
    return Reading(middle, f"[{lower}, {upper}]", unit)


def upper_limit(limit: Number | None, unit: str) -> Reading:
    """The 95 % upper limit of a term that is not resolved, rounded up so that it stays a limit."""
    if limit is None or not math.isfinite(limit) or limit <= 0:
        return Reading("no limit", "", unit)
    exact = _exact(limit)
    rounded = _rounded(exact, exact.adjusted() - _SIGNIFICANT + 1, ROUND_CEILING)
    return Reading(f"< {_characters(rounded, _is_scientific(rounded))}", "", unit)


def p_value(probability: Number) -> str:
    """`p = 0.41`, `p = 3.2e-7` or `p < 1e-12`."""
    if probability < _SMALLEST_P_VALUE:
        return "p < 1e-12"
    return f"p = {significant(probability, 2)}"


def percent(probability: Number | None) -> str:
    """A probability in per cent, never rounded to certainty: `98 %`, `> 99.9 %`, `< 0.1 %`."""
    if probability is None or not math.isfinite(probability):
        return "undefined"
    if probability > 0.999:
        return "> 99.9 %"
    if probability < 0.001:
        return "< 0.1 %"
    return f"{significant(100 * probability, 3 if probability > 0.99 else 2)} %"


def beside_error(value: Number | None, error: Number | None) -> str:
    """A value rounded at the place at which its standard error shows two digits."""
    if value is None or error is None or not (_finite(value) and _finite(error) and error > 0):
        return significant(value)
    return _characters(_rounded(_exact(value), _exact(error).adjusted() - _SIGNIFICANT + 1), False)


def with_error(value: Number | None, error: Number | None) -> str:
    """A value and its standard error, both at one place: `247 ± 21`."""
    shown = beside_error(value, error)
    if error is None or not _finite(error) or error <= 0 or shown == "undefined":
        return shown
    return f"{shown} \N{PLUS-MINUS SIGN} {beside_error(error, error)}"


def duration(seconds: Number) -> str:
    """A length of time in the largest unit that it fills: `90 s`, `2.5 min`, `1 h`, `3.5 days`."""
    for size, name in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= (2 * size if size != 3600.0 else size):
            return f"{significant(seconds / size, 3)} {name}"
    return f"{significant(seconds, 3)} s"


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of as many cells each as lines whose columns begin below each other."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def listed(phrases: Iterable[str]) -> str:
    """Phrases as in a sentence: `a`, `a and b`, `a, b and c`."""
    *others, last = phrases
    return f"{', '.join(others)} and {last}" if others else last


def printable(text: str) -> str:
    """A user's string with control characters replaced, so that it cannot steer a terminal."""
    return "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text
    )
