"""The command line: a thin shell around the library.

Exit status: 0 done, 1 the analysis could not be done (one line on stderr says why), 2 wrong
usage. Data goes to stdout, messages to stderr, progress only to a terminal.
"""

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import jax
import numpy as np

try:
    import typer
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
except ImportError:  # pragma: no cover - tried in a subprocess without the extra
    sys.exit("allanfit: the command line needs its extra; run: pip install 'allanfit[cli]'")

from .coefficients import read_coefficients
from .demo import TRUTH, demonstrate
from .identify import RecordingFit, fit_recording
from .recording import load, save
from .report import format_text, write_json, write_page
from .simulate import simulate as simulate_series

app = typer.Typer(
    name="allanfit",
    help="Identify the noise of inertial sensors from still recordings.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Channels = Annotated[
    list[str] | None, typer.Option("--channel", help="A channel to use; repeat for more.")
]
Rate = Annotated[
    float | None, typer.Option("--rate", help="Samples per second, if the file does not say.")
]
Unit = Annotated[
    str | None, typer.Option(help="Unit of the channels, such as deg/s, rad/s, g or m/s^2.")
]
Json = Annotated[str | None, typer.Option(help="Write the results as JSON; - is stdout.")]
Seed = Annotated[int, typer.Option(help="Seed; the same seed gives the same numbers.", min=0)]
Sampling = Annotated[
    Literal["point", "averaged"],
    typer.Option(help="Whether a sample is a value at an instant or a mean over the interval."),
]


@app.command()
def fit(
    recording: Annotated[Path, typer.Argument(help="CSV, NPY or NPZ file of a still sensor.")],
    rate: Rate = None,
    channel: Channels = None,
    unit: Unit = None,
    json: Json = None,
    report: Annotated[Path | None, typer.Option(help="Write a page with figures, HTML.")] = None,
    posterior: Annotated[
        bool, typer.Option(help="Sample with emcee and report whether it has settled.")
    ] = True,
    sampling: Sampling = "point",
    seed: Seed = 0,
) -> None:
    """Identify Q, N, B, K and R of each channel, with intervals.

    Example: allanfit fit gyro.csv --rate 100 --unit deg/s --report gyro.html
    """
    _refuse_missing_folders(json, report)
    found = load(recording, rate_hz=rate, channels=channel, unit=unit)
    with _progress() as progress:
        task = progress.add_task("reading", total=len(found.channels))

        def announce(name: str) -> None:
            progress.update(task, description=f"fitting {name}")

        def done() -> None:
            progress.advance(task)

        result = fit_recording(
            found, posterior=posterior, sampling=sampling, seed=seed, announce=announce, done=done
        )
    _deliver(result, json, report)


@app.command()
def simulate(
    coefficients: Annotated[
        Path, typer.Argument(help="A fit's JSON, or YAML or JSON such as {unit: deg/s, N: 0.005}.")
    ],
    duration: Annotated[float, typer.Option(help="Length in seconds.")],
    rate: Annotated[float, typer.Option(help="Samples per second.")],
    output: Annotated[Path, typer.Option(help="File to write: .npz, .npy or .csv.")],
    channel: Channels = None,
    seed: Seed = 0,
) -> None:
    """Draw a recording from coefficients, exactly, for all five terms.

    Example: allanfit simulate fit.json --duration 3600 --rate 100 --seed 1 --output sim.npz
    """
    columns, units = {}, {}
    for index, entry in enumerate(read_coefficients(coefficients, channel)):
        samples = simulate_series(
            entry.values,
            duration_s=duration,
            rate_hz=rate,
            # Channels are independent: each has a seed of its own.
            seed=seed * 1_000_003 + index,
            sampling=entry.sampling,
            bias=entry.bias,
        )
        columns[entry.channel] = np.asarray(samples)
        units[entry.channel] = entry.unit
    save(output, columns, units, rate)


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
    with _progress() as progress:
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
    lines = ["Truth of the simulation beside the estimate:"]
    for symbol, true in TRUTH.items():
        low, high = entry[symbol]["intervals"]["0.95"]
        verdict = "inside" if low <= true <= high else "OUTSIDE"
        lines.append(
            f"  {symbol}  {true:10.4g}  95 % interval {low:.4g} to {high:.4g}"
            f"  {entry[symbol]['unit']:<16} {verdict}"
        )
    return "\n".join(lines)


def _deliver(result: RecordingFit, json: str | None, report: Path | None) -> None:
    """The JSON first: should the page fail, nothing that was computed is lost."""
    document = result.to_dict()
    if json is not None:
        write_json(document, json)
    if json != "-":
        typer.echo(format_text(document))
    if report is not None:
        write_page(document, report)
        typer.echo(f"\nPage with figures: {report}", err=True)


def _refuse_missing_folders(json: str | None, report: Path | None) -> None:
    """Find out before the work, not after it, that its result has nowhere to go."""
    for target in (json, report):
        if target not in (None, "-") and not Path(target).parent.is_dir():
            raise ValueError(
                f"There is no folder {str(Path(target).parent)!r} to write {Path(target).name} "
                "to; make it first."
            )


def _progress() -> Progress:
    console = Console(stderr=True)
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )


def _configure_jax() -> None:
    """Float64, and a bounded cache of compiled code, in a process that is ours."""
    jax.config.update("jax_enable_x64", True)
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "allanfit"
    if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
        jax.config.update("jax_compilation_cache_dir", str(cache))
    jax.config.update("jax_compilation_cache_max_size", 200 * 1024**2)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.3)


def main(argv: Sequence[str]) -> int:
    """Run one command; returns the exit status."""
    _configure_jax()
    try:
        app(args=list(argv))
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 1
    except (ValueError, OSError, MemoryError, ImportError) as error:
        # Our own errors are one sentence each; whatever else arrives is made one line.
        message = " ".join(str(error).split()) or type(error).__name__
        typer.echo(f"allanfit: {message}", err=True)
        return 1
    return 0


def run() -> None:
    """Entry point of the `allanfit` script."""
    sys.exit(main(sys.argv[1:]))
