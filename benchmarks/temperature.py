"""Is temperature blamed no more often than stated, and do sensitivities' intervals hold the truth?

    python -m benchmarks.temperature            # 400 records a scenario: 40 minutes on two cores
    python -m benchmarks.temperature --quick    # 40 records: three minutes

Noise and temperature are simulated apart, by generators that share no code with the model. The
thermometer is read as real ones are: with noise of its own, rounded, and held between conversions.
"""

import argparse
import json
import platform
from importlib.metadata import version
from pathlib import Path

import jax
import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.stats import beta

import allanfit
from allanfit.report import write_json

from .generators import record

RATE_HZ, DURATION_S = 10.0, 1200.0
GYRO = {"N": 5e-3, "B": 1e-3, "K": 5e-4}  # deg/s


def wander(rng, time):
    """A random walk of 1 degC in the record."""
    steps = rng.standard_normal(time.size) / np.sqrt(time.size)
    return 25 + np.cumsum(steps)


def warm_up(rng, time):
    """Self-heating, and a room whose heating goes on and off."""
    length = time[-1]
    rise = 3 * rng.uniform(0.5, 2) * -np.expm1(-time / (length * rng.uniform(0.1, 0.3)))
    phase, period = 2 * np.pi * rng.uniform(), length * rng.uniform(0.2, 0.4)
    return 25 + rise + 0.4 * np.sin(2 * np.pi * time / period + phase)


def drift_in_step(rng, time):
    """A rise so even that a rate ramp would look almost the same."""
    return (
        25
        + 2 * time / time[-1]
        + 0.1 * np.cumsum(rng.standard_normal(time.size)) / np.sqrt(time.size)
    )


def ideal(rng, temperature):
    return temperature


def thermometer(rng, temperature, hold=10, noise=0.02, code=0.0625):
    """Noise and rounding of a common digital thermometer, read ten times a conversion."""
    fresh = temperature[::hold] + noise * rng.standard_normal(temperature[::hold].size)
    return np.repeat(np.round(fresh / code) * code, hold)[: temperature.size]


# Temperature, thermometer, linear [u/degC] and quadratic [u/degC^2] sensitivity, coefficients.
SCENARIOS = {
    "unrelated random walk of temperature": (wander, ideal, 0.0, 0.0, GYRO),
    "the same, read by a thermometer": (wander, thermometer, 0.0, 0.0, GYRO),
    "the same, and the sensor has no walk": (wander, ideal, 0.0, 0.0, {"N": 5e-3}),
    "warm-up and a cycling room": (warm_up, thermometer, 0.01, 0.002, GYRO),
    "effect of a wandering temperature": (wander, thermometer, 0.02, 0.0, GYRO),
    "even rise, and a rate ramp": (drift_in_step, ideal, 0.01, 0.0, GYRO | {"R": 1e-5}),
}
_RESULTS = Path(__file__).parent / "results" / "temperature.json"


def one(scenario, index):
    """Whether each of linear and quadratic is claimed and held, and what the fit says of K."""
    move, read, linear, quadratic, coefficients = SCENARIOS[scenario]
    rng = np.random.default_rng((29, list(SCENARIOS).index(scenario), index))
    samples = round(DURATION_S * RATE_HZ)
    temperature = move(rng, np.arange(samples) / RATE_HZ)
    noise = record(rng, samples, 1 / RATE_HZ, coefficients)
    seen = read(rng, temperature)
    # About the mean that the thermometer tells, as the coefficients are.
    step = temperature - seen.mean()
    data = noise + linear * step + quadratic * step**2
    fit = allanfit.fit(data, RATE_HZ, seed=index)
    effect = allanfit.temperature_sensitivity(fit, data, seen, seed=index)
    truth = np.array([linear, quadratic])
    held = {
        level: np.asarray(inside(effect.interval(level), truth)).tolist() for level in (0.68, 0.95)
    }
    low, high = np.asarray(effect.removed.intervals["K"])
    plain_low, plain_high = np.asarray(fit.intervals["K"])
    walk = coefficients.get("K", 0.0)
    return {
        "claimed": [*np.asarray(effect.resolved).tolist(), bool(effect.p_value < 0.05)],
        "held": held,
        "estimate": [float(effect.linear), float(effect.quadratic)],
        "walk_held": bool(low <= walk <= high),
        "walk_held_plain": bool(plain_low <= walk <= plain_high),
        "misfit": bool(effect.removed.goodness_of_fit < 0.05),
        "share_of_ramp": float(effect.share_of_ramp),
    }


