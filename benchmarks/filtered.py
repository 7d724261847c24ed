"""What is said of steps, telegraphs and knocks that pass the sensor's own filter with the noise?

    python -m benchmarks.filtered                 # 20 records a row, seven minutes
    python -m benchmarks.filtered --records 100

White noise of N = 1 on a walk of K = 0.0001 to 0.001 a sample, with a step of 1 to 20 standard
deviations of single samples, with a telegraph whose levels are 2 to 7 of them apart and last for
400 to 5000 samples on average, or with a knock of 5 to 20 that rings; all of it filtered by a
Butterworth filter of order 1 to 4, by two equal poles, by a running mean or by a windowed sinc of
31 samples, with a corner at 0.05 to 0.3 cycles a sample. A tool that draws steps with sharp edges
finds a knock or spikes beside each.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import butter, firwin, lfilter

import allanfit

from ._records import keep, record_options
from .telegraph import levels

SAMPLES, RATE_HZ = 120_000, 100.0
# Records begin when the filter has forgotten that it was empty.
BEFORE = 2_000
KINDS = {"nothing": "", "step": "step", "telegraph": "random_telegraph", "knock": "disturbance"}


def filtered(rng: np.random.Generator, x: np.ndarray) -> tuple[np.ndarray, str]:
    """By a filter of some kind."""
    corner = 10 ** rng.uniform(-1.3, -0.52)
    kind = rng.choice(["Butterworth", "two poles", "running mean", "windowed sinc"])
    if kind == "Butterworth":
        b, a = butter(int(rng.integers(1, 5)), 2 * corner)
    elif kind == "two poles":
        keep = np.exp(-2 * np.pi * corner)
        b, a = np.array([(1 - keep) ** 2]), np.convolve([1, -keep], [1, -keep])
    elif kind == "running mean":
        taps = max(round(0.443 / corner), 2)
        b, a = np.full(taps, 1 / taps), np.array([1.0])
    else:
        b, a = firwin(31, 2 * corner), np.array([1.0])
    return np.asarray(lfilter(b, a, x)), str(kind)


def draw(kind: str, seed: int) -> tuple[np.ndarray, dict[str, float], str]:
    """A record, what it holds in SI units, and what filtered it."""
    rng = np.random.default_rng((78, list(KINDS).index(kind), seed))
    samples = SAMPLES + BEFORE
    x, walk = rng.standard_normal(samples), 10 ** rng.uniform(-4, -3)
    x += walk * np.cumsum(rng.standard_normal(samples))
    truth = {"N": RATE_HZ**-0.5}
    if kind == "step":
        truth["amplitude"] = float(10 ** rng.uniform(0, 1.3) * rng.choice([-1, 1]))
        x[rng.integers(samples // 4, 3 * samples // 4) :] += truth["amplitude"]
    elif kind == "telegraph":
        truth["amplitude"], dwell = rng.uniform(2, 7), 10 ** rng.uniform(2.6, 3.7)
        truth["dwell_time"] = dwell / RATE_HZ
        x += truth["amplitude"] * levels(rng, dwell, samples)
    elif kind == "knock":
        at, time = rng.integers(samples // 4, 3 * samples // 4), np.arange(400)
        ringing = np.exp(-time / rng.uniform(10, 60)) * np.sin(rng.uniform(0.1, 0.6) * time)
        x[at : at + 400] += rng.uniform(5, 20) * ringing
    x, by = filtered(rng, x)
    return x[BEFORE:], truth, by


def main(arguments=None):
    options = record_options(__doc__, 20, arguments)
    rows, wrong = [], []
    for kind, name in KINDS.items():
        row = {"kind": kind, "named": 0, "alone": 0, "amplitude": 0, "dwell_time": 0, "N": 0}
        for seed in track(range(options.records), kind, console=Console(stderr=True)):
            x, truth, by = draw(kind, seed)
            recording = allanfit.recording_of(x, rate_hz=RATE_HZ, unit="rad/s")
            (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
            effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
            told = {**found["coefficients_after"], **effects.get(name, {})}
            row["named"] += not name or name in effects
            alone = set(effects) == {"low_pass", name} - {""}
            row["alone"] += alone
            if not alone:
                wrong.append(f"{kind} {seed}, {by}: {', '.join(effects) or 'nothing'}")
            for parameter, value in truth.items():
                if parameter in told:
                    low, high = told[parameter]["intervals"]["0.95"]
                    row[parameter] += bool(low <= value <= high)
        rows.append(row)
    print("| record | rightly named | and nothing but the filter | amplitude held | dwell | N | of")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()), f"| {options.records} |")
    print("\n".join(["", *wrong]))
    keep(options, "filtered", rows, otherwise=wrong)


if __name__ == "__main__":
    main()
