"""The explanation as plain text for a terminal, 80 columns wide."""

import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..formatting import Reading, printable
from ._explain_rows import (
    Change,
    Effect,
    Mismatch,
    change_rows,
    effect_rows,
    heading,
    mismatch_rows,
    simulation_rows,
    unchanged_rows,
    witness_rows,
)
from ._explain_verdict import (
    chance_sentence,
    evidence_rows,
    simulation_sentence,
    verdict_sentence,
)
from ._rows import Row, description

_WIDTH = 80
_PLACES = 6  # of mismatch that are told; the weaker ones are in the JSON
_ALIKE = 3  # effects of one name that are told at length
_LEGEND = (
    "[low, high] is the 95 % interval, < the 95 % upper limit of a term that is not resolved; "
    "\N{MULTIPLICATION SIGN} tells how many times the model the recording is."
)


def format_explanation(document: Mapping[str, Any]) -> str:
    """What the five terms leave out of every channel as plain text, with a final newline.

    The verdict comes first, then where model and recording differ, the effects with their
    parameters, the evidence that they improve the model, and what becomes of the coefficients.

    **Arguments**: `document` is an explanation, schema `allanfit.explain/1`.

    ```python
    print(format_explanation(json.loads(Path("explain.json").read_text())), end="")
    ```
    """
    lines = [printable(document["recording"]), *_bullets(document["findings"])]
    for channel in document["channels"]:
        lines += ["", *_channel_lines(channel)]
    lines += ["", *_wrapped(_LEGEND, 0)]
    lines.append(f"allanfit {document['allanfit_version']}, checksum {document['checksum']}")
    return "\n".join(lines) + "\n"


def _channel_lines(channel: Mapping[str, Any]) -> Iterator[str]:
    yield f"{heading(channel)}: {channel['verdict']}"
    yield from _wrapped(description(channel))
    for sentence in (verdict_sentence, chance_sentence, simulation_sentence):
        yield from _wrapped(sentence(channel))
    yield from _bullets(channel["findings"])
    yield from _section("Where it differs", _places(mismatch_rows(channel)))
    yield from _section("What is left out", _effects(effect_rows(channel)))
    yield from _section("Evidence for the better model", _evidence(channel))
    simulated = simulation_rows(channel)
    changes = _changes(change_rows(channel), simulated)
    yield from _section("What becomes of the coefficients", changes)
    yield from _section("Coefficients", _coefficients(unchanged_rows(channel), simulated))
    yield from _section("Further tests", _witnesses(channel))
    yield from _section("Advice", _bullets(channel["advice"], 4))


def _section(title: str, lines: Iterator[str]) -> Iterator[str]:
    """The lines under their title, nothing where there are none."""
    shown = list(lines)
    if shown:
        yield ""
        yield f"  {title}"
        yield from shown


def _places(rows: Sequence[Mismatch]) -> Iterator[str]:
    for row in rows[:_PLACES]:
        facts = (f"{row.where} ({row.domain})", row.size, row.p_value, row.cause)
        yield from _wrapped(f"{row.number}. {', '.join(filter(None, facts))}", 4, 7)
        yield from _wrapped(row.sentence, 7)
    if len(rows) > _PLACES:
        yield from _wrapped(f"and {len(rows) - _PLACES} weaker ones, which --json tells", 4)


def _effects(rows: Sequence[Effect]) -> Iterator[str]:
    told: Counter[str] = Counter()
    for row in rows:
        told[row.name] += 1
        if told[row.name] > _ALIKE:
            facts = (f"{each.name} {each.readings[0]}" for each in row.quantities)
            yield from _wrapped(f"{row.name}: {row.probability}, {', '.join(facts)}", 4, 6)
            continue
        yield from _wrapped(f"{row.name}: {row.probability}", 4)
        yield from _wrapped(row.sentence, 6)
        width = max((len(each.name) for each in row.quantities), default=0)
        for quantity in row.quantities:
            for index, each in enumerate(quantity.readings):
                name = "" if index else quantity.name
                yield from _wrapped(f"{name:<{width}}  {each}", 6, 8 + width)
        for other in row.alternatives:
            apart = f"; to tell apart: {other.told_apart_by}" if other.told_apart_by else ""
            yield from _wrapped(f"or {other.name}: {other.probability}{apart}", 6, 9)


def _evidence(channel: Mapping[str, Any]) -> Iterator[str]:
    for row in evidence_rows(channel):
        yield from _wrapped(
            f"{row.what}: {row.before} before, {row.after} after: {row.remark}", 4, 6
        )


def _changes(rows: Sequence[Change], simulated: Mapping[str, Row]) -> Iterator[str]:
    """Two lines a term, before and after, and a third for a simulation."""
    left = max((len(text) for row in rows for text in (row.before.name, row.size)), default=0)
    readings = [each for row in rows for each in (row.before.reading, row.after.reading)]
    widths = _widths([*readings, *(row.reading for row in simulated.values())])
    for row in rows:
        before, after = (_aligned(each.reading, widths) for each in (row.before, row.after))
        yield f"    {row.before.symbol}  {row.before.name:<{left}}  before  {before}".rstrip()
        yield f"       {row.size:<{left}}  after   {after}".rstrip()
        if row.apart:
            yield f"       {'':<{left}}          the intervals do not overlap"
        if simulated:
            drawn = _aligned(simulated[row.before.symbol].reading, widths)
            yield f"       {'':<{left}}  simul.  {drawn}".rstrip()


def _coefficients(rows: Sequence[Row], simulated: Mapping[str, Row]) -> Iterator[str]:
    """One line a term, and a second for a simulation."""
    left = max((len(text) for row in rows for text in (row.name, "simulation")), default=0)
    widths = _widths([row.reading for row in (*rows, *simulated.values())])
    for row in rows:
        yield f"    {row.symbol}  {row.name:<{left}}  {_aligned(row.reading, widths)}".rstrip()
        if simulated:
            drawn = _aligned(simulated[row.symbol].reading, widths)
            yield f"       {'simulation':<{left}}  {drawn}".rstrip()


def _widths(readings: Sequence[Reading]) -> tuple[int, int]:
    # Limits have no interval to line up with, so that they may run into its column.
    measured = [each for each in readings if each.interval]
    return (
        max((len(each.value) for each in measured), default=0),
        max((len(each.interval) for each in measured), default=0),
    )


def _aligned(each: Reading, widths: tuple[int, int]) -> str:
    unit = printable(each.unit)
    if not each.interval:
        return f"{each.value} {unit}"
    return f"{each.value:<{widths[0]}} {each.interval:<{widths[1]}} {unit}"


def _witnesses(channel: Mapping[str, Any]) -> Iterator[str]:
    for row in witness_rows(channel):
        yield from _wrapped(f"{row.name}: {row.p_value}. {row.sentence}", 4, 6)


def _wrapped(text: str, indent: int = 2, hanging: int | None = None) -> Iterator[str]:
    yield from textwrap.wrap(
        printable(text),
        _WIDTH,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent if hanging is None else hanging),
    )


def _bullets(sentences: Sequence[str], indent: int = 2) -> Iterator[str]:
    for sentence in sentences:
        yield from _wrapped(f"- {sentence}", indent, indent + 2)
