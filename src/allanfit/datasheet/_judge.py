"""Whether a sensor keeps to its data sheet: the posterior probability of each line."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from ..physics import SYMBOLS
from ._lowest import lowest_of_curve, lowest_of_model
from ._read import Datasheet
from ._words import Line, Meaning

SheetVerdict = Literal["met", "missed", "cannot be told"]

# As sure as a 95 % upper limit.
_SURE = 0.95


class Measured(NamedTuple):
    """A number with its 95 % interval and its one-sided 95 % limit."""

    middle: float
    low: float
    high: float
    limit: float

    def times(self, factor: float) -> "Measured":
        """The same in another unit, or under another reading."""
        return Measured(*(factor * each for each in self))


class Shown(NamedTuple):
    """What the fit of a channel shows, in SI."""

    draws: Float[np.ndarray, "draws terms"]
    """Q, N, B, K, R from the posterior."""
    coefficients: Mapping[str, Measured]
    """As the fit tells them, which allows for noises that are not resolved."""
    resolved: Mapping[str, bool]
    consistent: bool
    """Whether the five terms explain the recording."""
    dt: float
    """Sampling interval [s]."""
    sizes: Float[np.ndarray, " taus"]
    """Cluster sizes of the Allan deviation, in samples."""
    deviation: Float[np.ndarray, " taus"]
    samples: int


class _Values(NamedTuple):
    """What a line states, as measured [SI]."""

    draws: Float[np.ndarray, " draws"]
    measured: Measured
    seen: bool
    """False where only an upper limit is known."""
    of_curve: bool = False


@dataclass(frozen=True)
class Judged:
    """One line of a data sheet beside what the recording shows, in the line's unit."""

    line: Line
    verdict: SheetVerdict = "cannot be told"
    probability: float | None = None
    """That the sensor is at or below what is stated; None where nothing can be said."""
    measured: float | None = None
    """Median, read as the line is."""
    interval_95: tuple[float, float] | None = None
    upper_limit_95: float | None = None
    """One-sided, of what is not resolved; None where it is."""
    resolved: bool = False
    of_curve: bool = False
    """Read off the Allan deviation itself, since the five terms do not explain the recording."""
    as_coefficient: SheetVerdict | None = None
    """The verdict if the words meant the coefficient itself, where that is another."""

    def to_dict(self) -> dict[str, Any]:
        """This line's entry in the fit JSON."""
        return {
            "words": self.line.words,
            "coefficient": self.line.symbol,
            "as": self.line.meaning,
            "bound": self.line.bound,
            "unit": self.line.unit,
            "stated": self.line.number,
            "measured": self.measured,
            "interval_95": None if self.interval_95 is None else list(self.interval_95),
            "upper_limit_95": self.upper_limit_95,
            "resolved": self.resolved,
            "from": "curve" if self.of_curve else "posterior",
            "probability": self.probability,
            "verdict": self.verdict,
            "verdict_as_coefficient": self.as_coefficient,
        }


def judge(lines: Sequence[Line], shown: Shown | None) -> tuple[Judged, ...]:
    """What a fit says about each line; `shown` is None where it did not converge."""
    if shown is None:
        return tuple(Judged(line) for line in lines)
    return tuple(_judged(line, shown) for line in lines)


def datasheet_document(
    sheet: Datasheet, judged: Sequence[Judged], left_out: Sequence[str] = ()
) -> dict[str, Any]:
    """The `datasheet` of a channel in the fit JSON."""
    return {
        "file": sheet.file,
        "sensor": sheet.sensor,
        "source": sheet.source,
        "lines": [each.to_dict() for each in judged],
        "left_out": list(left_out),
    }


def _judged(line: Line, shown: Shown) -> Judged:
    values = _values(line.meaning, line.symbol, shown)
    probability, verdict = _verdict(line, values)
    as_coefficient = None
    # A wrong model's B says nothing about what a curve shows, and a random walk means itself.
    if line.meaning != "coefficient" and not values.of_curve:
        differs = _verdict(line, _values("coefficient", line.symbol, shown))[1]
        as_coefficient = None if differs == verdict else differs
    measured = values.measured.times(1 / line.factor)
    return Judged(
        line,
        verdict,
        probability,
        measured.middle,
        (measured.low if values.seen else 0.0, measured.high),
        None if values.seen else measured.limit,
        values.seen,
        values.of_curve,
        as_coefficient,
    )


def _verdict(line: Line, values: _Values) -> tuple[float | None, SheetVerdict]:
    probability = float(np.mean(values.draws <= line.number * line.factor))
    if probability >= _SURE:
        return probability, "met"
    if values.of_curve and not values.seen:
        return None, "cannot be told"
    return probability, "missed" if probability <= 1 - _SURE else "cannot be told"


def _values(meaning: Meaning, symbol: str, shown: Shown) -> _Values:
    """Draws of what a data sheet states under this reading."""
    if meaning == "allan_minimum" and not shown.consistent:
        lowest, reached = lowest_of_curve(shown.sizes, shown.deviation, shown.samples)
        return _Values(lowest, _of_draws(lowest), reached, True)
    draws = np.abs(np.asarray(shown.draws, np.float64))
    if meaning == "allan_minimum":
        # Each of the slow terms keeps the lowest deviation above zero.
        seen = any(shown.resolved[slow] for slow in "BKR")
        lowest = lowest_of_model(draws, shown.dt)
        return _Values(lowest, _of_draws(lowest), seen)
    coefficient = draws[:, SYMBOLS.index(symbol)]
    factor = math.sqrt(2) if meaning == "one_sided_density" else 1.0
    # The number of the table, not one that differs in its last digits.
    measured = shown.coefficients[symbol].times(factor)
    return _Values(factor * coefficient, measured, shown.resolved[symbol])


def _of_draws(draws: Float[np.ndarray, " draws"]) -> Measured:
    low, middle, limit, high = np.quantile(draws, [0.025, 0.5, 0.95, 0.975]).tolist()
    return Measured(middle, low, high, limit)
