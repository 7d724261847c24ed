"""The command `allanfit explain`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from ..recording import load
from ..report import format_explanation, write_explanation, write_json
from ._options import Channels, Json, Page, Rate, Sampling, Seed, Unit, check_targets
from ._progress import channel_by_channel


def explain(
    recording: Annotated[Path, typer.Argument(help="CSV, NPY or NPZ file of a still sensor.")],
    simulation: Annotated[
        Path | None,
        typer.Option(
            help="What to compare with: a recording made by your simulator, or its coefficients "
            "(a fit's JSON, or YAML)."
        ),
    ] = None,
    rate: Rate = None,
    channel: Channels = None,
    unit: Unit = None,
    json: Json = None,
    report: Page = None,
    posterior: Annotated[
        bool, typer.Option(help="Sample with emcee and report whether it has settled.")
    ] = True,
    sampling: Sampling = "point",
    seed: Seed = 0,
) -> None:
    """Find what Q, N, B, K and R leave out of each channel, name it and model it.

    Example: allanfit explain gyro.csv --rate 100 --unit deg/s --report explain.html
    """
    # The stage loads much that the other commands do without.
    from ..explain import explain_recording

    check_targets((json, report), (recording, simulation))
    if simulation is not None and not simulation.is_file():
        raise ValueError(f"There is no file {str(simulation)!r} to compare with.")
    found = load(recording, rate_hz=rate, channels=channel, unit=unit)
    with channel_by_channel("explaining", len(found.channels)) as (announce, done):
        result = explain_recording(
            found,
            simulation=simulation,
            sampling=sampling,
            seed=seed,
            posterior=posterior,
            announce=announce,
            done=done,
        )
    _deliver(result.to_dict(), json, report)


def _deliver(document: Mapping[str, Any], json: str | None, report: Path | None) -> None:
    """The JSON first: should the page fail, nothing that was computed is lost."""
    if json is not None:
        write_json(document, json)
    if json != "-":
        typer.echo(format_explanation(document))
    if report is not None:
        write_explanation(document, report)
        typer.echo(f"\nPage with figures: {report}", err=True)
