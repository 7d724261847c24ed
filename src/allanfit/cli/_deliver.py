"""What a fit and an explanation end with: JSON, text, page and figures."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import typer

from ..report import write_figures, write_json


def deliver(
    document: Mapping[str, Any],
    as_text: Callable[[Mapping[str, Any]], str],
    write_report: Callable[..., None],
    *,
    json: str | None,
    report: Path | None,
    interactive: bool,
    figure: Path | None,
) -> None:
    """The JSON first: should a figure fail, nothing that was computed is lost."""
    if json is not None:
        write_json(document, json)
    if json != "-":
        typer.echo(as_text(document), nl=False)
    if report is not None:
        write_report(document, report, interactive=interactive)
        typer.echo(f"\nPage with figures: {report}", err=True)
    if figure is not None:
        for path in write_figures(document, figure):
            typer.echo(f"Figure: {path}", err=True)
