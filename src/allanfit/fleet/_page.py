"""The summary of a fleet as one HTML page."""

import os
from importlib.metadata import version
from typing import Any

from ..report._errors import report_extra
from ..report._figures import as_svg
from ..report._files import write_whole
from ..report._template import drawn, render
from ._compare import FALSE_ALARM, FEWEST, Comparison, Quantity
from ._run import FleetRun
from ._words import (
    copies_sentence,
    counts_sentence,
    finding_sentence,
    fits_sentence,
    grouped,
    middle_reading,
    outlier_sentence,
    spread_sentence,
)


def write_summary(run: FleetRun, comparison: Comparison, target: str | os.PathLike[str]) -> None:
    """Write the summary as one HTML page.

    The page needs no other file, no network and no script, and is there whole or not at all.

    **Raises** `ReportError` when jinja2 or matplotlib is not installed, and when the file cannot
    be written.
    """
    quantities = comparison.quantities
    devices = {device for each in quantities for device in each.devices}
    page = render(
        "summary.html.jinja",
        package="allanfit.fleet",
        counts=counts_sentence(run, len(devices)),
        copies=copies_sentence(comparison.copies),
        quantities=[_quantity(each, number) for number, each in enumerate(quantities, start=1)],
        enough=any(len(each.devices) >= FEWEST for each in quantities),
        fewest=FEWEST,
        chance=f"{100 * FALSE_ALARM:.0f} %",
        outliers=[
            {
                "sentences": [outlier_sentence(each) for each in group],
                "path": group[0].path,
                "findings": [
                    finding_sentence(finding, shared, group[0].others)
                    for finding, shared in group[0].findings
                ],
            }
            for group in grouped(comparison.outliers)
        ],
        errors=[(str(path), error) for path, error in (*run.errors, *run.kept)],
        version=version("allanfit"),
    )
    write_whole(page, target)


def _quantity(quantity: Quantity, number: int) -> dict[str, Any]:
    with report_extra():
        from ._figure import draw_quantity
    return {
        "name": quantity.name,
        "unit": quantity.unit,
        "devices": len(quantity.devices),
        "fits": fits_sentence(quantity),
        "good": not quantity.misfits,
        "rows": [
            {
                "symbol": each.symbol,
                "seen": each.spread is not None,
                "middle": middle_reading(each),
                "sentence": _capital(spread_sentence(each)),
            }
            for each in quantity.coefficients
        ],
        "figure": drawn(as_svg(draw_quantity(quantity), f"quantity-{number}-")),
    }


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:] + "."
