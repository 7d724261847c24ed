"""The facts of one explanation as rows, which the terminal and the page both print."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ..coefficient_units import field_units
from ..formatting import Reading, duration, percent, printable, reading, significant
from ..physics import EFFECTS, Bump
from ._explain_verdict import probability
from ._explain_words import capitalised, idle_parameters, phrase, words
from ._rows import Row, coefficient_rows

_LISTED = 6  # times or intervals that are told one by one
_NO_LARGER_STEP = 2.0  # a change beyond it is told as a factor
# A ratio nearer to one is none: there is more in one part, and less in another.
_EVEN = 0.005
_NONE = Reading("none", "", "")
_DOMAINS = {"frequency": "spectrum", "tau": "Allan deviation", "time": "time"}


class Mismatch(NamedTuple):
    """One place where the recording and the model differ, numbered as in the figures."""

    number: int
    domain: str
    where: str
    size: str
    p_value: str
    sentence: str
    cause: str  # "" where no simulation was compared with


class Quantity(NamedTuple):
    """One parameter of an effect, in the recording's unit and in those of data sheets."""

    name: str
    readings: tuple[Reading, ...]


class Alternative(NamedTuple):
    """Another effect that may be the cause."""

    name: str
    probability: str
    told_apart_by: str


class Effect(NamedTuple):
    """One effect that the five terms leave out."""

    name: str
    probability: str
    sentence: str
    quantities: tuple[Quantity, ...]
    alternatives: tuple[Alternative, ...]


class Change(NamedTuple):
    """One coefficient with the five terms alone, and with the effects beside them."""

    before: Row
    after: Row
    apart: bool
    size: str  # "+12 %", "x 0.21", "no longer resolved", ...

    @property
    def remark(self) -> str:
        """The size of the change, and whether the intervals leave room for none."""
        if not self.apart:
            return self.size
        return f"{self.size}, intervals do not overlap".removeprefix(", ")


class Witness(NamedTuple):
    """One further test."""

    name: str
    statistic: str
    p_value: str
    sentence: str


def mismatch_rows(channel: Mapping[str, Any]) -> list[Mismatch]:
    """In the order of the document, the strongest first."""
    return [
        Mismatch(
            number=number,
            domain=_DOMAINS[entry["domain"]],
            where=_span(entry),
            size=_size(entry),
            p_value=probability(entry["p_value"]),
            sentence=entry["sentence"],
            cause=_cause(entry),
        )
        for number, entry in enumerate(channel["mismatch"], start=1)
    ]


def _size(entry: Mapping[str, Any]) -> str:
    """How many times the model the recording is, "" where it is as large, as beside a step."""
    ratio = entry["ratio"]
    if ratio is None or abs(ratio - 1) < _EVEN:
        return ""
    shown = significant(ratio, 2 if abs(ratio - 1) > 0.1 else 3)
    return f"\N{MULTIPLICATION SIGN} {shown}"


def _span(entry: Mapping[str, Any]) -> str:
    low, high = entry["low"], entry["high"]
    if entry["domain"] == "time":
        first, last = duration(low), duration(high)
        return first if first == last else f"{first} to {last}"
    # As many digits as it takes to tell the two ends apart.
    gap = abs(high - low)
    digits = 3 if gap <= 0 else min(max(3, math.ceil(math.log10(high / gap)) + 1), 9)
    shown = [f"{significant(end, digits)} {entry['unit']}" for end in (low, high)]
    return shown[0] if shown[0] == shown[1] else " to ".join(shown)


def _cause(entry: Mapping[str, Any]) -> str:
    cause = entry.get("cause")
    if cause == "coefficient":
        which = entry.get("coefficient")
        return f"{words(which)} of the simulation is off" if which else "a coefficient is off"
    if cause == "physics":
        return f"physics absent from the {entry.get('absent_from') or 'simulation'}"
    return cause or ""


def _with_origin(effect: Mapping[str, Any]) -> str:
    """What is said of it, and where it comes from as a rule."""
    known = EFFECTS.get(effect["name"], Bump)
    return effect["sentence"] + ("" if known is Bump else f" Usual cause: {known.origin}.")


def _heading(effect: Mapping[str, Any]) -> str:
    if effect["name"] == "bump" and set(idle_parameters(effect)) == set(effect["parameters"]):
        return "Something that has no name"
    return capitalised(phrase(effect))


