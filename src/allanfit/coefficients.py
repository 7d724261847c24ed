"""Read noise coefficients from a file: a fit, an explanation, a data sheet, or lines of YAML."""

import math
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, get_args

from .coefficient_units import UNITS
from .datasheet import Datasheet, datasheet_from, is_datasheet
from .mapping_file import read_mapping
from .physics import SYMBOLS, AbstractEffect, Sampling, effect_from, scaled
from .recording import RecordingError
from .recording._units import parse_unit

_HINT = "a fit's JSON, a data sheet, or lines such as `N: 0.005`"
# The squares of larger ones leave the range of floating point.
_LARGEST = 1e100
#: What the JSON of a fit calls its status.
CONVERGED, NOT_CONVERGED = "converged", "the fit did not converge"
_INCOMPLETE = "{} is not a complete fit JSON; write it again with allanfit fit --json."


class CoefficientsError(ValueError):
    """A coefficients file cannot be used; one sentence says why and what to do."""


class Unresolved(NamedTuple):
    """What a fit knows of a term that it cannot tell from none."""

    median: float
    upper_limit_95: float | None


@dataclass(frozen=True)
class Coefficients:
    """The coefficients and effects of one channel, in its unit and seconds."""

    channel: str
    unit: str
    values: dict[str, float]
    """Without what a fit has not resolved."""
    sampling: Sampling = "point"
    bias: float = 0.0
    effects: tuple[AbstractEffect, ...] = ()
    unresolved: dict[str, Unresolved] = field(default_factory=dict)

    @property
    def medians(self) -> dict[str, float]:
        """What the figure of a fit draws: unresolved terms too, but no ramp that is none."""
        # Half of all ramps that cannot be seen point the other way.
        unseen = {s: term.median for s, term in self.unresolved.items() if s != "R"}
        return self.values | unseen

    def times(self, factor: float, unit: str) -> "Coefficients":
        """The same in another unit."""
        return replace(
            self,
            unit=unit,
            values={symbol: value * factor for symbol, value in self.values.items()},
            bias=self.bias * factor,
            effects=tuple(scaled(effect, factor) for effect in self.effects),
            unresolved={
                symbol: Unresolved(
                    term.median * factor,
                    None if term.upper_limit_95 is None else term.upper_limit_95 * factor,
                )
                for symbol, term in self.unresolved.items()
            },
        )


def read_coefficients(path: str | Path, channels: list[str] | None = None) -> list[Coefficients]:
    """The coefficients of each channel of a file.

    A fit's JSON (schema allanfit.fit/1) gives every channel, with the posterior medians of what
    is resolved; the rest is beside them, as `unresolved`. That of explain (schema
    allanfit.explain/1) gives the coefficients beside the effects that it names, and the effects.
    A data sheet (see `allanfit.read_datasheet`) gives channels named like its sections, in SI.
    Any other JSON or YAML file is a mapping of symbols to numbers, with an optional `unit` and
    `effects`, for one channel named `data`:

        unit: deg/s
        N: 0.005
        B: 0.001
        effects:
        - {name: gauss_markov, sigma: 0.002, correlation_time: 30}

    **Raises:** `CoefficientsError` if the file is missing, no such mapping, lacks a channel, or
    holds a fit that did not converge;
    `DatasheetError` if something in a data sheet is not understood.
    """
    path = Path(path)
    document = read_mapping(path, "coefficients", _HINT, CoefficientsError)
    if "channels" in document:
        entries = document["channels"]
        if not isinstance(entries, list) or not entries:
            raise CoefficientsError(_INCOMPLETE.format(path.name))
        # What did not converge holds no numbers to be read.
        if why := why_failed(entries, channels, path.name):
            raise CoefficientsError(why)
        found = [_from_fit(entry, path) for entry in entries if converged(entry)]
    elif is_datasheet(document):
        found = _from_datasheet(datasheet_from(document, path.name))
    else:
        found = [_from_mapping(document, path)]
    names = [entry.channel for entry in found]
    missing = sorted(set(channels or []) - set(names))
    if missing:
        raise CoefficientsError(
            f"{path.name} has no channel {missing[0]!r}; it has {', '.join(names)}."
        )
    return [entry for entry in found if not channels or entry.channel in channels]


def why_failed(entries: Sequence[Any], channels: list[str] | None, file: str) -> str:
    """Why a fit's JSON, or the channels named, cannot be used: "" where all fits converged."""
    for each in entries:
        name = each.get("channel") if isinstance(each, Mapping) else None
        if not converged(each) and (not channels or name in channels):
            return (
                f"The fit of {name} in {file} did not converge, and its numbers mean "
                "nothing: choose other channels with --channel, or fit again."
            )
    return ""


def converged(entry: Any) -> bool:
    """Whether a channel of a fit's JSON does not say that its fit failed."""
    return not isinstance(entry, Mapping) or entry.get("status", CONVERGED) == CONVERGED


