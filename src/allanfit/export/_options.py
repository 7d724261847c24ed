"""What can be chosen when a fit is exported."""

import math
from dataclasses import dataclass
from typing import Literal

from ._errors import ExportError

Axes = Literal["worst", "mean"]
LIMIT = "limit"


@dataclass(frozen=True)
class Options:
    """Choices, each of use to some formats only."""

    axes: Axes = "worst"
    """One number for some axes: the largest, or the root of the mean square."""
    band_s: tuple[float, float] | None = None
    """Averaging times in which flicker must be right [s]."""
    walk: float | Literal["limit"] | None = None
    """The random walk of formats without flicker: see `parse_walk`."""
    rostopic: str = "/imu0"


def parse_walk(text: str | None) -> float | Literal["limit"] | None:
    """`limit`, or seconds, or None.

    **Raises:** `ExportError` for anything else.
    """
    if text is None or text == LIMIT:
        return text  # pyright: ignore[reportReturnType]  (the comparison has made it a literal)
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0):
        raise ExportError(f"The walk must be `limit` or a number of seconds; got {text!r}.")
    return seconds
