"""What is a telegraph on a random walk, and what is none: names, and how often intervals hold.

    python -m benchmarks.telegraph                 # 20 records a row, ten minutes
    python -m benchmarks.telegraph --records 100

White noise of N = 1 on a walk of K = 0.003 to 0.2 a sample, with a telegraph whose levels are 3 to
7 standard deviations of single samples apart and last for 200 to 5000 samples on average; with a
Gauss-Markov process of the same spectrum; with four steps of one height, and some loud seconds.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import lfilter

import allanfit

from ._records import keep, record_options

SAMPLES, RATE_HZ = 120_000, 10.0
KINDS = ("telegraph", "Gauss-Markov", "steps")


def levels(rng: np.random.Generator, dwell: float, samples: int = SAMPLES) -> np.ndarray:
    """0 and 1, each for exponential times."""
    held = np.ceil(rng.exponential(dwell, 4 * int(samples / dwell + 20))).astype(int)
    return np.repeat(np.arange(held.size) % 2, held)[:samples].astype(float)


def draw(kind: str, seed: int) -> tuple[np.ndarray, dict[str, float]]:
    """A record and what it holds, in samples."""
    rng = np.random.default_rng((77, KINDS.index(kind), seed))
    walk, dwell = 10 ** rng.uniform(-2.5, -0.7), 10 ** rng.uniform(2.3, 3.7)
    height = float(rng.uniform(3, 7) * np.hypot(1, 2 * walk))
    x = rng.standard_normal(SAMPLES) + walk * np.cumsum(rng.standard_normal(SAMPLES))
    if kind == "telegraph":
        x += height * levels(rng, dwell)
    elif kind == "Gauss-Markov":
        decay = np.exp(-2 / dwell)
        driven = np.sqrt(1 - decay**2) * rng.standard_normal(SAMPLES)
        x += height / 2 * np.asarray(lfilter([1.0], [1.0, -decay], driven))
    else:
        for at in rng.choice(SAMPLES, 4, replace=False):
            x[at:] += height * rng.choice([-1, 1])
        at = rng.integers(SAMPLES - 1000)
        x[at : at + 1000] += 2 * rng.standard_normal(1000)
    return x, {"amplitude": height, "dwell_time": dwell / RATE_HZ, "N": RATE_HZ**-0.5}


def main(arguments=None):
    options = record_options(__doc__, 20, arguments)
    rows = []
    for kind in KINDS:
        row = {"kind": kind, "named": 0, "alone": 0, "amplitude": 0, "dwell_time": 0, "N": 0}
        for seed in track(range(options.records), kind, console=Console(stderr=True)):
            x, truth = draw(kind, seed)
            recording = allanfit.recording_of(x, rate_hz=RATE_HZ, unit="rad/s")
            (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
            effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
            told = {**found["coefficients_after"], **effects.get("random_telegraph", {})}
            row["named"] += "random_telegraph" in effects
            row["alone"] += list(effects) == ["random_telegraph"]
            for name, value in truth.items():
                if name in told and (name == "N" or kind == "telegraph"):
                    low, high = told[name]["intervals"]["0.95"]
                    row[name] += low <= value <= high
        rows.append(row)
    print("| record | named a telegraph | and nothing else | amplitude held | dwell | N | of")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()), f"| {options.records} |")
    keep(options, "telegraph", rows)


if __name__ == "__main__":
    main()
