"""What a command says of a file of coefficients: what of it is not used."""

from pathlib import Path

import typer

from ..coefficients import Coefficients
from ..datasheet import left_out_of
from ..formatting import printable
from ..physics import AbstractEffect, Bump, Disturbance, Temperature


def tell_left_out(path: Path | None) -> None:
    """Say on stderr which lines of a data sheet are left out; any other file is none's concern."""
    for sentence in () if path is None else left_out_of(path):
        typer.echo(f"allanfit: {printable(sentence)}", err=True)


def tell_undrawn(entry: Coefficients) -> None:
    """Say on stderr what the simulation does not have, or not as the recording had it."""
    for effect in entry.effects:
        said = _undrawn(effect)
        if said:
            typer.echo(f"allanfit: {printable(entry.channel)}: {said}.", err=True)


def _undrawn(effect: AbstractEffect) -> str:
    """What of an effect is not drawn."""
    if isinstance(effect, Bump) and not effect.high_pass and float(effect.height) == 0:
        place = f"what is about {float(effect.frequency):.4g} Hz"
        return f"{place} has no name, and is not in the simulation"
    if isinstance(effect, Disturbance):
        return "knocks and movements are not in the simulation"
    if isinstance(effect, Temperature) and effect.sensitivity is not None:
        return (
            "the simulation follows a room of its own, whose temperature varies by 1 K rms, not "
            "that of the recording"
        )
    return ""