def inside(intervals, truth):
    return (np.asarray(intervals)[:, 0] <= truth) & (truth <= np.asarray(intervals)[:, 1])


def summary(scenario, rows):
    _, _, linear, quadratic, _ = SCENARIOS[scenario]
    claimed = np.mean([row["claimed"] for row in rows], axis=0)
    held = {level: np.mean([row["held"][level] for row in rows], axis=0) for level in (0.68, 0.95)}
    estimate = np.array([row["estimate"] for row in rows])
    error = np.std(estimate, axis=0) / np.sqrt(len(rows))
    bias = (np.mean(estimate, axis=0) - [linear, quadratic]) / error
    return {
        "records": len(rows),
        "claimed": dict(zip(("linear", "quadratic", "either"), claimed.tolist(), strict=True)),
        "coverage": {
            str(level): dict(zip(("linear", "quadratic"), share.tolist(), strict=True))
            for level, share in held.items()
        },
        "mean": np.mean(estimate, axis=0).tolist(),
        "bias_in_standard_errors": bias.tolist(),
        "coverage_of_K": float(np.mean([row["walk_held"] for row in rows])),
        "coverage_of_K_plain": float(np.mean([row["walk_held_plain"] for row in rows])),
        "misfit_below_0.05": float(np.mean([row["misfit"] for row in rows])),
        "share_of_ramp": float(np.mean([row["share_of_ramp"] for row in rows])),
    }


def interval(share, records):
    """Clopper and Pearson's 95 % interval of a proportion, in per cent."""
    hits = round(share * records)
    low = beta.ppf(0.025, hits, records - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, records - hits) if hits < records else 1.0
    return f"{100 * share:.1f} ({100 * low:.1f}-{100 * high:.1f})"


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--records", type=int, default=400)
    parser.add_argument("--scenario", choices=list(SCENARIOS), action="append")
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    records = 40 if options.quick else options.records
    console = Console()
    # Scenarios that are not run again keep what was found before.
    found = {}
    if _RESULTS.exists() and not options.quick:
        found = json.loads(_RESULTS.read_text())["scenarios"]
    for scenario in options.scenario or SCENARIOS:
        rows = [
            one(scenario, i)
            for i in track(range(records), scenario, console=console, transient=True)
        ]
        line = found[scenario] = summary(scenario, rows)
        claimed, cover = line["claimed"], line["coverage"]
        console.print(
            f"{scenario}: claimed at 5 %: linear {interval(claimed['linear'], records)} %, "
            f"quadratic {interval(claimed['quadratic'], records)} %, either "
            f"{interval(claimed['either'], records)} %; held at 68 %: "
            f"{cover['0.68']['linear']:.3f}, {cover['0.68']['quadratic']:.3f}; at 95 %: "
            f"{cover['0.95']['linear']:.3f}, {cover['0.95']['quadratic']:.3f}; bias in standard "
            f"errors {line['bias_in_standard_errors'][0]:.1f}, "
            f"{line['bias_in_standard_errors'][1]:.1f}; K held {line['coverage_of_K']:.3f}, by "
            f"the plain fit {line['coverage_of_K_plain']:.3f}; misfit "
            f"{line['misfit_below_0.05']:.3f}; ramp takes {line['share_of_ramp']:.2f}",
            soft_wrap=True,
        )
        if not options.quick:
            document = {
                "allanfit": version("allanfit"),
                "machine": platform.platform(),
                "rate_hz": RATE_HZ,
                "duration_s": DURATION_S,
                "scenarios": found,
            }
            write_json(document, _RESULTS)


if __name__ == "__main__":
    main()
