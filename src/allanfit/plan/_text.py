"""Plans as a table for a terminal."""

import textwrap

from ..formatting import aligned, duration, printable, significant
from ..physics import SYMBOLS
from ..report._notebook import html_table
from ._file import FilePlan
from ._plan import Plan, percent

_WIDTH = 80
_LEGEND = (
    "Percentages are relative standard errors: half-widths of 68 % intervals. A 95 % interval is "
    "twice as wide. Errors above about 20 % are rough."
)


def plan_text(found: FilePlan) -> str:
    """A row for each channel: how long for each wish, which one sets it, and what comes of it."""
    plans = found.channels
    first = next(iter(plans.values()))
    wishes = [f"{symbol} to {percent(error)}" for symbol, error in first.want.items()]
    lengths = [["channel", *wishes, "record", "set by"]]
    errors = [["channel", "after", *SYMBOLS]]
    for name, entry in plans.items():
        by_wish = [_length(length) for length in entry.durations_s.values()]
        total = _length(entry.duration_s)
        lengths.append([printable(name), *by_wish, total, entry.set_by or "-"])
        errors.append([printable(name), duration(entry.at_s), *_errors(entry)])
    heading = (
        f"{printable(found.file)} at {significant(first.rate_hz)} Hz: "
        "how long to record, at rest and without a gap"
    )
    lines = [*textwrap.wrap(heading, _WIDTH), "", *aligned(lengths)]
    lines += ["", "What that tells of each coefficient:", "", *aligned(errors), ""]
    if len(plans) > 1 and found.duration_s is not None:
        which = "these" if found.left_out else "all"
        lines += [f"Record {duration(found.duration_s)} for {which} channels.", ""]
    lines += textwrap.wrap(_LEGEND, _WIDTH)
    for name, entry in plans.items():
        for note in entry.notes:
            lines += textwrap.wrap(f"{printable(name)}: {note}", _WIDTH, subsequent_indent="  ")
    for sentence in found.left_out:
        lines += textwrap.wrap(printable(sentence), _WIDTH, subsequent_indent="  ")
    return "\n".join(lines)


def plan_html(found: Plan) -> str:
    """A row for each wish: how long it takes, and what the record will then tell."""
    known = found.relative_standard_error
    rows = [
        (symbol, percent(error), _length(found.durations_s[symbol]), percent(known[symbol]))
        for symbol, error in found.want.items()
    ]
    record = f"Record {duration(found.at_s)} at {significant(found.rate_hz)} Hz"
    head = ("", "wanted", "takes", f"after {duration(found.at_s)}")
    return html_table(f"{record}, at rest and without a gap", head, rows, [*found.notes, _LEGEND])


def _length(seconds: float | None) -> str:
    return "out of reach" if seconds is None else duration(seconds)


def _errors(entry: Plan) -> list[str]:
    known = entry.relative_standard_error
    return [percent(known[symbol]) if symbol in known else "-" for symbol in SYMBOLS]
