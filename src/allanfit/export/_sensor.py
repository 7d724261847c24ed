"""One set of numbers for the axes of a gyro or an accelerometer, in SI."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ..formatting import printable, significant
from ..physics import ALLAN_FLOOR, BiasInstability, RateRandomWalk, WhiteNoise, coefficient_unit
from ._doubts import doubts
from ._effect_parts import left_out
from ._errors import ExportError
from ._options import LIMIT, Options
from ._read import Coefficient, FitChannel, FitFile

_TERMS = {"N": WhiteNoise, "B": BiasInstability, "K": RateRandomWalk}
KINDS = {"gyro": "gyroscope", "accelerometer": "accelerometer"}


@dataclass(frozen=True)
class Number:
    """A value in SI, and the sentence that says where it comes from."""

    value: float
    unit: str
    how: str


@dataclass(frozen=True)
class Sensor:
    """The axes of one kind, which share a rate."""

    kind: str
    axes: tuple[FitChannel, ...]

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.axes[0].rate_hz

    @property
    def names(self) -> str:
        """The axes, for a comment."""
        return ", ".join(printable(axis.name) for axis in self.axes)

    def si(self, axis: FitChannel, symbol: str) -> Coefficient:
        """A coefficient of an axis in SI."""
        unit = coefficient_unit(_TERMS[symbol], axis.si_unit)
        return axis.coefficients[symbol].times(axis.si_factor, unit)

    def each(self, symbol: str) -> list[float]:
        """A coefficient of every axis in SI, zero where it is not resolved."""
        found = [self.si(axis, symbol) for axis in self.axes]
        return [term.value if term.resolved else 0.0 for term in found]

    def one(self, symbol: str, options: Options) -> Number | None:
        """The coefficient of the worst axis, or the mean of all; None if no axis resolves it."""
        terms = {axis.name: self.si(axis, symbol) for axis in self.axes}
        values = {name: term.value for name, term in terms.items() if term.resolved}
        if not values:
            return None
        unit = next(iter(terms.values())).unit
        worst = max(values, key=values.__getitem__)
        if options.axes == "worst":
            how = f"{symbol} of {printable(worst)}{_interval(terms[worst])}"
            number = Number(values[worst], unit, how)
        else:
            number = Number(_root_mean_square(values.values()), unit, f"{symbol}, {_MEAN}")
        return _with_unresolved(number, symbol, terms)

    def walk(self, options: Options) -> Number | None:
        """The random walk of a filter that has no flicker, as `Options.walk` wishes."""
        if options.walk is None:
            return self.one("K", options)
        if options.walk == LIMIT:
            values = {axis.name: self._limit(axis) for axis in self.axes}
            meaning = "K, or its 95 % upper limit where it is not resolved"
        else:
            values = {axis.name: self._covering(axis, options.walk) for axis in self.axes}
            meaning = (
                f"sqrt(K^2 + 3 (2 ln 2/pi) B^2/tau), which drifts as far as B and K do together "
                f"in tau = {significant(options.walk)} s"
            )
        values = {name: value for name, value in values.items() if value > 0}
        if not values:
            return None
        unit = self.si(self.axes[0], "K").unit
        worst = max(values, key=values.__getitem__)
        if options.axes == "worst":
            return Number(values[worst], unit, f"{meaning}; {printable(worst)}")
        return Number(_root_mean_square(values.values()), unit, f"{meaning}; {_MEAN}")

    def required_walk(self, options: Options, what: str) -> Number:
        """The random walk where a format must have one.

        **Raises:** `ExportError` that offers what could stand for it.
        """
        found = self.walk(options)
        if found is not None:
            return found
        bias = self.one("B", options)
        choice = "--walk limit for its 95 % upper limit"
        if bias is not None:
            choice += ", or --walk SECONDS for a walk that drifts as far as B in that time"
        elif options.walk not in (None, LIMIT):
            choice = "--walk limit for its 95 % upper limit (B is not resolved either)"
        raise ExportError(
            f"K of {self.names} is not resolved, and {what} needs one: give {choice}."
        )

    def _limit(self, axis: FitChannel) -> float:
        term = self.si(axis, "K")
        return term.value if term.resolved else term.upper_limit_95 or 0.0

    def _covering(self, axis: FitChannel, seconds: float) -> float:
        """The walk whose Allan variance at `seconds` is that of B and K together."""
        walk, bias = self.si(axis, "K"), self.si(axis, "B")
        square = walk.value**2 * walk.resolved
        square += 3 * ALLAN_FLOOR * bias.value**2 * bias.resolved / seconds
        return math.sqrt(square)


_MEAN = "root of the mean square of the axes"


def sensors(fit: FitFile, what: str) -> tuple[dict[str, Sensor], list[str]]:
    """Gyroscope and accelerometer of a fit, and what is doubtful, missing or left out.

    **Raises:** `ExportError` if there is neither, or if rates differ.
    """
    found, notes, channels = {}, [], fit.channels
    for kind, name in KINDS.items():
        axes = tuple(channel for channel in channels if channel.kind == kind)
        if axes:
            found[kind] = Sensor(kind, axes)
        else:
            notes.append(f"The fit has no {name}, so that its numbers are missing.")
    known = [axis for sensor in found.values() for axis in sensor.axes]
    if not known:
        units = ", ".join(f"{channel.name} in {channel.unit or 'no unit'}" for channel in channels)
        raise ExportError(
            f"{what} takes angular rates and accelerations, and the fit has {units}: fit again "
            "with --unit, such as deg/s or m/s^2."
        )
    notes += [
        f"{channel.name} is neither an angular rate nor an acceleration, and is left out."
        for channel in channels
        if channel not in known
    ]
    rates = {axis.rate_hz: axis.name for axis in known}
    if len(rates) > 1:
        (first, one), (second, other) = list(rates.items())[:2]
        raise ExportError(
            f"{one} has {first:g} Hz and {other} {second:g} Hz, and {what} takes one rate: choose "
            "channels of one rate with --channel."
        )
    return found, [*doubts(fit, known), *notes, *left_out(known, _capital(what), frozenset())]


def _capital(words: str) -> str:
    """`a ROS estimator` begins a sentence, `imuSensor` is a name."""
    return words[0].upper() + words[1:] if words.startswith("a ") else words


def _root_mean_square(values: Iterable[float]) -> float:
    squares = [value**2 for value in values]
    return math.sqrt(sum(squares) / len(squares))


def _interval(term: Coefficient) -> str:
    pair = term.intervals.get("0.95")
    return "" if pair is None else f", 95 % interval {pair[0]:.4g} to {pair[1]:.4g}"


def _with_unresolved(number: Number, symbol: str, terms: dict[str, Coefficient]) -> Number:
    limits = [
        f"{printable(name)} (< {term.upper_limit_95:.3g})"
        for name, term in terms.items()
        if not term.resolved and term.upper_limit_95 is not None
    ]
    if not limits:
        return number
    how = f"{number.how}; {symbol} is not resolved for {', '.join(limits)}"
    return Number(number.value, number.unit, how)
