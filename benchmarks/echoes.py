"""What is said of echoes: combs of a filter, buffers that leak, a signal that comes back late?

    python -m benchmarks.echoes                 # 12 records a row, three minutes
    python -m benchmarks.echoes --records 50

White noise of N = 1 on a walk of K = 0.0001 to 0.001 a sample. To each sample 2 to 30 % of the
noise 3 to 80 samples before is added, or taken off: of what comes in, or of what goes out, which
comes back again and again; or of that and correlated noise of half a standard deviation.
"""

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import lfilter

import allanfit

from ._records import keep, record_options

SAMPLES, RATE_HZ, BEFORE = 120_000, 100.0, 5_000
KINDS = ("once", "again and again", "beside correlated noise")


def draw(kind: str, seed: int) -> tuple[np.ndarray, int, float]:
    """A record, after how many samples the echo comes and what part it is."""
    rng = np.random.default_rng((97, KINDS.index(kind), seed))
    lag = int(np.exp(rng.uniform(np.log(3), np.log(80))))
    part = float(np.exp(rng.uniform(np.log(0.02), np.log(0.3))) * rng.choice([-1, 1]))
    taps = np.zeros(lag + 1)
    taps[[0, -1]] = 1.0, -part if kind == "again and again" else part
    x = rng.standard_normal(SAMPLES + BEFORE)
    if kind == "beside correlated noise":
        keeps = np.exp(-1 / 10 ** rng.uniform(1, 3))
        shocks = 0.5 * np.sqrt(1 - keeps**2) * rng.standard_normal(x.size)
        x = x + lfilter([1.0], [1.0, -keeps], shocks)
    forward, back = ([1.0], taps) if kind == "again and again" else (taps, [1.0])
    x = np.asarray(lfilter(forward, back, x))
    x = x + 10 ** rng.uniform(-4, -3) * np.cumsum(rng.standard_normal(x.size))
    return x[BEFORE:], lag, part


def main(arguments=None):
    options = record_options(__doc__, 12, arguments)
    rows, wrong = [], []
    for kind in KINDS:
        others = {"gauss_markov"} if kind == "beside correlated noise" else set()
        row = {"kind": kind, "of": options.records}
        row |= dict.fromkeys(("told", "alone", "lag", "part held", "N held"), 0)
        for seed in track(range(options.records), kind, console=Console(stderr=True)):
            x, lag, part = draw(kind, seed)
            recording = allanfit.recording_of(x, rate_hz=RATE_HZ, unit="rad/s")
            (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
            told = [e["parameters"] for e in found["effects"] if "echo" in e["parameters"]]
            names = {each["name"] for each in found["effects"]}
            row["told"] += len(told) == 1
            alone = len(told) == 1 and names == {"bump", *others}
            row["alone"] += alone
            if not alone:
                said = ", ".join(names) or "nothing"
                wrong.append(f"{kind} {seed}, {100 * part:+.2g} % of {lag} samples before: {said}")
            for each in told:
                row["lag"] += abs(RATE_HZ / each["frequency"]["value"] - lag) < 0.5
                low, high = each["height"]["intervals"]["0.95"]
                row["part held"] += bool(low <= part <= high)
            low, high = found["coefficients_after"]["N"]["intervals"]["0.95"]
            row["N held"] += bool(low <= RATE_HZ**-0.5 <= high)
        rows.append(row)
    print("| echo | of | told | and nothing else | lag right | part held | N held |")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()), "|")
    print("\n".join(["", *wrong]))
    keep(options, "echoes", rows, otherwise=wrong)


if __name__ == "__main__":
    main()
