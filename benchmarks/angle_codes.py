"""Are N and Q right where an angle is rounded to codes wider than its move between samples?

    python -m benchmarks.angle_codes [--records 60]     # four minutes

Differences of an angle in codes 2, 3, 4.5, 6 and 8 times as wide as its white noise moves it in a
sample, as ring laser gyros and pulse-rebalanced accelerometers log them at high rates, by turns
without a mean rate, and with one of 0.03 and 0.1 codes a sample; B and K are there as well. Printed
is N over the truth with the errors of the codes as they are, and taken for white (the same samples
with a third of a code added, which makes them no codes); how often 95 % intervals hold N and Q;
and of how many records `explain` says that something is left out.
"""

import numpy as np
from rich.progress import track
from scipy.signal import lfilter

import allanfit

from ._records import keep, record_options

SAMPLES, RATE_HZ = 100_000, 100.0
N, B, K = 2e-3, 3e-4, 2e-5
WIDTHS = (2.0, 3.0, 4.5, 6.0, 8.0)
RATES = (0.0, 0.03, 0.1)


def draw(rng: np.random.Generator, width: float, rate: float) -> np.ndarray:
    """Rates [deg/s] of an angle in codes of this width, in standard deviations of its moves."""
    code = width * N / np.sqrt(RATE_HZ)
    white = N * np.sqrt(RATE_HZ) * rng.standard_normal(SAMPLES + 1)
    walk = K / np.sqrt(RATE_HZ) * np.cumsum(rng.standard_normal(SAMPLES + 1))
    flicker = np.zeros(SAMPLES + 1)
    # First-order processes of one variance, evenly spaced: B^2/(2 pi f) to a few per cent.
    times = np.geomspace(2, 4 * SAMPLES, 13)
    each = B * np.sqrt(np.log(times[1] / times[0]) / (2 * np.pi))
    for kept in np.exp(-1 / times):
        drive = each * np.sqrt(1 - kept**2) * rng.standard_normal(SAMPLES + 1)
        flicker += lfilter([1], [1, -kept], drive)
    moves = (white + walk + flicker) / RATE_HZ + rate * code
    return np.diff(np.round(np.cumsum(moves) / code + rng.random())) * code * RATE_HZ


def main(arguments=None):
    options = record_options(__doc__, 60, arguments)
    rows = []
    for index in track(range(options.records)):
        width, rate = WIDTHS[index % len(WIDTHS)], RATES[index // len(WIDTHS) % len(RATES)]
        values = draw(np.random.default_rng((17, index)), width, rate)
        code = width * N / np.sqrt(RATE_HZ)
        found = allanfit.fit(values, RATE_HZ)
        white = allanfit.fit(values + code * RATE_HZ / 3, RATE_HZ)
        recording = allanfit.recording_of(values, rate_hz=RATE_HZ, unit="deg/s")
        (told,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
        truth = {"N": N, "Q": code / np.sqrt(12)}
        rows.append(
            {
                "width": width,
                "rate": rate,
                "N_over_truth": float(found.coefficients["N"]) / N,
                "N_over_truth_as_white": float(white.coefficients["N"]) / N,
                "effects": [each["name"] for each in told["effects"]],
                "holds": {
                    symbol: bool(found.intervals[symbol][0] <= value <= found.intervals[symbol][1])
                    for symbol, value in truth.items()
                },
            }
        )
    print("| codes over noise | N over truth, as white | N over truth | N held | Q held | alarms |")
    print("|---" * 6 + "|")
    for width in WIDTHS:
        some = [row for row in rows if row["width"] == width]
        if not some:
            continue
        before, after = (
            f"{np.mean(ratios):.3f} ± {np.std(ratios):.3f}"
            for name in ("N_over_truth_as_white", "N_over_truth")
            for ratios in [[row[name] for row in some]]
        )
        held = " | ".join(
            f"{sum(row['holds'][symbol] for row in some)} of {len(some)}" for symbol in "NQ"
        )
        alarms = sum(bool(row["effects"]) for row in some)
        print(f"| {width:g} | {before} | {after} | {held} | {alarms} |")
    keep(options, "angle_codes", rows)


if __name__ == "__main__":
    main()
