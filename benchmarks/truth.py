"""Do the intervals hold the truth, and how far from the Cramér-Rao bound are the estimates?

    python -m benchmarks.truth            # 300 records a scenario
    python -m benchmarks.truth --quick    # 40 records of the short scenarios

Writes one JSON file a scenario, so that an interrupted study goes on where it stopped, and prints
the table that the docs quote.
"""

import argparse
import json
import platform
from importlib.metadata import version
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from scipy.stats import kstest

import allanfit
from allanfit.curves import design, unit_scale
from allanfit.identify._likelihood import fisher_information

from .generators import record

SCENARIOS = {
    "consumer gyro, 10 min": (600, 50, {"N": 5e-3, "B": 2e-3, "K": 3e-4}, {}),
    "consumer gyro, 1 h": (3600, 50, {"N": 5e-3, "B": 1e-3, "K": 1e-4}, {}),
    "the same, averaging, relaxations": (
        3600, 50, {"N": 5e-3, "B": 1e-3, "K": 1e-4}, {"averaged": True, "relaxations": True},
    ),
    "old MEMS gyro, large Q, 1 h": (
        3600, 50, {"Q": 3e-4, "N": 1e-3, "B": 6e-4, "K": 8e-5}, {},
    ),
    "no flicker, 1 h": (3600, 50, {"N": 5e-3, "K": 2e-4}, {}),
    "no walk, 1 h": (3600, 50, {"N": 5e-3, "B": 2e-3}, {}),
    "white only, 10 min": (600, 50, {"N": 5e-3}, {}),
    "with a ramp, 1 h": (3600, 50, {"N": 5e-3, "B": 1e-3, "R": 1e-5}, {}),
}  # fmt: skip
QUICK = ("consumer gyro, 10 min", "white only, 10 min")
_CHUNK = 20


def bound(samples, rate_hz, coefficients, sampling):
    """Cramér-Rao bounds on the present noise terms, relative to each; a ramp is unknown too."""
    layout = design((samples,), sampling)
    scale = np.asarray(unit_scale(1 / rate_hz))[:4]
    power = (np.array([coefficients.get(s, 0.0) for s in "QNBK"]) / scale) ** 2
    information = np.asarray(
        fisher_information(
            jnp.asarray(power), jnp.asarray(layout.density), jnp.asarray(layout.ordinates / 2)
        )
    )
    present = np.flatnonzero(power)
    variance = np.diag(np.linalg.inv(information[np.ix_(present, present)]))
    return {
        "QNBK"[i]: float(np.sqrt(v) / (2 * power[i]))
        for i, v in zip(present, variance, strict=True)
    }


def run(duration_s, rate_hz, coefficients, options, records, progress):
    """Fit `records` simulated records; returns estimates and intervals by symbol."""
    samples = round(duration_s * rate_hz)
    sampling = "averaged" if options.get("averaged") else "point"
    collected = []
    for first in range(0, records, _CHUNK):
        data = np.stack(
            [
                record(np.random.default_rng((7, i)), samples, 1 / rate_hz, coefficients, **options)
                for i in range(first, first + _CHUNK)
            ]
        )
        fits = allanfit.fit_many(data, rate_hz, sampling=sampling, seed=first)
        collected.append(
            {
                "value": np.stack([fits.coefficients[s] for s in "QNBKR"]),
                "least_squares": np.stack([fits.least_squares[s] for s in "QNBKR"]),
                "resolved": np.stack([fits.resolved[s] for s in "QNBKR"]),
                "limit": np.stack([fits.upper_limits[s] for s in "QNBKR"]),
                **{
                    f"interval_{level}": np.stack([fits.interval(level)[s] for s in "QNBKR"])
                    for level in (0.68, 0.9, 0.95)
                },
                "p_value": np.asarray(fits.goodness_of_fit),
            }
        )
        progress(first + _CHUNK)
    axis = {"p_value": 0}
    return {k: np.concatenate([c[k] for c in collected], axis.get(k, 1)) for k in collected[0]}


def summarise(found, coefficients, bounds):
    """The figures of one scenario, by symbol."""
    rows = {}
    for i, symbol in enumerate("QNBKR"):
        truth = coefficients.get(symbol, 0.0)
        row = {"resolved": float(np.mean(found["resolved"][i]))}
        for level in (0.68, 0.9, 0.95):
            low, high = found[f"interval_{level}"][i].T
            row[f"coverage_{level}"] = float(np.mean((low <= truth) & (truth <= high)))
        if truth:
            error = found["value"][i] / truth - 1
            row["relative_rmse"] = float(np.sqrt(np.mean(error**2)))
            row["relative_bias"] = float(np.mean(error))
            if symbol in bounds:
                row["bound"] = bounds[symbol]
                row["rmse_over_bound"] = row["relative_rmse"] / bounds[symbol]
                row["bias_over_bound"] = row["relative_bias"] / bounds[symbol]
        rows[symbol] = row
    p_value = kstest(found["p_value"], "uniform").pvalue
    return {"coefficients": rows, "goodness_of_fit_ks_p": float(p_value)}


def table(results):
    """Markdown; one line a coefficient that is present, then what was claimed of absent ones."""
    lines = [
        "| scenario | term | error/bound | bias/bound | 68 % | 90 % | 95 % | resolved |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, result in results.items():
        for symbol, row in result["coefficients"].items():
            cells = [name, symbol]
            if "relative_rmse" in row:
                for key in ("rmse_over_bound", "bias_over_bound"):
                    cells.append(f"{row[key]:.2f}" if key in row else "")
                cells += [f"{row[f'coverage_{level}']:.3f}" for level in (0.68, 0.9, 0.95)]
            else:
                cells += ["absent", "", "", "", ""]
            lines.append(f"| {' | '.join(cells)} | {row['resolved']:.3f} |")
    return "\n".join(lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--records", type=int)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/truth"))
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    records = options.records or (40 if options.quick else 300)
    names = QUICK if options.quick else SCENARIOS
    options.output.mkdir(parents=True, exist_ok=True)
    results = {}
    for name in names:
        duration_s, rate_hz, coefficients, generator = SCENARIOS[name]
        file = options.output / f"{name.replace(',', '').replace(' ', '-')}-{records}.json"
        if not file.exists():
            sampling = "averaged" if generator.get("averaged") else "point"
            found = run(
                duration_s, float(rate_hz), coefficients, generator, records,
                lambda done, name=name: print(f"{name}: {done} of {records}", end="\r"),
            )  # fmt: skip
            bounds = bound(duration_s * rate_hz, float(rate_hz), coefficients, sampling)
            result = summarise(found, coefficients, bounds) | {
                "records": records,
                "machine": platform.machine(),
                "python": platform.python_version(),
                "jax": version("jax"),
            }
            file.write_text(json.dumps(result, indent=1))
        results[name] = json.loads(file.read_text())
    print(f"\n{records} records a scenario\n")
    print(table(results))


if __name__ == "__main__":
    main()
