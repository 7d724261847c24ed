"""Options that several commands share."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from ..report import refuse_other_figures

RECORDING = "CSV, NPY, NPZ, Parquet, MAT, HDF5, ROS bag, MCAP or ULog file of a still sensor."

Channels = Annotated[
    list[str] | None, typer.Option("--channel", help="A channel to use; repeat for more.")
]
Rate = Annotated[
    float | None, typer.Option("--rate", help="Samples per second, if the file does not say.")
]
Topic = Annotated[
    str | None,
    typer.Option("--topic", help="The part to read of a bag, a log, HDF5 or MAT with several."),
]
Unit = Annotated[
    str | None, typer.Option(help="Unit of the channels, such as deg/s, rad/s, g or m/s^2.")
]
Json = Annotated[str | None, typer.Option(help="Write the results as JSON; - is stdout.")]
Page = Annotated[Path | None, typer.Option("--report", help="Write a page with figures, HTML.")]
Interactive = Annotated[
    bool,
    typer.Option(
        help="Figures of the page that answer to the pointer; without them it is 2 MB smaller."
    ),
]
Figure = Annotated[
    Path | None,
    typer.Option(
        "--figure",
        help="Write the Allan deviation for a paper, as .pdf, .svg or .png, and the spectrum "
        "beside it with -psd in its name.",
    ),
]
Seed = Annotated[int, typer.Option(help="Seed; the same seed gives the same numbers.", min=0)]
Sampling = Annotated[
    Literal["point", "averaged"],
    typer.Option(help="Whether a sample is a value at an instant or a mean over the interval."),
]


def refuse_missing_folders(
    json: str | None, report: Path | None, figure: Path | None = None
) -> None:
    """Find out before the work, not after it, that its result has nowhere to go."""
    if figure is not None:
        refuse_other_figures(figure)
    for target in (json, report, figure):
        if target not in (None, "-") and not Path(target).parent.is_dir():
            raise ValueError(
                f"There is no folder {str(Path(target).parent)!r} to write {Path(target).name} "
                "to; make it first."
            )
