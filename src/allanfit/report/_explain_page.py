"""The page of an explanation: what the five terms leave out, and the evidence."""

import os
from collections.abc import Mapping
from typing import Any

from ._errors import report_extra
from ._explain_rows import (
    change_rows,
    effect_rows,
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
from ._figures import as_svg
from ._files import write_whole
from ._plotly import scripts
from ._rows import description
from ._template import drawn, live_figures, render

_LINES = 12  # that are drawn; beyond, a page shows no more than the spectrum does


def write_explanation(
    document: Mapping[str, Any], target: str | os.PathLike[str], *, interactive: bool = True
) -> None:
    """Write an explanation as one HTML page, to a path or to standard output for "-".

    The page needs no other file and no network, and two pages of one document are equal byte for
    byte. The file is there whole or not at all.

    **Arguments**: `document` is an explanation, schema `allanfit.explain/1`. An `interactive` page
    carries a script, 2 MB of it, with which figures tell the values under the pointer, switch
    between the models, and zoom; in print, and where scripts do not run, the drawn figures stand.

    **Raises** `ReportError` when jinja2, matplotlib or plotly is not installed, and when the file
    cannot be written.

    ```python
    write_explanation(json.loads(Path("explain.json").read_text()), "explain.html")
    ```
    """
    channels = [
        _channel(channel, number, interactive)
        for number, channel in enumerate(document["channels"], start=1)
    ]
    page = render(
        "explain.html.jinja",
        recording=document["recording"],
        findings=document["findings"],
        version=document["allanfit_version"],
        checksum=document["checksum"],
        channels=channels,
        scripts=scripts() if interactive else None,
    )
    write_whole(page, target)


def _channel(channel: Mapping[str, Any], number: int, interactive: bool) -> dict[str, Any]:
    mismatch, simulation = mismatch_rows(channel), simulation_sentence(channel)
    return {
        "name": channel["channel"],
        "unit": channel["unit"],
        "verdict": channel["verdict"],
        "sentence": verdict_sentence(channel),
        "chance": chance_sentence(channel),
        "simulation": simulation,
        "description": description(channel),
        "findings": channel["findings"],
        "mismatch": mismatch,
        "effects": effect_rows(channel),
        "evidence": evidence_rows(channel),
        "changes": change_rows(channel),
        "unchanged": unchanged_rows(channel),
        "simulated": simulation_rows(channel),
        "witnesses": witness_rows(channel),
        "advice": channel["advice"],
        "two_models": channel["verdict"] != "consistent",
        **_figures(channel, number, interactive),
    }


def _figures(channel: Mapping[str, Any], number: int, interactive: bool) -> dict[str, Any]:
    """The figures as SVG and the curves as scripts, "" for one that there is no reason to draw."""
    with report_extra():
        from ._explain_interactive import explained_figure
        from ._explain_line_panel import draw_line
        from ._explain_panels import draw_curve
        from ._explain_time_panel import draw_time, has_time
    lines = (channel["curves"] or {}).get("lines") or []
    return {
        "allan": drawn(as_svg(draw_curve(channel, "allan"), f"allan-{number}-")),
        "live": live_figures(channel, explained_figure, interactive),
        "psd": drawn(as_svg(draw_curve(channel, "psd"), f"psd-{number}-")),
        "time": drawn(as_svg(draw_time(channel), f"time-{number}-")) if has_time(channel) else "",
        "lines": [
            drawn(
                as_svg(
                    draw_line(line, channel["unit"], channel["effects"]), f"line-{number}-{index}-"
                )
            )
            for index, line in enumerate(lines[:_LINES], start=1)
        ],
        "more_lines": max(0, len(lines) - _LINES),
    }
