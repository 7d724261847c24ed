"""The command line: a thin shell around the library.

Exit status: 0 done, 1 the analysis could not be done (one line on stderr says why), 2 wrong
usage, 130 interrupted. Data goes to stdout, messages to stderr, progress only to a terminal.
"""

import logging
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

try:
    import typer

    from ._progress import channel_by_channel, load_with_progress, progress_bar, reading
except ImportError:  # pragma: no cover - tried in a subprocess without the extra
    sys.exit("allanfit: the command line needs its extra; run: pip install 'allanfit[cli]'")

from .._interrupt import INTERRUPTED, interrupts_at_work
from ..coefficients import read_coefficients
from ..compilation import configure_program
from ..datasheet import read_datasheet
from ..demo import TRUTH, demonstrate
from ..export import FORMATS, Options, parse_walk
from ..export import export as export_fit
from ..formatting import printable
from ..identify import RecordingFit, fit_file, fit_recording
from ..plan import parse_want, plan_file, plan_text
from ..recording import contents, save
from ..recording._given import as_given
from ..report import format_text, refuse_other_figures, write_json, write_page
from ..simulate import simulate as simulate_series
from ._calibrate import calibrate_app
from ._contents import contents_text
from ._deliver import deliver
from ._explain import explain
from ._fleet import fleet
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
from ._unused import tell_left_out, tell_undrawn, tell_unresolved

