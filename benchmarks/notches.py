"""What is said of notches, which firmware puts about a motor's or a structure's frequency?

    python -m benchmarks.notches                 # 12 records a row, eight minutes
    python -m benchmarks.notches --records 50

White noise of N = 1 on a walk of K = 0.0001 to 0.001 a sample behind notches of two poles and two
zeros at 0.03 to 0.4 cycles a sample, with a quality factor of 1.5 to 60: one, or two, or one behind
a Butterworth filter of order 1 to 4, or one beside correlated noise of half a standard deviation,
or one that takes out but a part, of 20 to 80 % of the amplitude.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import butter, iirnotch, lfilter

import allanfit

from ._records import keep, record_options

SAMPLES, RATE_HZ = 120_000, 100.0
# Records begin when the filters have forgotten that they were empty.
BEFORE = 5_000
KINDS = ("one", "two", "behind a filter", "beside correlated noise", "a part")


def draw(kind: str, seed: int) -> tuple[np.ndarray, list[tuple[float, float]], set[str]]:
    """A record, its notches as (cycles a sample, quality factor), and what else it holds."""
    rng = np.random.default_rng((79, KINDS.index(kind), seed))
    samples, others = SAMPLES + BEFORE, set[str]()
    x, walk = rng.standard_normal(samples), 10 ** rng.uniform(-4, -3)
    x += walk * np.cumsum(rng.standard_normal(samples))
    if kind == "behind a filter":
        b, a = butter(int(rng.integers(1, 5)), 2 * 10 ** rng.uniform(-1, -0.5))
        x, others = lfilter(b, a, x), {"low_pass"}
    if kind == "beside correlated noise":
        keeps = np.exp(-1 / 10 ** rng.uniform(1, 3))
        shocks = 0.5 * np.sqrt(1 - keeps**2) * rng.standard_normal(samples)
        x, others = x + lfilter([1.0], [1.0, -keeps], shocks), {"gauss_markov"}
    notches = []
    for _ in range(2 if kind == "two" else 1):
        frequency, quality = 10 ** rng.uniform(-1.5, -0.4), 10 ** rng.uniform(0.18, 1.78)
        notches.append((frequency, quality))
        share = rng.uniform(0.2, 0.8) if kind == "a part" else 1.0
        x = (1 - share) * x + share * lfilter(*iirnotch(frequency, quality, fs=1.0), x)
    return np.asarray(x)[BEFORE:], notches, others


def main(arguments=None):
    options = record_options(__doc__, 12, arguments)
    rows, wrong = [], []
    for kind in KINDS:
        row = {"kind": kind, "told": 0, "alone": 0, "frequency": 0, "of notches": 0, "N": 0}
        worst = 0.0
        for seed in track(range(options.records), kind, console=Console(stderr=True)):
            x, notches, others = draw(kind, seed)
            recording = allanfit.recording_of(x, rate_hz=RATE_HZ, unit="rad/s")
            (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
            told = [e["parameters"] for e in found["effects"] if "notch" in e["parameters"]]
            names = {each["name"] for each in found["effects"]}
            row["told"] += len(told) == len(notches)
            alone = len(told) == len(notches) and names == {"bump", *others}
            row["alone"] += alone
            if not alone:
                what = ", ".join(f"{f:.3g} (quality {q:.2g})" for f, q in notches)
                wrong.append(f"{kind} {seed}, {what}: {', '.join(names) or 'nothing'}")
            for frequency, _ in notches:
                ends = [each["frequency"]["intervals"]["0.95"] for each in told]
                held = any(low <= RATE_HZ * frequency <= high for low, high in ends)
                row["frequency"] += held
                row["of notches"] += 1
            n = found["coefficients_after"]["N"]
            low, high = n["intervals"]["0.95"]
            row["N"] += bool(low <= RATE_HZ**-0.5 <= high)
            worst = max(worst, abs(float(np.log(n["value"] * RATE_HZ**0.5))))
        rows.append({**row, "of": options.records, "worst N": round(float(np.expm1(worst)), 3)})
    print("| record | notches told | and nothing else | frequency held | of | N held | of | N off")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()), "|")
    print("\n".join(["", *wrong]))
    keep(options, "notches", rows, otherwise=wrong)


if __name__ == "__main__":
    main()
