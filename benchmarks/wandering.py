"""How well is a line known whose frequency wanders: amplitude, mean frequency and width?

    python -m benchmarks.wandering                 # 24 records, two minutes
    python -m benchmarks.wandering --records 100

White noise of one on a walk, with a sinusoid of amplitude 0.13 to 2 whose frequency is a
Gauss-Markov process of a standard deviation of 0.0002 to 0.002 cycles a sample that forgets within
a third to a hundredth of the record. Mean and standard deviation of the frequency are those of the
process, and those that it had in the record.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import lfilter

import allanfit

from ._records import keep, record_options

SAMPLES = 100_000
TOLD = {
    "amplitude": "amplitude",
    "frequency": "frequency",
    "width": "width",
    "mean in the record": "frequency",
    "spread in the record": "width",
}


def draw(seed: int) -> tuple[np.ndarray, dict[str, float]]:
    """A record and what is true of its line, in samples."""
    rng = np.random.default_rng((79, seed))
    width, middle = 10 ** rng.uniform(-3.7, -2.7), rng.uniform(0.05, 0.4)
    lasts = SAMPLES * 10 ** rng.uniform(-2, -0.5)
    amplitude = float(10 ** rng.uniform(-0.9, 0.3))
    kept, before = np.exp(-1 / lasts), int(10 * lasts)
    drive = np.sqrt(1 - kept**2) * rng.standard_normal(SAMPLES + before)
    frequency = middle + width * np.asarray(lfilter([1.0], [1.0, -kept], drive))[before:]
    x = rng.standard_normal(SAMPLES) + 3e-4 * np.cumsum(rng.standard_normal(SAMPLES))
    x += amplitude * np.sin(2 * np.pi * np.cumsum(frequency))
    truth = (amplitude, middle, width, float(frequency.mean()), float(frequency.std()))
    return x, dict(zip(TOLD, truth, strict=True))


def main(arguments=None):
    options = record_options(__doc__, 24, arguments)
    held = dict.fromkeys(TOLD, 0)
    errors: dict[str, list[float]] = {name: [] for name in TOLD}
    named = alone = 0
    for seed in track(range(options.records), "lines", console=Console(stderr=True)):
        x, truth = draw(seed)
        recording = allanfit.recording_of(x, rate_hz=1.0, unit="rad/s")
        (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
        effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
        alone += list(effects) == ["drifting_line"]
        if "drifting_line" not in effects:
            continue
        named += 1
        for name, parameter in TOLD.items():
            told = effects["drifting_line"][parameter]
            low, high = told["intervals"]["0.95"]
            held[name] += bool(low <= truth[name] <= high)
            # By how much of the width the frequency is off, and of themselves the others.
            scale = truth["width"] if parameter == "frequency" else truth[name]
            errors[name].append((told["value"] - truth[name]) / scale)
    print(f"Named a line that wanders: {named} of {options.records}, and nothing else: {alone}.\n")
    print("| | held by 95 % | mean error | rms error |")
    print("|---|---|---|---|")
    rows = []
    for name, each in errors.items():
        mean, rms = float(np.mean(each)), float(np.sqrt(np.mean(np.square(each))))
        rows.append({"what": name, "held": held[name], "mean": mean, "rms": rms})
        print(f"| {name} | {held[name]} of {named} | {mean:+.3f} | {rms:.3f} |")
    keep(options, "wandering", rows, named=named, alone=alone)


if __name__ == "__main__":
    main()
