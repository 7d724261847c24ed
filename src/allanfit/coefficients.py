"""Read noise coefficients from a file: JSON of a fit or of explain, or lines of YAML or JSON."""

import json
import math
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .physics import SYMBOLS, AbstractEffect, Sampling, effect_from, scaled
from .recording import RecordingError
from .recording._files import require_file
from .recording._units import parse_unit

# The squares of larger ones leave the range of floating point.
_LARGEST = 1e100
_INCOMPLETE = "{} is not a complete fit JSON; write it again with allanfit fit --json."


class CoefficientsError(ValueError):
    """A coefficients file cannot be used; one sentence says why and what to do."""


@dataclass(frozen=True)
class Coefficients:
    """The coefficients and effects of one channel, in its unit and seconds."""

    channel: str
    unit: str
    values: dict[str, float]
    sampling: Sampling = "point"
    bias: float = 0.0
    effects: tuple[AbstractEffect, ...] = ()

    def times(self, factor: float, unit: str) -> "Coefficients":
        """The same in another unit."""
        return replace(
            self,
            unit=unit,
            values={symbol: value * factor for symbol, value in self.values.items()},
            bias=self.bias * factor,
            effects=tuple(scaled(effect, factor) for effect in self.effects),
        )


def read_coefficients(path: str | Path, channels: list[str] | None = None) -> list[Coefficients]:
    """The coefficients of each channel of a file.

    A fit's JSON (schema allanfit.fit/1) gives every channel, with the values that its figure
    draws: medians, and no ramp where none is resolved. That of explain (schema
    allanfit.explain/1) gives the coefficients beside the effects that it names, and the effects.
    Any other JSON or YAML file is a mapping of symbols to numbers, with an optional `unit` and
    `effects`, for one channel named `data`:

        unit: deg/s
        N: 0.005
        B: 0.001
        effects:
        - {name: gauss_markov, sigma: 0.002, correlation_time: 30}

    **Raises:** `CoefficientsError` if the file is missing, no such mapping, or lacks a channel.
    """
    path = Path(path)
    document = _parse(path)
    if "channels" in document:
        entries = document["channels"]
        if not isinstance(entries, list) or not entries:
            raise CoefficientsError(_INCOMPLETE.format(path.name))
        found = [_from_fit(entry, path) for entry in entries]
    else:
        found = [_from_mapping(document, path)]
    names = [entry.channel for entry in found]
    missing = sorted(set(channels or []) - set(names))
    if missing:
        raise CoefficientsError(
            f"{path.name} has no channel {missing[0]!r}; it has {', '.join(names)}."
        )
    return [entry for entry in found if not channels or entry.channel in channels]


def _parse(path: Path) -> Mapping[str, Any]:
    try:
        require_file(path)
        text = path.read_text(encoding="utf-8-sig")
    except RecordingError as error:
        raise CoefficientsError(str(error)) from error
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not text"
        raise CoefficientsError(f"Cannot read coefficients from {path.name}: {reason}.") from error
    try:
        document = _document(text)
    except _NameTwiceError as error:
        raise CoefficientsError(
            f"{path.name} names {str(error)!r:.60} twice: leave one of them out."
        ) from error
    # Whatever a number of 5000 digits or a thousand lists in each other make the parsers raise.
    except (ValueError, RecursionError) as error:
        raise CoefficientsError(
            f"{path.name} is neither JSON nor YAML without anchors; give a fit's JSON or lines "
            "such as `N: 0.005`."
        ) from error
    if not isinstance(document, Mapping):
        raise CoefficientsError(
            f"{path.name} holds no coefficients; give a fit's JSON or lines such as `N: 0.005`."
        )
    return {str(name): value for name, value in document.items()}


class _NameTwiceError(Exception):
    """A mapping has a name twice, of which parsers would take the last without a word."""


def _document(text: str) -> Any:
    """What JSON says or else YAML, each name once and no part of it used twice.

    **Raises:** `_NameTwiceError`, and `ValueError` or `RecursionError` if it is neither.
    """
    try:
        return json.loads(text, object_pairs_hook=_once)
    except json.JSONDecodeError:
        pass
    import yaml  # an extra, needed here alone

    class Loader(yaml.SafeLoader):
        def compose_node(self, parent: Any, index: Any) -> Any:
            # Anchors let a few lines stand for more values than any memory holds.
            if self.check_event(yaml.AliasEvent):
                raise ValueError("a part is used twice")
            return super().compose_node(parent, index)

        def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
            names = [(self.construct_object(key, deep=True), None) for key, _ in node.value]
            _once([(str(name), value) for name, value in names])
            return super().construct_mapping(node, deep)

    try:
        return yaml.load(text, Loader)
    except yaml.YAMLError as error:
        raise ValueError(str(error)) from error


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    known: dict[str, Any] = {}
    for name, value in pairs:
        if name in known:
            raise _NameTwiceError(name)
        known[name] = value
    return known


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
        values = {
            symbol: float(terms[symbol]["value"])
            for symbol in SYMBOLS
            # Half of all ramps that cannot be seen point the other way.
            if symbol != "R" or terms[symbol]["resolved"]
        }
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
        )
    except CoefficientsError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise CoefficientsError(_INCOMPLETE.format(path.name)) from error


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
    if name not in ("point", "averaged"):
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
