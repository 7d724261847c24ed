"""A calibration as one HTML page, with its residuals."""

import os
from importlib.metadata import version
from typing import Any

from ..formatting import significant
from ..report._errors import report_extra
from ..report._figures import as_svg
from ..report._files import write_whole
from ..report._template import drawn, render
from ..report._units import typeset
from ._result import AxisCalibration, Calibration
from ._rows import axis_rows, misalignment_rows

_RESIDUAL_HELP = {
    "up-down": (
        "Points are means of short blocks of each recording, less its mean: a slope or a wave is "
        "drift of the bias."
    ),
    "rate-table": (
        "Residuals are readings less the straight line; a bend or a step at zero is a response "
        "that is no straight line."
    ),
    "multi-position": (
        "Residuals are corrected readings less gravity, in their length, or along each axis where "
        "the attitudes are known."
    ),
}


def write_calibration_page(found: Calibration, target: str | os.PathLike[str]) -> None:
    """Write one HTML page, to a path or to standard output for "-".

    The page needs no other file, no network and no script, and is there whole or not at all.

    **Raises** `ReportError` when jinja2 or matplotlib is not installed, and when the file cannot
    be written.
    """
    write_whole(_page(found), target)


def _page(found: Calibration) -> str:
    with report_extra():
        from ._figure import residual_figure
    axes = [
        {
            "name": name,
            "rows": axis_rows(axis, found.procedure),
            "per_rate": _per_rate(axis),
            "unit_in_brackets": f" [{typeset(axis.bias.unit)}]" if axis.bias.unit else "",
            "figure": axis.residuals
            and drawn(as_svg(residual_figure(axis.residuals), f"axis-{number}-")),
        }
        for number, (name, axis) in enumerate(found.axes.items(), start=1)
    ]
    return render(
        "page.html.jinja",
        package="allanfit.calibrate",
        found=found,
        axes=axes,
        misalignment=misalignment_rows(found),
        figure=found.residuals and drawn(as_svg(residual_figure(found.residuals), "triad-")),
        residual_help=_RESIDUAL_HELP[found.procedure],
        version=version("allanfit"),
    )


def _per_rate(axis: AxisCalibration) -> list[tuple[Any, ...]]:
    return [
        (
            significant(row["rate"]),
            significant(row["bias"]),
            significant(100 * row["scale_factor"]),
        )
        for row in axis.per_rate or ()
    ]
