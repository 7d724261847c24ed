"""Do the intervals hold the truth, and how far from the Cramér-Rao bound are the estimates?

    python -m benchmarks.truth            # 500 records a scenario: an hour on two cores
    python -m benchmarks.truth --quick    # 60 records of two short scenarios: a minute

Real time series, simulated by generators that share no code with the model. Writes one JSON file
a scenario, block by block, so that an interrupted study goes on where it stopped, and prints the
table that the docs quote.
"""

import argparse
import platform
from functools import partial
from importlib.metadata import version
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from rich.console import Console
from rich.progress import Progress
from scipy.stats import kstest

import allanfit
from allanfit.curves import design, unit_scale
from allanfit.identify._likelihood import fisher_information
from allanfit.report import write_json
from allanfit.whole_file import replacing

from .generators import record

# Duration [s], rate [Hz], coefficients [u = deg/s for gyros, m/s^2 for accelerometers], generator.
SCENARIOS = {
    "consumer gyro, 10 min": (600, 50, {"N": 5e-3, "B": 2e-3, "K": 3e-4}, {}),
    "consumer gyro, 1 h": (3600, 100, {"N": 5e-3, "B": 1e-3, "K": 1e-4}, {}),
    "consumer gyro, all five terms, 3 h": (
        10800, 20, {"Q": 3e-4, "N": 5e-3, "B": 1e-3, "K": 1e-4, "R": 1e-5}, {},
    ),
    "industrial gyro, averaging, 1 h": (
        3600, 50, {"N": 2e-3, "B": 8e-4, "K": 5e-5}, {"averaged": True},
    ),
    "tactical gyro, averaging, 3 h": (
        10800, 20, {"N": 2e-4, "B": 1.5e-4, "K": 6e-6}, {"averaged": True},
    ),
    "old MEMS gyro, large Q, 10 min": (
        600, 50, {"Q": 3e-4, "N": 1e-3, "B": 9e-4, "K": 2e-4}, {},
    ),
    "old MEMS gyro, large Q, 1 h": (3600, 50, {"Q": 3e-4, "N": 1e-3, "B": 6e-4, "K": 8e-5}, {}),
    # Q as large as the gyro of docs/paper.md has it, with N at the limit of what shows, and below.
    "very large Q, N at its limit, 10 min": (
        600, 50, {"Q": 6.3e-3, "N": 9e-4, "B": 8.2e-4, "K": 2.1e-4}, {},
    ),
    "very large Q, N far below, 10 min": (
        600, 50, {"Q": 6.3e-3, "N": 1.2e-4, "B": 8.2e-4, "K": 2.1e-4}, {},
    ),
    "consumer accelerometer, 1 h": (3600, 50, {"N": 1e-3, "B": 4e-4, "K": 3e-5}, {}),
    "geophysical accelerometer, averaging, 3 h": (
        10800, 20, {"N": 1e-7, "B": 2e-8, "K": 1.5e-9}, {"averaged": True},
    ),
    "no white noise, 1 h": (3600, 20, {"Q": 3e-4, "B": 2e-3, "K": 2e-4}, {}),
    "no flicker, 1 h": (3600, 50, {"N": 5e-3, "K": 2e-4}, {}),
    # What the states of most filters say, with a walk so strong that flicker would hide in it.
    "white noise on a strong walk, 20 min": (1200, 50, {"N": 5e-3, "K": 2.5e-2}, {}),
    "no walk, 1 h": (3600, 50, {"N": 5e-3, "B": 2e-3}, {}),
    "white noise only, 10 min": (600, 50, {"N": 5e-3}, {}),
    "ramp without walk, 1 h": (3600, 50, {"N": 5e-3, "B": 1e-3, "R": 1e-5}, {}),
}  # fmt: skip
QUICK = ("consumer gyro, 10 min", "white noise only, 10 min")
LEVELS = (0.68, 0.9, 0.95)
_BLOCK = 16


def bound(samples, rate_hz, coefficients, sampling, known="QNBK"):
    """Cramér-Rao bounds on the present noise terms, relative to each; a ramp is unknown too.

    The absent ones among `known` are known to be absent; the bound of who does not know that has
    an empty `known`.
    """
    layout = design((samples,), sampling)
    scale = np.asarray(unit_scale(1 / rate_hz))[:4]
    power = (np.array([coefficients.get(s, 0.0) for s in "QNBK"]) / scale) ** 2
    information = np.asarray(
        fisher_information(
            jnp.asarray(power), jnp.asarray(layout.density), jnp.asarray(layout.ordinates / 2)
        )
    )
    unknown = [i for i, s in enumerate("QNBK") if power[i] or s not in known]
    variance = np.diag(np.linalg.inv(information[np.ix_(unknown, unknown)]))
    return {
        "QNBK"[i]: float(np.sqrt(v) / (2 * power[i]))
        for i, v in zip(unknown, variance, strict=True)
        if power[i]
    }


