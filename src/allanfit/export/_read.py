"""The channels of a fit's JSON, or of explain's, checked, as exports need them."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..coefficients import coefficients_of, converged, effects_of, why_failed
from ..formatting import printable
from ..physics import SYMBOLS, AbstractEffect, check_sampling
from ..recording import RecordingError
from ..recording._files import require_file
from ..recording._units import parse_unit
from ._errors import ExportError

_EXPLAIN_SCHEMA = "allanfit.explain/"
_SCHEMAS = ("allanfit.fit/", _EXPLAIN_SCHEMA)


@dataclass(frozen=True)
class Coefficient:
    """One term of one channel, in the channel's unit and seconds."""

    symbol: str
    name: str
    unit: str
    value: float
    resolved: bool
    upper_limit_95: float | None
    intervals: dict[str, tuple[float, float]]
    """By probability, "0.68" and "0.95"."""

    def times(self, factor: float, unit: str) -> "Coefficient":
        """The same in another unit."""
        limit = self.upper_limit_95
        return replace(
            self,
            unit=unit,
            value=self.value * factor,
            upper_limit_95=None if limit is None else limit * factor,
            intervals={key: (low * factor, high * factor) for key, (low, high) in self.items()},
        )

    def items(self) -> list[tuple[str, tuple[float, float]]]:
        """The intervals, by probability."""
        return list(self.intervals.items())

    def to_dict(self) -> dict[str, Any]:
        """As in a fit's JSON."""
        return {
            "name": self.name,
            "unit": self.unit,
            "value": self.value,
            "resolved": self.resolved,
            "upper_limit_95": self.upper_limit_95,
            "intervals": {key: list(pair) for key, pair in self.items()},
        }


@dataclass(frozen=True)
class FitChannel:
    """One channel of a fit."""

    name: str
    unit: str
    kind: str
    """`gyro`, `accelerometer` or `other`."""
    si_factor: float
    """One unit of the channel in SI; 1 for `other`."""
    si_unit: str
    rate_hz: float
    samples: int
    sampling: str
    mean: float
    consistent: bool
    """False if the terms, with the effects if there are any, do not explain the recording."""
    coefficients: dict[str, Coefficient]
    effects: tuple[AbstractEffect, ...] = ()
    """In the channel's unit."""

    @property
    def dt(self) -> float:
        """Sampling interval [s]."""
        return 1 / self.rate_hz

    @property
    def duration_s(self) -> float:
        """Length of the recording [s]."""
        return self.samples * self.dt


@dataclass(frozen=True)
class FitFile:
    """A fit's JSON: the recording's name and its channels."""

    recording: str
    channels: list[FitChannel]
    explained: bool = False
    """Whether it is of explain, which has looked for what the five terms leave out."""


def read_fit(path: str | Path, channels: list[str] | None = None) -> FitFile:
    """A fit's JSON, or explain's, whole or the channels named.

    Of explain's the coefficients are those beside its effects.

    **Raises:** `ExportError` if the file is missing, is no fit, lacks a channel, or holds one whose
    fit did not converge.
    """
    path = Path(path)
    name = printable(path.name)
    try:
        require_file(path)
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except RecordingError as error:
        raise ExportError(str(error)) from error
    except OSError as error:
        raise ExportError(f"Cannot read {name}: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:
        raise ExportError(_no_fit(name)) from error
    schema = document.get("schema") if isinstance(document, dict) else None
    if not (isinstance(schema, str) and schema.startswith(_SCHEMAS)):
        raise ExportError(_no_fit(name))
    try:
        failed = why_failed(document["channels"], channels, name)
        # What did not converge holds no numbers to be read.
        found = [_channel(entry) for entry in document["channels"] if converged(entry)]
        recording = str(document["recording"])
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise ExportError(
            f"{name} is not a complete fit JSON; write it again with allanfit fit --json or "
            "allanfit explain --json."
        ) from error
    if failed:
        raise ExportError(failed)
    known = [channel.name for channel in found]
    missing = [channel for channel in channels or [] if channel not in known]
    if missing:
        raise ExportError(f"{name} has no channel {missing[0]!r}; it has {', '.join(known)}.")
    if not found:
        raise ExportError(f"{name} has no channels; fit a recording that has some.")
    kept = [each for each in found if not channels or each.name in channels]
    return FitFile(recording, kept, schema.startswith(_EXPLAIN_SCHEMA))


def _no_fit(name: str) -> str:
    return (
        f"{name} is not a fit; give the JSON that allanfit fit --json wrote, or allanfit explain."
    )


def _channel(entry: Mapping[str, Any]) -> FitChannel:
    unit = str(entry["unit"])
    known = parse_unit(unit)
    terms = coefficients_of(entry)
    rate_hz = _positive(entry["rate_hz"])
    samples = entry["samples"] if "samples" in entry else rate_hz * _positive(entry["duration_s"])
    sampling = entry.get("sampling", "point")
    check_sampling(sampling)
    return FitChannel(
        name=_text(entry["channel"]),
        unit=unit,
        kind=known.kind,
        si_factor=known.factor,
        si_unit=known.si_unit,
        rate_hz=rate_hz,
        samples=round(_positive(samples)),
        sampling=sampling,
        mean=_finite(entry.get("mean", 0.0)),
        consistent=entry.get("goodness_of_fit", {}).get("consistent") is not False
        and entry.get("verdict") != "unexplained",
        coefficients={symbol: _coefficient(symbol, terms[symbol]) for symbol in SYMBOLS},
        effects=effects_of(entry),
    )


def _coefficient(symbol: str, entry: Mapping[str, Any]) -> Coefficient:
    limit = entry.get("upper_limit_95")
    return Coefficient(
        symbol=symbol,
        name=str(entry["name"]),
        unit=str(entry["unit"]),
        value=_not_negative(entry["value"]),
        resolved=bool(entry["resolved"]),
        upper_limit_95=None if limit is None else _not_negative(limit),
        intervals={
            str(key): (_not_negative(low), _not_negative(high))
            for key, (low, high) in entry["intervals"].items()
        },
    )


def _text(name: Any) -> str:
    if not isinstance(name, str):
        raise TypeError(name)
    return name


def _finite(number: Any) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise ValueError(number)
    return value


def _not_negative(number: Any) -> float:
    value = _finite(number)
    if value < 0:
        raise ValueError(number)
    return value


def _positive(number: Any) -> float:
    value = _not_negative(number)
    if value == 0:
        raise ValueError(number)
    return value
