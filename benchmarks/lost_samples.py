"""Samples lost on the way without a time stamp, beside a line: what tells them, and what does not.

    python -m benchmarks.lost_samples                 # 12 records a row, a quarter of an hour
    python -m benchmarks.lost_samples --records 50

White noise of one on a weak walk, with a line of 0.15 to 1 at any frequency. Of each sample it is
drawn whether it is lost, one in 100 to one in 30,000. The other rows lose none: a line whose phase
diffuses until its spectrum is as wide, one whose frequency wanders, a resonance, and a sweep.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import lfilter

import allanfit

from ._records import keep, record_options

SAMPLES, RATE_HZ = 120_000, 100.0
KINDS = ("losses", "losses of mains", "diffusing phase", "wandering line", "resonance", "sweep")
# A wandering frequency lasts for so long [samples]; that of mains has such a deviation [1/sample].
LASTS, MAINS = 3000.0, 2e-5


def wander(rng: np.random.Generator, samples: int) -> np.ndarray:
    """A process of deviation one that reverts to zero."""
    decay = np.exp(-1 / LASTS)
    begun = np.sqrt(1 - decay**2) * rng.standard_normal(samples)
    begun[0] = rng.standard_normal()
    return np.asarray(lfilter([1.0], [1.0, -decay], begun))


def draw(kind: str, seed: int) -> tuple[np.ndarray, dict[str, float]]:
    """A record, the share that was lost, and the line as it would be without losses [Hz]."""
    rng = np.random.default_rng((91, KINDS.index(kind), seed))
    share, frequency = 10 ** rng.uniform(-4.5, -2.0), rng.uniform(0.03, 0.47)
    amplitude = 10 ** rng.uniform(-0.82, 0.0)
    samples = round(SAMPLES / (1 - 2 * share))
    turns = frequency * np.arange(samples) + rng.uniform()
    # Half the width of the spectrum that losses make of a sinusoid (a Lorentz curve).
    half = share * (1 - np.cos(2 * np.pi * frequency)) / (2 * np.pi)
    kept = np.ones(samples, bool)
    if kind.startswith("losses"):
        kept = rng.random(samples) >= share
    if kind == "losses of mains":
        turns += np.cumsum(MAINS * wander(rng, samples))
    elif kind == "diffusing phase":
        turns += np.cumsum(np.sqrt(half / np.pi) * rng.standard_normal(samples))
    elif kind == "wandering line":
        turns += np.cumsum(half * wander(rng, samples))
    elif kind == "sweep":
        turns += 4 * half * (np.arange(samples) ** 2 / (2 * samples))
    line = amplitude * np.sin(2 * np.pi * turns)
    if kind == "resonance":
        decay = np.exp(-2 * np.pi * half)
        poles = [1.0, -2 * decay * np.cos(2 * np.pi * frequency), decay**2]
        line = np.asarray(lfilter([1.0], poles, rng.standard_normal(samples)))
        line *= amplitude / np.sqrt(2) / line.std()
    x = rng.standard_normal(samples) + 1e-3 * np.cumsum(rng.standard_normal(samples)) + line
    x = x[kept][:SAMPLES]
    lost = np.flatnonzero(kept)[SAMPLES - 1] + 1 - SAMPLES
    told = {"fraction": float(lost / (SAMPLES + lost)), "frequency": frequency * RATE_HZ}
    return x, {**told, "amplitude": amplitude, "N": RATE_HZ**-0.5}


def main(arguments=None):
    options = record_options(__doc__, 12, arguments)
    rows, drawn = [], []
    for kind in KINDS:
        row = {"kind": kind, "losses": 0, "sinusoid": 0}
        row |= dict.fromkeys(("fraction", "frequency", "amplitude", "N"), 0)
        for seed in track(range(options.records), kind, console=Console(stderr=True)):
            x, truth = draw(kind, seed)
            recording = allanfit.recording_of(x, rate_hz=RATE_HZ, unit="rad/s")
            (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
            effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
            row["losses"] += "dropped_samples" in effects
            row["sinusoid"] += "sinusoid" in effects
            told = dict(found["coefficients_after"])
            for name in ("dropped_samples", "sinusoid"):
                told |= effects.get(name, {})
            for name, value in truth.items():
                if name in told:
                    low, high = told[name]["intervals"]["0.95"]
                    row[name] += low <= value <= high
            drawn.append({"kind": kind, **truth, "named": list(effects)})
        rows.append(row)
    print("| record | losses named | a sinusoid | fraction held | frequency | amplitude | N | of |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()), f"| {options.records} |")
    keep(options, "lost_samples", rows, drawn=drawn)


if __name__ == "__main__":
    main()
