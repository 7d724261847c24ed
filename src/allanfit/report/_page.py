"""The page: everything about one fit in a single HTML file."""

import os
from collections.abc import Mapping
from typing import Any

from ._datasheet_rows import sheet_notes, sheet_rows, sheet_title
from ._errors import report_extra
from ._explain_words import capitalised
from ._figures import svg
from ._files import write_whole
from ._plotly import scripts
from ._rows import (
    advice_sentence,
    coefficient_rows,
    description,
    fit_sentence,
    has_shares,
    sampler_sentence,
    shares_caption,
    temperature_caption,
    temperature_sentence,
    warning_sentence,
)
from ._template import drawn, live_figures, render


def write_page(
    document: Mapping[str, Any], target: str | os.PathLike[str], *, interactive: bool = True
) -> None:
    """Write the report of a fit as one HTML page, to a path or to standard output for "-".

    The page needs no other file and no network, and two pages of one document are equal byte for
    byte. The file is there whole or not at all.

    **Arguments**: `document` is a fit document, schema `allanfit.fit/1`. An `interactive` page
    carries a script, 2 MB of it, with which figures tell the values under the pointer, hide and
    show lines, and zoom; in print, and where scripts do not run, the drawn figures stand.

    **Raises** `ReportError` when jinja2, matplotlib or plotly is not installed, and when the file
    cannot be written.

    ```python
    write_page(json.loads(Path("fit.json").read_text()), "fit.html")
    ```
    """
    write_whole(_page(document, interactive), target)


def _page(document: Mapping[str, Any], interactive: bool) -> str:
    with report_extra():
        from ._interactive import curve_figure
    channels = [
        {
            "name": channel["channel"],
            "unit": channel["unit"],
            "description": description(channel),
            "rows": coefficient_rows(channel),
            "consistent": channel["goodness_of_fit"]["consistent"],
            "fit": fit_sentence(channel),
            "sampler": sampler_sentence(channel),
            "advice": advice_sentence(channel),
            "warning": warning_sentence(channel),
            "findings": channel["findings"],
            "sheet": _sheet(channel),
            "allan": drawn(svg(channel, "allan", f"allan-{number}-")),
            "psd": drawn(svg(channel, "psd", f"psd-{number}-")),
            "live": live_figures(channel, curve_figure, interactive),
            "two_models": False,
            "shares": drawn(svg(channel, "shares", f"shares-{number}-"))
            if has_shares(channel)
            else "",
            "shares_caption": shares_caption(channel),
            "temperature": temperature_sentence(channel),
            "heat": drawn(svg(channel, "temperature", f"temperature-{number}-"))
            if channel.get("temperature")
            else "",
            "heat_caption": temperature_caption(channel),
        }
        for number, channel in enumerate(document["channels"], start=1)
    ]
    return render(
        "page.html.jinja",
        recording=document["recording"],
        findings=document["findings"],
        version=document["allanfit_version"],
        checksum=document["checksum"],
        channels=channels,
        scripts=scripts() if interactive else None,
    )


def _sheet(channel: Mapping[str, Any]) -> dict[str, Any] | None:
    """The verdicts on a data sheet, none without one."""
    rows = sheet_rows(channel)
    if not rows:
        return None
    return {
        "title": sheet_title(channel),
        "rows": rows,
        "notes": [capitalised(note) for note in sheet_notes(channel)],
    }