def coefficients_of(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """The coefficients by symbol of a channel of a JSON: a fit's, or explain's beside its effects.

    **Raises:** `KeyError` if it has none.
    """
    if "coefficients" in entry:
        return entry["coefficients"]
    # Where nothing is left out there is nothing to put in.
    return entry["coefficients_after"] or entry["coefficients_before"]


def effects_of(entry: Mapping[str, Any]) -> tuple[AbstractEffect, ...]:
    """The effects of a channel of explain's JSON, or of YAML, in the unit of the channel.

    In the one a parameter is a mapping with its `value` under `parameters`, in the other a number
    beside the name.

    **Raises:** `KeyError`, `TypeError` or `ValueError` if it is neither.
    """
    found = []
    for each in entry.get("effects") or []:
        given = each.get("parameters", {key: each[key] for key in each if key != "name"})
        values = {
            name: value["value"] if isinstance(value, Mapping) else value
            for name, value in given.items()
        }
        known = {name: value for name, value in values.items() if value is not None}
        found.append(effect_from(str(each["name"]), known))
    return tuple(found)


def _from_fit(entry: Any, path: Path) -> Coefficients:
    try:
        terms = coefficients_of(entry)
        values = {symbol: float(terms[symbol]["value"]) for symbol in SYMBOLS}
        unresolved = {
            symbol: Unresolved(values.pop(symbol), _limit(terms[symbol]))
            for symbol in SYMBOLS
            if not terms[symbol]["resolved"]
        }
        _checked({symbol: term.median for symbol, term in unresolved.items()}, path)
        bias = float(entry.get("mean", 0.0))
        sampling = entry.get("sampling", "point")
        if not abs(bias) <= _LARGEST or not isinstance(entry["channel"], str):
            raise TypeError(bias)
        return Coefficients(
            entry["channel"],
            _unit(entry["unit"]),
            _checked(values, path),
            _sampling(sampling, path),
            bias,
            _effects(entry, path),
            unresolved,
        )
    except CoefficientsError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise CoefficientsError(_INCOMPLETE.format(path.name)) from error


def _limit(term: Mapping[str, Any]) -> float | None:
    limit = term.get("upper_limit_95")
    return None if limit is None else float(limit)


def _from_datasheet(sheet: Datasheet) -> list[Coefficients]:
    """A channel a section, in SI; random walks before densities, typical values before largest."""
    found: dict[str, Coefficients] = {}
    for line in sorted(sheet.lines, key=lambda each: each.indirectness):
        unit = UNITS[line.kind]["B"].si
        entry = found.setdefault(line.section, Coefficients(line.section, unit, {}))
        entry.values.setdefault(line.symbol, line.coefficient)
    return [found[section] for section in dict.fromkeys(line.section for line in sheet.lines)]


def _from_mapping(document: Mapping[str, Any], path: Path) -> Coefficients:
    unknown = sorted(str(key) for key in set(document) - {*SYMBOLS, "unit", "sampling", "effects"})
    if unknown:
        raise CoefficientsError(
            f"{path.name} names {unknown[0]!r}; known are {', '.join(SYMBOLS)}, unit, sampling "
            "and effects."
        )
    sampling = _sampling(document.get("sampling", "point"), path)
    values = {symbol: document[symbol] for symbol in SYMBOLS if symbol in document}
    if not values:
        raise CoefficientsError(f"{path.name} holds none of the coefficients {', '.join(SYMBOLS)}.")
    return Coefficients(
        "data",
        _unit(document.get("unit", "")),
        _checked(values, path),
        sampling,
        effects=_effects(document, path),
    )


def _unit(name: Any) -> str:
    """A unit that the recordings made of these coefficients can be read in."""
    if not isinstance(name, str):
        name = reprlib.repr(name)
    try:
        parse_unit(name)
    except RecordingError as error:
        raise CoefficientsError(str(error)) from error
    return name


def _sampling(name: Any, path: Path) -> Sampling:
    if name not in get_args(Sampling):
        raise CoefficientsError(f"sampling in {path.name} must be point or averaged.")
    return name


def _effects(entry: Mapping[str, Any], path: Path) -> tuple[AbstractEffect, ...]:
    try:
        return effects_of(entry)
    except ValueError as error:
        raise CoefficientsError(f"In {path.name}, {error}.") from error
    except (KeyError, TypeError, AttributeError) as error:
        raise CoefficientsError(
            f"An effect in {path.name} needs its name and parameters, such as "
            "{name: warm_up, amplitude: 0.1, time_constant: 600}."
        ) from error


def _checked(values: Mapping[str, Any], path: Path) -> dict[str, float]:
    return {symbol: _number(symbol, value, path) for symbol, value in values.items()}


def _number(symbol: str, value: Any, path: Path) -> float:
    try:
        # YAML takes 5e-3, without a point, for text.
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not 0 <= number <= _LARGEST:
        raise CoefficientsError(
            f"{symbol} in {path.name} must be a number, zero or more and at most {_LARGEST:g}; got "
            f"{reprlib.repr(value)}."
        )
    return number
