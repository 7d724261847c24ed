"""What a command says of a file of coefficients: what of it is not used."""

from pathlib import Path

import typer

from ..coefficients import Coefficients
from ..datasheet import left_out_of
from ..physics import Bump
from ..report._format import printable


def tell_left_out(path: Path | None) -> None:
    """Say on stderr which lines of a data sheet are left out; any other file is none's concern."""
    for sentence in () if path is None else left_out_of(path):
        typer.echo(f"allanfit: {printable(sentence)}", err=True)


def tell_undrawn(entry: Coefficients) -> None:
    """Say on stderr what `explain` could place but not describe: no simulation has it."""
    for effect in entry.effects:
        if isinstance(effect, Bump) and not effect.high_pass and float(effect.height) == 0:
            typer.echo(
                f"allanfit: {printable(entry.channel)}: what is about {float(effect.frequency):.4g}"
                " Hz has no name, and is not in the simulation.",
                err=True,
            )
