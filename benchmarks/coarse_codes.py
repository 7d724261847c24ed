"""What is said of coarse codes behind a filter, the everyday output of a MEMS sensor?

    python -m benchmarks.coarse_codes [--recordings 24] [--seed 1]

White noise and a faint random walk, through SciPy's Butterworth filters of order 1 to 4: two of
three in the processor, at the rate of the log, the others in front of it, at eight times that.
Codes are 0.3 to 2.2 standard deviations of what passes. Printed is what is named beside filter and
rounding, and how often intervals hold the cut-off, the order and N. About seven seconds each.
"""

import argparse

import jax
import numpy as np
from rich.progress import track
from scipy.signal import butter, freqz, lfilter

import allanfit
from allanfit.explain import explain_recording

RATE, SAMPLES, FINER, LEAD = 100.0, 80_000, 8, 500


def draw(rng: np.random.Generator, index: int):
    """Samples [deg/s] and the truth: place, order, cut-off [Hz], codes over noise and N."""
    order = int(rng.integers(1, 5))
    cutoff = RATE * float(np.exp(rng.uniform(np.log(0.06), np.log(0.35))))
    codes = float(rng.uniform(0.3, 2.2))
    finer = FINER if index % 3 == 2 else 1
    taps = butter(order, cutoff, fs=finer * RATE)
    white = np.sqrt(finer) * rng.standard_normal((SAMPLES + LEAD) * finer)
    values = lfilter(*taps, white)[LEAD * finer :: finer]
    # What folds onto zero frequency is seen as N.
    images = 2 * np.pi * np.arange(finer) / finer + 1e-9
    folded = np.sum(np.abs(freqz(*taps, worN=images)[1]) ** 2)
    values = values + 1e-4 * np.cumsum(rng.standard_normal(SAMPLES)) + rng.uniform(-1, 1)
    width = codes * values.std()
    truth = {
        "where": "processor" if finer == 1 else "front end",
        "cutoff_frequency": cutoff,
        "order": order,
        "codes": codes,
        "N": float(np.sqrt(folded / RATE)),
    }
    return np.round(values / width) * width, truth


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--recordings", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    held = {"cutoff_frequency": [], "order": [], "N": []}
    alone = []
    print("| filter in | order | cut-off | codes | beside them | order told | N over truth |")
    print("|---" * 7 + "|")
    for index in track(range(asked.recordings)):
        values, truth = draw(np.random.default_rng((asked.seed, index)), index)
        recording = allanfit.recording_of(
            {"gyro_x": values}, rate_hz=RATE, units={"gyro_x": "deg/s"}
        )
        (found,) = explain_recording(recording, posterior=False).to_dict()["channels"]
        effects = {each["name"]: each["parameters"] for each in found["effects"]}
        others = [name for name in effects if name not in ("low_pass", "output_rounding")]
        alone.append(not others and "low_pass" in effects)
        entries = {"N": found["coefficients_after"]["N"], **effects.get("low_pass", {})}
        for name, hits in held.items():
            low, high = entries.get(name, {}).get("intervals", {}).get("0.95", (np.inf, -np.inf))
            hits.append(low <= truth[name] <= high)
        told = entries.get("order", {"value": np.nan})["value"]
        print(
            f"| {truth['where']} | {truth['order']} | {truth['cutoff_frequency']:.1f} Hz "
            f"| {truth['codes']:.2f} | {', '.join(others)} | {told:.2f} "
            f"| {entries['N']['value'] / truth['N']:.3f}{'' if held['N'][-1] else ' (missed)'} |"
        )
    print(f"\nfilter and rounding, nothing else: {sum(alone)} of {len(alone)}")
    for name, hits in held.items():
        print(f"95 % intervals of {name} hold: {sum(hits)} of {len(hits)}")


if __name__ == "__main__":
    main()
