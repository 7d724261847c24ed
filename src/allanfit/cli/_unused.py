"""What a command says of a file of coefficients: what of it is not used."""

from collections.abc import Sequence
from pathlib import Path

import typer

from ..coefficients import Coefficients
from ..datasheet import left_out_of
from ..formatting import printable, upper_limit
from ..physics import (
    STANDARD_TERMS,
    AbstractEffect,
    Bump,
    Disturbance,
    Temperature,
    coefficient_unit,
)

_TERMS = {term.symbol: term for term in STANDARD_TERMS}


def tell_left_out(path: Path | None) -> None:
    """Say on stderr which lines of a data sheet are left out; any other file is none's concern."""
    for sentence in () if path is None else left_out_of(path):
        typer.echo(f"allanfit: {printable(sentence)}", err=True)


def tell_unresolved(entries: Sequence[Coefficients]) -> None:
    """Say on stderr, in one line, which terms of a fit a simulation is without."""
    told = []
    for entry in entries:
        limits = (
            f"{symbol} {upper_limit(term.upper_limit_95, _unit(symbol, entry))}"
            for symbol, term in entry.unresolved.items()
        )
        if said := ", ".join(limits):
            told.append(f"{printable(entry.channel)} {said}")
    if told:
        typer.echo(
            "allanfit: Not resolved, and so not in the simulation (95 % upper limits): "
            f"{'; '.join(told)}.",
            err=True,
        )


def _unit(symbol: str, entry: Coefficients) -> str:
    return coefficient_unit(_TERMS[symbol], entry.unit)


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
