"""The command `allanfit fleet`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from ..formatting import printable
from ._options import Channels, Rate, Sampling, Seed, Topic, Unit
from ._progress import progress_bar


def fleet(
    files: Annotated[
        list[Path], typer.Argument(help="Recordings, folders of them, or patterns in quotes.")
    ],
    output: Annotated[
        Path, typer.Option(help="Folder for the results (Parquet) and the summary (HTML).")
    ],
    scheduler: Annotated[
        str | None,
        typer.Option(help="Address of a dask scheduler, tcp://HOST:8786; else this machine."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes on this machine; one a core by default.", min=1)
    ] = None,
    rate: Rate = None,
    topic: Topic = None,
    channel: Channels = None,
    unit: Unit = None,
    sampling: Sampling = "point",
    temperature: Annotated[
        Literal["show", "remove", "ignore"], typer.Option(help="As in fit.")
    ] = "show",
    seed: Seed = 0,
) -> None:
    """Fit the recordings of many devices, compare the devices, and name those that stand out.

    Stopped in any way, the same command goes on where it was; what has not changed is not done
    again.

    Example: allanfit fleet recordings/ --output fleet
    """
    # The stage loads much that the other commands do without.
    from ..fleet import (
        FleetError,
        Options,
        compare,
        format_summary,
        run_fleet,
        silence,
        write_summary,
    )

    silence()
    options = Options(
        rate, unit, topic, tuple(channel) if channel else None, sampling, temperature, seed
    )
    with progress_bar() as progress:
        bar = progress.add_task("fitting", total=None)
        run = run_fleet(
            files,
            output,
            options,
            scheduler=scheduler,
            workers=workers,
            begin=lambda recordings: progress.update(bar, total=recordings),
            done=lambda recording: progress.update(
                bar, advance=1, description=printable(recording.name)
            ),
            waiting=lambda sentence: progress.console.print(
                f"allanfit: {sentence}", soft_wrap=True, markup=False, highlight=False
            ),
        )
        progress.update(bar, description="comparing")
        comparison = compare(run.rows)
    if len(run.errors) == len(run.recordings):
        raise FleetError(f"No recording could be analysed. {run.errors[0][1]}")
    page = output / "summary.html"
    typer.echo(format_summary(run, comparison))
    write_summary(run, comparison, page)
    if run.errors:
        typer.echo(
            f"allanfit: {len(run.errors)} of {len(run.recordings)} recordings could not be "
            "analysed; the column `error` says why.",
            err=True,
        )
    if run.others:
        typer.echo(
            f"allanfit: {run.others} results of other recordings in {output} are left out of the "
            "summary.",
            err=True,
        )
    typer.echo(f"\nDataset: {output / 'results'}\nPage with figures: {page}", err=True)
