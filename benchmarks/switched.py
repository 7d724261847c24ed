"""Is a line that is switched on and off told from a resonance, and are others taken for one?

    python -m benchmarks.switched                 # 12 records of each kind, ten minutes
    python -m benchmarks.switched --records 50

White noise of one with a line of 30 to 300 times the power of an ordinate. It is on for two to six
times, with a phase that drifts or a new one each time; or it wanders as a Gauss-Markov process
does, or leaps from one frequency to another, or is no line but a resonance.
"""

from collections import Counter

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import lfilter

import allanfit

from ._records import keep, record_options

SAMPLES = 100_000
KINDS = ("switched, its phase drifts", "switched, new phases", "wanders", "leaps", "resonance")
# What the sentence says of one.
SWITCHED = ("on at some times", "strength changes")


def draw(kind: str, seed: int) -> np.ndarray:
    """A record in which a line comes and goes, or does not."""
    rng = np.random.default_rng((80, KINDS.index(kind), seed))
    middle, time = rng.uniform(0.05, 0.45), np.arange(SAMPLES)
    # Of the power of one ordinate, if it were at one frequency.
    amplitude = np.sqrt(4 * 10 ** rng.uniform(1.5, 2.5) / SAMPLES)
    # Where it is as broad as so many ordinates it is as clear with more power.
    ordinates = 10 ** rng.uniform(0.7, 2)
    broad = amplitude * (ordinates / 4) ** 0.25
    noise = rng.standard_normal(SAMPLES)
    if kind == "resonance":
        half = ordinates / SAMPLES / 2
        pole = np.exp(-2 * np.pi * half + 2j * np.pi * middle)
        drive = rng.standard_normal(2 * SAMPLES)
        rung = np.asarray(lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], drive))[SAMPLES:]
        return noise + broad / np.sqrt(2) * rung / rung.std()
    if kind == "wanders":
        frequency = middle + ordinates / SAMPLES * _wander(
            rng, SAMPLES * 10 ** -rng.uniform(0.7, 2)
        )
        return noise + broad * np.sin(2 * np.pi * np.cumsum(frequency))
    if kind == "leaps":
        ends = np.sort(rng.uniform(0, SAMPLES, rng.integers(3, 30)))
        levels = rng.standard_normal(ends.size + 1)[np.searchsorted(ends, time)]
        return noise + broad * np.sin(2 * np.pi * np.cumsum(middle + ordinates / SAMPLES * levels))
    edges = np.sort(rng.uniform(0, SAMPLES, 2 * rng.integers(2, 7)))
    place = np.searchsorted(edges, time)
    on = place % 2 == 1
    if kind == KINDS[0]:
        lasts = SAMPLES / rng.uniform(10, 60)
        phase = np.cumsum(rng.uniform(0.3, 1.5) / lasts * _wander(rng, lasts))
    else:
        phase = (2 * np.pi * rng.random(edges.size + 1))[place]
    amplitude /= np.sqrt(max(on.mean(), 0.05))
    return noise + amplitude * on * np.sin(2 * np.pi * middle * time + phase)


def _wander(rng: np.random.Generator, lasts: float) -> np.ndarray:
    """A Gauss-Markov process of one."""
    kept, before = np.exp(-1 / lasts), int(10 * lasts)
    drive = np.sqrt(1 - kept**2) * rng.standard_normal(SAMPLES + before)
    return np.asarray(lfilter([1.0], [1.0, -kept], drive))[before:]


def main(arguments=None):
    options = record_options(__doc__, 12, arguments)
    rows = []
    print("| what it is | switched, or its strength changes | what is said |\n|---|---|---|")
    for kind in KINDS:
        said, told = Counter(), 0
        for seed in track(range(options.records), kind, console=Console(stderr=True)):
            recording = allanfit.recording_of(draw(kind, seed), rate_hz=1.0, unit="rad/s")
            (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
            told += any(word in each["sentence"] for each in found["effects"] for word in SWITCHED)
            said[" and ".join(each["name"] for each in found["effects"]) or "nothing"] += 1
        words = ", ".join(f"{name} {count}" for name, count in said.most_common())
        print(f"| {kind} | {told} of {options.records} | {words} |", flush=True)
        rows.append({"kind": kind, "switched": told, "said": dict(said)})
    keep(options, "switched", rows)


if __name__ == "__main__":
    main()
