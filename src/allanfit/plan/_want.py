"""What is wanted of a record: a relative standard error for each coefficient named."""

import math
from collections.abc import Mapping

from ..physics import SYMBOLS

_EXAMPLE = "N=1%,B=10%"


def parse_want(text: str) -> dict[str, float]:
    """Relative standard errors by symbol from `N=1%,B=10%`; a fraction, `N=0.01`, will do.

    **Raises:** `ValueError` for what is no such list, an unknown or repeated symbol, and an error
    that is not between 0 and 100 %.
    """
    want: dict[str, float] = {}
    for item in text.split(","):
        symbol, equals, number = (part.strip() for part in item.partition("="))
        if not (symbol and equals and number):
            raise ValueError(
                f"--want takes a list such as {_EXAMPLE}; {item.strip()!r} is no part of one."
            )
        if symbol in want:
            raise ValueError(f"--want names {symbol} twice; give it once.")
        want[symbol] = _fraction(symbol, number)
    return checked_want(want)


def checked_want(want: Mapping[str, float]) -> dict[str, float]:
    """The same mapping; `ValueError` where it asks for nothing, or for what cannot be."""
    if not isinstance(want, Mapping):
        raise ValueError(
            "want is a mapping of symbols to fractions, as {'N': 0.01, 'B': 0.1}; "
            f"got {want!r:.60}."
        )
    if not want:
        raise ValueError(f"Nothing is wanted; name a coefficient and its error, as in {_EXAMPLE}.")
    for symbol, error in want.items():
        if symbol not in SYMBOLS:
            raise ValueError(f"{symbol!r} is wanted; coefficients are {', '.join(SYMBOLS)}.")
        if not 0 < error < 1:
            raise ValueError(
                f"{symbol} is wanted to {100 * error:.6g} %; "
                "a relative standard error must be above 0 and below 100 %."
            )
    return {symbol: float(error) for symbol, error in want.items()}


def _fraction(symbol: str, number: str) -> float:
    percent = number.endswith("%")
    try:
        value = float(number.removesuffix("%"))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(
            f"{symbol} is wanted to {number!r}, which is no number; write {symbol}=1% or 0.01."
        )
    if not percent and value >= 1:
        raise ValueError(f"{symbol}={number} has no percent sign; write {symbol}={number}%.")
    return value / 100 if percent else value
