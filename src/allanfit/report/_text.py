"""The fit as plain text for a terminal, 80 columns wide."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from ..formatting import Reading, printable
from ._datasheet_rows import SheetRow, sheet_notes, sheet_rows, sheet_title
from ._rows import (
    Row,
    advice_sentence,
    coefficient_rows,
    description,
    fit_sentence,
    sampler_sentence,
    slope_sentence,
    temperature_sentence,
    warning_sentence,
)

_WIDTH = 80
_LEGEND = (
    "[low, high] is the 95 % interval, < the 95 % upper limit of a term that is not resolved; "
    "the times after `resolved` are the averaging times at which the term is the largest."
)


def format_text(document: Mapping[str, Any]) -> str:
    """The fit of every channel as plain text, with a final newline.

    Each term has its value with the 95 % interval in the user's unit, then in the units of the
    field; a term that is not resolved has its upper limit instead.

    **Arguments**: `document` is a fit document, schema `allanfit.fit/1`.

    ```python
    print(format_text(json.loads(Path("fit.json").read_text())), end="")
    ```
    """
    lines = [printable(document["recording"])]
    lines += _bullets(document["findings"])
    for channel in document["channels"]:
        lines += ["", *_channel_lines(channel)]
    lines += ["", *textwrap.wrap(_LEGEND, _WIDTH)]
    lines.append(f"allanfit {document['allanfit_version']}, checksum {document['checksum']}")
    return "\n".join(lines) + "\n"


def _channel_lines(channel: Mapping[str, Any]) -> list[str]:
    unit = printable(channel["unit"])
    heading = printable(channel["channel"]) + (f" [{unit}]" if unit else "")
    facts = {
        "fit": fit_sentence(channel),
        "sampler": sampler_sentence(channel),
        "slopes": slope_sentence(channel),
        # Told among the findings where it matters.
        "heat": "" if _told(channel) else temperature_sentence(channel),
        "longer": advice_sentence(channel),
        "warning": warning_sentence(channel),
    }
    return [
        heading,
        *textwrap.wrap(description(channel), _WIDTH, initial_indent="  ", subsequent_indent="  "),
        *_table(coefficient_rows(channel)),
        *(line for label, fact in facts.items() if fact for line in _labelled(label, fact)),
        *_sheet(channel),
        *_bullets(channel["findings"]),
    ]


def _sheet(channel: Mapping[str, Any]) -> list[str]:
    """The verdicts on a data sheet, none without one."""
    rows = sheet_rows(channel)
    if not rows:
        return []
    width = max(len(row.verdict) for row in rows)
    return [
        *_labelled("sheet", sheet_title(channel)),
        *(line for row in rows for line in _sheet_lines(row, width)),
        *(line for note in sheet_notes(channel) for line in _labelled("", note)),
    ]


def _sheet_lines(row: SheetRow, width: int) -> list[str]:
    fact = f"{row.words} {row.stated}; measured {row.measured}; met with probability {row.chance}"
    indent = " " * 11
    return textwrap.wrap(
        fact,
        _WIDTH,
        initial_indent=f"{indent}{row.verdict:<{width}}  ",
        subsequent_indent=indent + " " * (width + 2),
    )


def _told(channel: Mapping[str, Any]) -> bool:
    said = (channel.get("temperature") or {}).get("sentences", ())
    return any(sentence in channel["findings"] for sentence in said)


def _table(rows: Sequence[Row]) -> list[str]:
    """Two columns: term and state on the left, the readings one below the other on the right."""
    left_width = max((len(text) for row in rows for text in (row.name, row.state)), default=0)
    readings = [each for row in rows for each in (row.reading, *row.field)]
    # Limits have no interval to line up with, so that they may run into its column.
    measured = [each for each in readings if each.interval]
    value_width = max((len(each.value) for each in measured), default=0)
    interval_width = max((len(each.interval) for each in measured), default=0)

    def aligned(each: Reading) -> str:
        if not each.interval:
            return f"{each.value} {printable(each.unit)}"
        value, interval = each.value.ljust(value_width), each.interval.ljust(interval_width)
        return f"{value} {interval} {printable(each.unit)}"

    lines = []
    for row in rows:
        left = [f"  {row.symbol}  {row.name}", f"     {row.state}"]
        right = [aligned(each) for each in (row.reading, *row.field)]
        for index in range(max(len(left), len(right))):
            term = left[index] if index < len(left) else ""
            number = right[index] if index < len(right) else ""
            lines.append(f"{term:<{left_width + 7}}{number}".rstrip())
    return lines


def _labelled(label: str, fact: str) -> list[str]:
    return textwrap.wrap(
        printable(fact), _WIDTH, initial_indent=f"  {label:<9}", subsequent_indent=" " * 11
    )


def _bullets(findings: Sequence[str]) -> list[str]:
    return [
        line
        for finding in findings
        for line in textwrap.wrap(
            printable(finding), _WIDTH, initial_indent="  - ", subsequent_indent="    "
        )
    ]
