"""The commands of `allanfit calibrate`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from ..calibrate import (
    Calibration,
    calibration_text,
    multi_position,
    rate_table,
    up_down,
    write_calibration_page,
)
from ..report import write_json
from ._options import (
    Channels,
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
from ._unused import tell_left_out

calibrate_app = typer.Typer(
    help="Bias, scale factor and misalignment, with intervals.", no_args_is_help=True
)

Gravity = Annotated[
    float | None, typer.Option(help="Gravity where the test was made, m/s^2; else the standard.")
]


@calibrate_app.command("up-down")
def calibrate_up_down(
    up: Annotated[Path, typer.Argument(help="Still recording with the axis up: it reads +g.")],
    down: Annotated[Path, typer.Argument(help="The same with the axis down.")],
    gravity: Gravity = None,
    rate: Rate = None,
    topic: Topic = None,
    channel: Channels = None,
    unit: Unit = None,
    noise: Annotated[
        Path | None, typer.Option(help="Noise from a longer recording: a fit's JSON, or YAML.")
    ] = None,
    gap: Annotated[float, typer.Option(help="Seconds from the end of UP to DOWN.", min=0)] = 0.0,
    json: Json = None,
    report: Page = None,
    sampling: Sampling = "point",
    seed: Seed = 0,
) -> None:
    """Bias and scale factor of accelerometer axes held up, then down.

    Example: allanfit calibrate up-down up.csv down.csv --rate 100 --unit m/s^2 --gravity 9.812
    """
    check_targets((json, report), (up, down, noise))
    refuse_other_pages(report, figures=False)
    tell_left_out(noise)
    found = up_down(
        up,
        down,
        gravity=gravity,
        rate_hz=rate,
        channels=channel,
        unit=unit,
        topic=topic,
        noise=noise,
        gap_s=gap,
        sampling=sampling,
        seed=seed,
    )
    _deliver(found, json, report)


@calibrate_app.command("rate-table")
def calibrate_rate_table(
    table: Annotated[Path, typer.Argument(help="CSV: rate, and cw and ccw or roll_cw, roll_ccw.")],
    unit: Annotated[str | None, typer.Option(help="Unit of the table: rpm, deg/s, rad/s.")] = None,
    latitude: Annotated[
        float | None, typer.Option(help="Degrees north, to take out the Earth's rate.")
    ] = None,
    reference: Annotated[
        Literal["table", "earth"],
        typer.Option(help="What turns: a table, or the Earth under a gyro turned over at rest."),
    ] = "table",
    json: Json = None,
    report: Page = None,
) -> None:
    """Bias and scale factor of gyro axes on a rate table.

    Example: allanfit calibrate rate-table table.csv --unit rpm --latitude 52.5
    """
    check_targets((json, report), (table,))
    refuse_other_pages(report, figures=False)
    found = rate_table(table, unit=unit, latitude_deg=latitude, reference=reference)
    _deliver(found, json, report)


@calibrate_app.command("multi-position")
def calibrate_multi_position(
    positions: Annotated[
        Path, typer.Argument(help="CSV of means: ax, ay, az [ref_x, ref_y, ref_z]; or a recording.")
    ],
    gravity: Gravity = None,
    unit: Unit = None,
    sigma: Annotated[
        float | None, typer.Option(help="Standard deviation of a mean, in its unit, if known.")
    ] = None,
    orthogonal: Annotated[
        bool, typer.Option("--orthogonal", help="Take the axes as orthogonal.")
    ] = False,
    rate: Rate = None,
    topic: Topic = None,
    channel: Channels = None,
    json: Json = None,
    report: Page = None,
) -> None:
    """Bias, scale factor and misalignment of an accelerometer triad at rest.

    Example: allanfit calibrate multi-position means.csv --unit m/s^2 --gravity 9.812
    """
    check_targets((json, report), (positions,))
    refuse_other_pages(report, figures=False)
    found = multi_position(
        positions,
        gravity=gravity,
        unit=unit,
        sigma=sigma,
        orthogonal=orthogonal,
        rate_hz=rate,
        channels=channel,
        topic=topic,
    )
    _deliver(found, json, report)


def _deliver(found: Calibration, json: str | None, report: Path | None) -> None:
    if json is not None:
        write_json(found.to_dict(), json)
    if json != "-":
        typer.echo(calibration_text(found))
    if report is not None:
        write_calibration_page(found, report)
        typer.echo(f"\nPage with figures: {report}", err=True)