def effect_rows(channel: Mapping[str, Any]) -> list[Effect]:
    """In the order of the document."""
    return [
        Effect(
            name=_heading(effect),
            probability=percent(effect["probability"]),
            sentence=_with_origin(effect),
            quantities=tuple(
                Quantity(name.replace("_", " "), _readings(entry, channel))
                for name, entry in effect["parameters"].items()
                if entry and name not in idle_parameters(effect)
            ),
            alternatives=tuple(
                Alternative(
                    words(other["name"]),
                    percent(other["probability"]),
                    other.get("told_apart_by") or "",
                )
                for other in effect["alternatives"]
            ),
        )
        for effect in channel["effects"]
    ]


def _readings(entry: Mapping[str, Any], channel: Mapping[str, Any]) -> tuple[Reading, ...]:
    value, unit = entry["value"], (entry["unit"] or "").removeprefix("-")
    if isinstance(value, Sequence):
        return (Reading(_enumerated(value), "", unit if value else ""),)
    interval = (entry.get("intervals") or {}).get("0.95")
    own = reading(value, interval, unit)
    if value is None or not unit or unit != channel["unit"]:
        return (own,)
    # What has the channel's unit is told as the bias instability is: in deg/h, or in micro-g.
    return own, *(
        reading(
            value * each.factor,
            interval and [None if end is None else end * each.factor for end in interval],
            each.unit,
        )
        for each in field_units(channel["kind"], unit, "B")
    )


def _enumerated(values: Sequence[Any]) -> str:
    """Times, or pairs of them; of many, the first."""
    shown = [
        " to ".join(significant(end, 6) for end in each)
        if isinstance(each, Sequence)
        else significant(each, 6)
        for each in values[:_LISTED]
    ]
    more = len(values) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "") or "none"


def change_rows(channel: Mapping[str, Any]) -> list[Change]:
    """One row a term, [] where there is no better model."""
    before, after = channel["coefficients_before"], channel["coefficients_after"]
    if channel["verdict"] == "consistent" or not after:
        return []
    rows = zip(_rows(channel, before), _rows(channel, after), strict=True)
    return [
        Change(
            old,
            new,
            _apart(before[old.symbol], after[old.symbol]),
            _change(old, new, before[old.symbol]["value"], after[old.symbol]["value"]),
        )
        for old, new in rows
    ]


def simulation_rows(channel: Mapping[str, Any]) -> dict[str, Row]:
    """The simulation's coefficients by their symbols, {} where there is none."""
    simulation = channel.get("simulation")
    if not simulation:
        return {}
    entries = simulation["coefficients"]
    return {
        row.symbol: row if _has(entries[row.symbol]) else row._replace(reading=_NONE, field=())
        for row in _rows(channel, entries)
    }


def _has(entry: Mapping[str, Any]) -> bool:
    """Whether a simulation has a term, or may have: one that nobody measured is zero exactly."""
    return bool(entry["value"]) or entry["upper_limit_95"] is not None


def unchanged_rows(channel: Mapping[str, Any]) -> list[Row]:
    """The coefficients where there is no better model, [] where there is one."""
    if change_rows(channel):
        return []
    return _rows(channel, channel["coefficients_before"])


def _rows(channel: Mapping[str, Any], coefficients: Mapping[str, Any]) -> list[Row]:
    return coefficient_rows(
        {
            "coefficients": coefficients,
            "kind": channel["kind"],
            "unit": channel["unit"],
            "curves": {"allan": {"tau_s": []}},
        }
    )


def _apart(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    first, second = (each["intervals"].get("0.95") or () for each in (before, after))
    if not first or not second or None in (*first, *second):
        return False
    return first[1] < second[0] or second[1] < first[0]


def _change(old: Row, new: Row, before: float, after: float) -> str:
    if old.resolved and not new.resolved:
        return "no longer resolved"
    if new.resolved and not old.resolved:
        return "now resolved"
    if not (old.resolved and new.resolved):
        return ""
    factor = after / before
    if 1 / _NO_LARGER_STEP <= factor <= _NO_LARGER_STEP:
        per_cent = 100 * (factor - 1)
        if abs(per_cent) < 0.05:
            return "the same"
        return f"{per_cent:+.1f} %" if abs(per_cent) < 10 else f"{per_cent:+.0f} %"
    return f"\N{MULTIPLICATION SIGN} {significant(factor, 2)}"


def witness_rows(channel: Mapping[str, Any]) -> list[Witness]:
    """Further tests, in the order of the document."""
    return [
        Witness(
            entry["name"].replace("_", " "),
            significant(entry["statistic"], 3),
            probability(entry["p_value"]),
            entry["sentence"],
        )
        for entry in channel.get("witnesses") or ()
    ]


def heading(channel: Mapping[str, Any]) -> str:
    """Name and unit of a channel, fit for a terminal."""
    unit = printable(channel["unit"])
    return printable(channel["channel"]) + (f" [{unit}]" if unit else "")