app = typer.Typer(
    name="allanfit",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _tell_version(asked: bool) -> bool:
    if asked:
        typer.echo(f"allanfit {version('allanfit')}")
        raise typer.Exit
    return asked


@app.callback()
def about(
    version: Annotated[
        bool,
        typer.Option(
            "--version", is_eager=True, callback=_tell_version, help="Say the version, and end."
        ),
    ] = False,
) -> None:
    """Identify the noise of inertial sensors from still recordings."""


app.add_typer(calibrate_app, name="calibrate")


@app.command()
def fit(
    recording: Annotated[Path, typer.Argument(help=RECORDING)],
    rate: Rate = None,
    topic: Topic = None,
    channel: Channels = None,
    unit: Unit = None,
    json: Json = None,
    report: Page = None,
    interactive: Interactive = True,
    figure: Figure = None,
    posterior: Annotated[
        bool, typer.Option(help="Sample with emcee and report whether it has settled.")
    ] = True,
    sampling: Sampling = "point",
    temperature: Annotated[
        Literal["show", "remove", "ignore"],
        typer.Option(
            help="With a temperature in the recording: estimate its effect, also take it out of "
            "the coefficients, or leave it alone."
        ),
    ] = "show",
    datasheet: Annotated[
        Path | None,
        typer.Option(help="YAML of a data sheet: say of each line whether the sensor meets it."),
    ] = None,
    seed: Seed = 0,
    blocks: Annotated[
        bool,
        typer.Option("--blocks", help="Read in blocks, for a file larger than memory."),
    ] = False,
    list_contents: Annotated[
        bool, typer.Option("--list", help="Only say what is in the recording, and end.")
    ] = False,
) -> None:
    """Identify Q, N, B, K and R of each channel, with intervals.

    Example: allanfit fit gyro.csv --rate 100 --unit deg/s --report gyro.html
    """
    if list_contents:
        typer.echo(contents_text(as_given(contents(recording), rate, unit)))
        return
    if figure is not None:
        refuse_other_figures(figure)
    check_targets((json, report, figure), (recording, datasheet))
    refuse_other_pages(report)
    sheet = None if datasheet is None else read_datasheet(datasheet)
    tell_left_out(datasheet)
    if blocks and temperature == "remove":
        raise ValueError("--temperature remove needs all samples at once: leave --blocks out.")
    if blocks:
        with reading(recording) as progress:
            result = fit_file(
                recording,
                rate_hz=rate,
                channels=channel,
                unit=unit,
                topic=topic,
                posterior=posterior,
                sampling=sampling,
                datasheet=sheet,
                seed=seed,
                progress=progress,
            )
    else:
        found = load_with_progress(recording, rate, channel, unit, topic)
        with channel_by_channel("fitting", len(found.channels)) as (announce, done):
            result = fit_recording(
                found,
                posterior=posterior,
                sampling=sampling,
                temperature=temperature,
                datasheet=sheet,
                seed=seed,
                announce=announce,
                done=done,
            )
    deliver(
        result.to_dict(),
        format_text,
        write_page,
        json=json,
        report=report,
        interactive=interactive,
        figure=figure,
    )


app.command()(explain)
app.command()(fleet)


@app.command()
def simulate(
    coefficients: Annotated[
        Path,
        typer.Argument(
            help="JSON of fit or explain, or YAML or JSON such as {unit: deg/s, N: 0.005}."
        ),
    ],
    duration: Annotated[float, typer.Option(help="Length in seconds.")],
    rate: Annotated[float, typer.Option(help="Samples per second.")],
    output: Annotated[Path, typer.Option(help="File to write: .npz, .npy or .csv.")],
    channel: Channels = None,
    seed: Seed = 0,
) -> None:
    """Draw a recording from coefficients, exactly, for all five terms, and effects with them.

    Example: allanfit simulate fit.json --duration 3600 --rate 100 --seed 1 --output sim.npz
    """
    check_targets((output,), (coefficients,))
    tell_left_out(coefficients)
    entries = read_coefficients(coefficients, channel)
    tell_unresolved(entries)
    columns, units = {}, {}
    for index, entry in enumerate(entries):
        samples = simulate_series(
            entry.values,
            duration_s=duration,
            rate_hz=rate,
            # Channels are independent: each has a seed of its own.
            seed=seed * 1_000_003 + index,
            sampling=entry.sampling,
            bias=entry.bias,
            effects=entry.effects,
        )
        tell_undrawn(entry)
        columns[entry.channel] = np.asarray(samples)
        units[entry.channel] = entry.unit
    replaced = output.is_file()
    save(output, columns, units, rate)
    size = next(iter(columns.values())).size
    parts = (f"{size} samples", f"{size / rate:.6g} s at {rate:g} Hz", f"seed {seed}")
    told = ", ".join((*parts, "in place of the file that was there") if replaced else parts)
    typer.echo(f"Recording: {output}, {told}", err=True)


@app.command()
def plan(
    coefficients: Annotated[
        Path, typer.Argument(help="A fit's JSON, or YAML or JSON such as {unit: deg/s, N: 0.005}.")
    ],
    rate: Annotated[float, typer.Option(help="Samples per second of the record to be made.")],
    want: Annotated[
        str, typer.Option(help="Relative standard errors (68 % half-widths), as N=1%,B=10%.")
    ],
    channel: Channels = None,
    sampling: Annotated[
        Literal["point", "averaged"] | None,
        typer.Option(help="As in fit; by default what the file says, else point."),
    ] = None,
    json: Json = None,
) -> None:
    """Tell how long to record for coefficients to be known as well as wanted.

    A wanted error is a standard error; the 95 % interval reaches twice as far to either side.

    Example: allanfit plan fit.json --rate 100 --want N=1%,B=10%,K=30%
    """
    check_targets((json,), (coefficients,))
    tell_left_out(coefficients)
    found = plan_file(coefficients, rate, parse_want(want), channels=channel, sampling=sampling)
    if json is not None:
        write_json(found.to_dict(), json)
    if json != "-":
        typer.echo(plan_text(found))


@app.command()
def export(
    fit: Annotated[Path, typer.Argument(help="JSON that fit --json or explain --json wrote.")],
    format: Annotated[str, typer.Option(help=f"One of {', '.join(FORMATS)}.")],
    output: Annotated[str, typer.Option(help="File to write; - is stdout.")] = "-",
    channel: Channels = None,
    axes: Annotated[
        Literal["worst", "mean"],
        typer.Option(help="Where a format has one number for all axes: the largest, or the mean."),
    ] = "worst",
    band: Annotated[
        tuple[float, float] | None,
        typer.Option(
            metavar="LOW HIGH",
            help="Averaging times in seconds between which flicker (B) is realised; by default "
            "from 4 samples to the length of the recording.",
        ),
    ] = None,
    walk: Annotated[
        str | None,
        typer.Option(
            metavar="limit|SECONDS",
            help="Random walk other than the resolved K: its 95 % upper limit where it is not "
            "resolved, or a walk that drifts as far as B and K together in that time.",
        ),
    ] = None,
    rostopic: Annotated[str, typer.Option(help="Topic named in Kalibr's file.")] = "/imu0",
) -> None:
    """Write a fit as the input of a filter, calibrator or simulator.

    Example: allanfit export fit.json --format kalman --output filter.json
    """
    check_targets((output,), (fit,))
    options = Options(axes, band, parse_walk(walk), rostopic)
    exported = export_fit(fit, format, options, channels=channel)
    for warning in exported.warnings:
        typer.echo(f"allanfit: {warning}", err=True)
    exported.write(output)


@app.command()
def demo(
    folder: Annotated[
        Path, typer.Option(help="Where to write the recording, the JSON and the page.")
    ] = Path("allanfit-demo"),
    seed: Seed = 0,
) -> None:
    """Simulate a gyro, identify it, print truth beside estimate, and write a page.

    Example: allanfit demo
    """
    with progress_bar() as progress:
        task = progress.add_task("simulating an hour of a consumer gyro", total=3)

        def announce(what: str) -> None:
            progress.update(task, description=what, advance=1)

        result, page = demonstrate(folder, seed, announce)
    typer.echo(format_text(result.to_dict()))
    typer.echo(_truth_table(result))
    typer.echo(f"\nThe page with figures: {page}")


def _truth_table(result: RecordingFit) -> str:
    """Truth beside estimate, and whether the 95 % interval holds it."""
    entry = result.to_dict()["channels"][0]["coefficients"]
    lines = [
        "Truth of the simulation beside the estimate. These intervals are two-sided; the",
        "limits above, after <, are one-sided and therefore a little lower.",
    ]
    for symbol, true in TRUTH.items():
        low, high = entry[symbol]["intervals"]["0.95"]
        verdict = "inside" if low <= true <= high else "OUTSIDE"
        lines.append(
            f"  {symbol}  {true:10.4g}  95 % interval {low:.4g} to {high:.4g}"
            f"  {entry[symbol]['unit']:<16} {verdict}"
        )
    return "\n".join(lines)


def main(argv: Sequence[str]) -> int:
    """Run one command; returns the exit status."""
    # Which fonts a machine lacks, and where else to cache them, is no matter of the user's.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        configure_program()
        app(args=list(argv))
    except SystemExit as stop:
        # Typer's, of a command that nobody else speaks for.
        if stop.code == INTERRUPTED:
            return _interrupted()
        return stop.code if isinstance(stop.code, int) else 1
    except KeyboardInterrupt:
        return _interrupted()
    except (ValueError, OSError, MemoryError, ImportError) as error:
        # Our own errors are one sentence each; whatever else arrives is made one line.
        text = str(error) or type(error).__name__
        if isinstance(error, OSError) and error.strerror:
            # A full disk has no name, and neither has one that fails while it is read.
            told = f"{str(error.filename)!r:.80} cannot be used"
            told = "Input or output failed" if error.filename is None else told
            text = f"{told}: {error.strerror}."
        message = printable(" ".join(text.split()))
        typer.echo(f"allanfit: {message}", err=True)
        return INTERRUPTED if isinstance(error.__cause__, KeyboardInterrupt) else 1
    return 0


def _interrupted() -> int:
    typer.echo("allanfit: Interrupted.", err=True)
    return INTERRUPTED


def run() -> None:
    """Entry point of the `allanfit` script."""
    interrupts_at_work()
    sys.exit(main(sys.argv[1:]))
