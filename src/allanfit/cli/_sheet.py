"""What a command says of a data sheet that it reads."""

from pathlib import Path

import typer

from ..datasheet import left_out_of
from ..report._format import printable


def tell_left_out(path: Path | None) -> None:
    """Say on stderr which lines of a data sheet are left out; any other file is none's concern."""
    for sentence in () if path is None else left_out_of(path):
        typer.echo(f"allanfit: {printable(sentence)}", err=True)
