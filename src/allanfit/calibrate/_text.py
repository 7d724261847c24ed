"""A calibration as plain text for a terminal, 80 columns wide."""

import textwrap
from collections.abc import Sequence
from importlib.metadata import version

from ..formatting import aligned, printable, significant
from ..report._notebook import html_table, shown
from ._result import AxisCalibration, Calibration
from ._rows import Row, axis_rows, misalignment_rows

_WIDTH = 80
_LEGEND = (
    "[low, high] is the 95 % interval; significant means that it excludes zero. measured = a + S "
    "a + B with the bias B and the scale factor S."
)


def calibration_text(found: Calibration) -> str:
    """Each axis with its values, intervals and whether they differ from zero; no final newline."""
    lines = textwrap.wrap(f"{printable(found.source)}: {found.procedure} test", _WIDTH)
    lines += textwrap.wrap(found.description, _WIDTH, initial_indent="  ", subsequent_indent="  ")
    for finding in found.findings:
        lines += textwrap.wrap(
            printable(finding), _WIDTH, initial_indent="  - ", subsequent_indent="    "
        )
    for name, axis in found.axes.items():
        lines += ["", printable(name), *_table(axis_rows(axis, found.procedure))]
        lines += _per_rate(axis)
    if found.misalignment:
        lines += ["", "misalignment", *_table(misalignment_rows(found)), ""]
        lines += textwrap.wrap(
            found.misalignment_convention, _WIDTH, initial_indent="  ", subsequent_indent="  "
        )
    lines += ["", *textwrap.wrap(f"{_LEGEND} {found.intervals}", _WIDTH)]
    return "\n".join([*lines, f"allanfit {version('allanfit')}"])


def calibration_html(found: Calibration) -> str:
    """Each axis with its values and intervals, for a notebook."""
    rows = [
        (name, row.label, "\n".join(map(shown, row.readings)), row.state)
        for name, axis in found.axes.items()
        for row in axis_rows(axis, found.procedure)
    ]
    rows += [
        ("misalignment", row.label, "\n".join(map(shown, row.readings)), row.state)
        for row in misalignment_rows(found)
    ]
    notes = (*found.findings, found.misalignment_convention, f"{_LEGEND} {found.intervals}")
    head = ("axis", "quantity", "value", "")
    return html_table(f"{found.source}: {found.procedure} test", head, rows, notes)


def _table(rows: Sequence[Row]) -> list[str]:
    cells = [
        (row.label if k == 0 else "", *_printed(each), row.state if k == 0 else "")
        for row in rows
        for k, each in enumerate(row.readings)
    ]
    return _indented(cells)


def _printed(each: tuple[str, str, str]) -> tuple[str, str, str]:
    value, interval, unit = each
    return value, interval, printable(unit)


def _per_rate(axis: AxisCalibration) -> list[str]:
    """What each pair of readings says alone."""
    if axis.per_rate is None:
        return []
    unit = axis.bias.unit
    suffix = f" [{printable(unit)}]" if unit else ""
    rows = [(f"rate{suffix}", f"bias{suffix}", "scale factor [%]")]
    for row in axis.per_rate:
        scale = 100 * row["scale_factor"]
        rows.append((significant(row["rate"]), significant(row["bias"]), significant(scale)))
    return ["  each rate alone:", *_indented(rows)]


def _indented(rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"  {line}" for line in aligned(rows)]