def run(scenario, records, folder, progress):
    """Fit `records` simulated records; returns estimates and intervals by symbol."""
    duration_s, rate_hz, coefficients, options = scenario
    samples = round(duration_s * rate_hz)
    sampling = "averaged" if options.get("averaged") else "point"
    blocks = []
    for first in range(0, records, _BLOCK):
        file = folder / f"{first:05d}.npz"
        if not file.exists():
            data = np.stack(
                [
                    record(
                        np.random.default_rng((7, i)), samples, 1 / rate_hz, coefficients, **options
                    )
                    for i in range(first, first + _BLOCK)
                ]
            )
            fits = allanfit.fit_many(data, float(rate_hz), sampling=sampling, seed=first)
            with replacing(file) as temporary, temporary.open("wb") as stream:
                np.savez(
                    stream,
                    value=_table(fits.coefficients),
                    least_squares=_table(fits.least_squares),
                    resolved=_table(fits.resolved),
                    limit=_table(fits.upper_limits),
                    p_value=np.asarray(fits.goodness_of_fit)[:, None],
                    **{f"interval_{level}": _table(fits.interval(level)) for level in LEVELS},
                )
        with np.load(file) as stored:
            blocks.append(dict(stored))
        progress(completed=first + _BLOCK)
    return {key: np.concatenate([block[key] for block in blocks])[:records] for key in blocks[0]}


def _table(values):
    """Shape (records, 5) or (records, 5, 2)."""
    return np.stack([np.asarray(values[s]) for s in "QNBKR"], axis=1)


def summarise(found, coefficients, bounds, free_bounds):
    """The figures of one scenario, by symbol."""
    rows = {}
    for i, symbol in enumerate("QNBKR"):
        truth = coefficients.get(symbol, 0.0)
        row = {
            "resolved": float(np.mean(found["resolved"][:, i])),
            "limit_holds": float(np.mean(found["limit"][:, i] >= truth)),
        }
        for level in LEVELS:
            low, high = found[f"interval_{level}"][:, i].T
            row[f"coverage_{level}"] = float(np.mean((low <= truth) & (truth <= high)))
        if truth:
            error = found["value"][:, i] / truth - 1
            row["relative_rmse"] = float(np.sqrt(np.mean(error**2)))
            row["relative_bias"] = float(np.mean(error))
            row["bias_over_deviation"] = float(np.mean(error) / np.std(error))
            if symbol in bounds:
                row["bound"] = bounds[symbol]
                row["rmse_over_bound"] = row["relative_rmse"] / bounds[symbol]
                row["rmse_over_free_bound"] = row["relative_rmse"] / free_bounds[symbol]
        rows[symbol] = row
    p_value = kstest(found["p_value"].ravel(), "uniform").pvalue
    return {"coefficients": rows, "goodness_of_fit_ks_p": float(p_value)}


def table(results):
    """Markdown; a line for each coefficient that is present."""
    lines = [
        "| scenario | term | bound | error/bound | knowing nothing | bias/s.d. "
        "| 68 % | 90 % | 95 % | resolved |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, result in results.items():
        for symbol, row in result["coefficients"].items():
            if "relative_rmse" not in row:
                continue
            cells = [name, symbol]
            if "bound" in row:
                cells += [f"{100 * row['bound']:.2g} %"]
                cells += [f"{row[k]:.2f}" for k in ("rmse_over_bound", "rmse_over_free_bound")]
            else:
                cells += ["", "", ""]
            cells += [f"{row['bias_over_deviation']:.2f}"]
            cells += [f"{row[f'coverage_{level}']:.3f}" for level in LEVELS]
            lines.append(f"| {' | '.join(cells)} | {row['resolved']:.3f} |")
    return "\n".join(lines)


def absent_table(results):
    """Markdown; what was claimed of absent terms, and whether the model was thought to fit."""
    lines = [
        "| scenario | Q | N | B | K | R | p-value uniform: p |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, result in results.items():
        claims = [
            "" if "relative_rmse" in row else f"{row['resolved']:.3f}"
            for row in result["coefficients"].values()
        ]
        lines.append(f"| {name} | {' | '.join(claims)} | {result['goodness_of_fit_ks_p']:.3f} |")
    return "\n".join(lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--records", type=int)
    parser.add_argument("--only", help="scenarios whose name holds this text")
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/truth"))
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    records = options.records or (60 if options.quick else 500)
    names = QUICK if options.quick else SCENARIOS
    results = {}
    for name in names:
        if options.only and options.only not in name:
            continue
        folder = options.output / name.replace(",", "").replace(" ", "-")
        folder.mkdir(parents=True, exist_ok=True)
        scenario = SCENARIOS[name]
        duration_s, rate_hz, coefficients, generator = scenario
        with Progress(console=Console(stderr=True)) as bar:
            task = bar.add_task(name, total=records)
            found = run(scenario, records, folder, partial(bar.update, task))
        sampling = "averaged" if generator.get("averaged") else "point"
        about = (duration_s * rate_hz, float(rate_hz), coefficients, sampling)
        results[name] = summarise(found, coefficients, bound(*about), bound(*about, known="")) | {
            "records": records,
            "machine": platform.machine(),
            "python": platform.python_version(),
            "jax": version("jax"),
        }
    write_json(results, str(options.output / f"truth-{records}.json"))
    print(f"{records} records a scenario\n")
    print(table(results))
    print("\nTerms that are absent: fraction of records in which they are claimed.\n")
    print(absent_table(results))


if __name__ == "__main__":
    main()
