"""The lines of a data sheet beside the measurement, which the terminal and the page both print."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..formatting import percent, printable, reading, significant, upper_limit

# How the words were read, where the number is not the coefficient itself.
_MEANINGS = {
    "one_sided_density": "the root of a one-sided density, √2 N",
    "allan_minimum": "the lowest Allan deviation, which is 0.664 B or more",
}
_MISFIT = (
    "The five terms do not explain this recording, and verdicts on coefficients are only as good "
    "as the five terms."
)


class SheetRow(NamedTuple):
    """One line of a data sheet."""

    verdict: str  # "met", "missed" or "cannot be told"
    words: str  # "noise density"
    stated: str  # "0.05 °/s/√Hz typical"
    measured: str  # "0.0512 [0.0508, 0.0516]", "< 0.02" or "unknown"
    chance: str  # of being at or below what is stated: "> 99.9 %" or "unknown"


def sheet_rows(channel: Mapping[str, Any]) -> list[SheetRow]:
    """A row for each line that concerns the channel, none without a data sheet."""
    return [_row(line) for line in (channel.get("datasheet") or {}).get("lines", ())]


def _row(line: Mapping[str, Any]) -> SheetRow:
    if line["measured"] is None:
        measured = "unknown"
    elif line["resolved"]:
        value, interval, _ = reading(line["measured"], line["interval_95"], "")
        measured = f"{value} {interval}".rstrip()
    else:
        # Documents of earlier versions have the interval alone.
        limit = line.get("upper_limit_95")
        measured = upper_limit(line["interval_95"][1] if limit is None else limit, "").value
    return SheetRow(
        line["verdict"],
        printable(line["words"]),
        f"{significant(line['stated'])} {printable(line['unit'])} {line['bound']}",
        measured,
        "unknown" if line["probability"] is None else percent(line["probability"]),
    )


def sheet_title(channel: Mapping[str, Any]) -> str:
    """What the rows are compared with."""
    sheet = channel["datasheet"]
    name = sheet["sensor"] or sheet["file"]
    return printable(f"{name} ({sheet['source']})" if sheet["source"] else name)


def sheet_notes(channel: Mapping[str, Any]) -> list[str]:
    """How words were read, what another reading would change, and what cannot be compared."""
    lines = channel["datasheet"]["lines"]
    notes = [_note(line) for line in lines if line["as"] != "coefficient"]
    modelled = any(line["from"] == "posterior" for line in lines)
    if modelled and channel["goodness_of_fit"]["consistent"] is False:
        notes.append(_MISFIT)
    # Documents of earlier versions leave nothing out.
    notes += [printable(each) for each in channel["datasheet"].get("left_out", ())]
    return list(dict.fromkeys(notes))


def _note(line: Mapping[str, Any]) -> str:
    note = f"{printable(line['words'])} is read as {_MEANINGS[line['as']]}"
    if line["from"] == "curve":
        note += ", here of the measured curve, since the five terms do not explain it"
        note += "" if line["resolved"] else "; it is lowest at the longest times known"
    other = line["verdict_as_coefficient"]
    if other is None:
        return f"{note}."
    return f"{note}; read as {line['coefficient']} itself, it is {_said(other)}."


def _said(verdict: str) -> str:
    return "not to be told" if verdict == "cannot be told" else verdict
