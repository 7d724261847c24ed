"""The command `allanfit explain`."""

from pathlib import Path
from typing import Annotated

import typer

from ..report import format_explanation, refuse_other_figures, write_explanation
from ._deliver import deliver
from ._options import (
    RECORDING,
    Channels,
    Figure,
    Interactive,
    Json,
    Page,
    Rate,
    Sampling,
    Seed,
    Topic,
    Unit,
    check_targets,
    refuse_other_pages,
)
from ._progress import channel_by_channel, load_with_progress
from ._unused import tell_left_out


def explain(
    recording: Annotated[Path, typer.Argument(help=RECORDING)],
    simulation: Annotated[
        Path | None,
        typer.Option(
            help="What to compare with: a recording made by your simulator, or its coefficients "
            "(a fit's JSON, or YAML)."
        ),
    ] = None,
    rate: Rate = None,
    topic: Topic = None,
    channel: Channels = None,
    unit: Unit = None,
    json: Json = None,
    report: Page = None,
    interactive: Interactive = True,
    figure: Figure = None,
    posterior: Annotated[
        bool,
        typer.Option(
            help="Sample each posterior to the end; else a quarter of it, for rough intervals."
        ),
    ] = True,
    sampling: Sampling = "point",
    seed: Seed = 0,
) -> None:
    """Find what Q, N, B, K and R leave out of each channel, name it and model it.

    Example: allanfit explain gyro.csv --rate 100 --unit deg/s --report explain.html
    """
    # The stage loads much that the other commands do without.
    from ..explain import explain_recording

    if figure is not None:
        refuse_other_figures(figure)
    check_targets((json, report, figure), (recording, simulation))
    refuse_other_pages(report)
    if simulation is not None and not simulation.exists():
        raise ValueError(f"There is no file {str(simulation)!r} to compare with.")
    tell_left_out(simulation)
    found = load_with_progress(recording, rate, channel, unit, topic)
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
    deliver(
        result.to_dict(),
        format_explanation,
        write_explanation,
        json=json,
        report=report,
        interactive=interactive,
        figure=figure,
    )
