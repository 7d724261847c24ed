"""Options that several commands share."""

from collections.abc import Sequence
from os.path import dirname, realpath  # unlike Path.resolve, at peace with rings of links
from pathlib import Path
from tempfile import TemporaryFile
from typing import Annotated, Literal

import typer

from ..report._paper import FIGURE_SUFFIXES

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
# The sampler takes no larger one, and simulate's seeds of many channels stay far below 2^63.
_LARGEST_SEED = 2**32 - 1
Seed = Annotated[
    int,
    typer.Option(
        help="Seed; the same seed gives the same numbers.", min=0, max=_LARGEST_SEED, metavar="N"
    ),
]
Sampling = Annotated[
    Literal["point", "averaged"],
    typer.Option(help="Whether a sample is a value at an instant or a mean over the interval."),
]


_PAGES = (".html", ".htm")


def refuse_other_pages(report: Path | None, *, figures: bool = True) -> None:
    """Find out before the work that a page is to go to a file of another format.

    **Raises** `ValueError` for a name with the ending of another format; `figures` is whether the
    command has `--figure`, which may be what was meant.
    """
    ending = "" if report is None else report.suffix.lower()
    if report is None or ending in ("", *_PAGES):
        return
    meant = figures and ending in FIGURE_SUFFIXES
    raise ValueError(
        f"--report writes a page, whose name ends with {' or '.join(_PAGES)}, and not "
        f"{report.name}{f'; --figure {report.name} makes a figure' if meant else ''}."
    )


def check_targets(targets: Sequence[str | Path | None], inputs: Sequence[Path | None]) -> None:
    """Find out before the work, not after it, that a result has nowhere to go or does harm there.

    **Raises** `ValueError` for a target in a folder that is not there or cannot be written, one
    that is a folder or one of the `inputs`, and two that are one.
    """
    read = {realpath(path) for path in inputs if path is not None}
    wanted = [Path(target) for target in targets if target is not None and str(target) != "-"]
    for target in wanted:
        folder = target.parent
        if not folder.is_dir():
            raise ValueError(
                f"There is no folder {str(folder)!r} to write {target.name} to; make it first."
            )
        if target.is_dir():
            raise ValueError(f"{target} is a folder: give the name of a file in it.")
        if realpath(target) in read:
            raise ValueError(f"{target} is what is read: give another name to write to.")
        # A device is written as it is, any other file by way of a new one beside it.
        if not target.exists() or target.is_file():
            try:
                TemporaryFile(dir=dirname(realpath(target))).close()
            except OSError as error:
                raise ValueError(
                    f"Cannot write {target} ({error.strerror}): give a path in a folder that is "
                    "writable and has space."
                ) from error
    if len({realpath(target) for target in wanted}) < len(wanted):
        raise ValueError(f"{wanted[0]} is to be written twice: give each result a name of its own.")
