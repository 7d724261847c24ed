"""From which strength on are pulses found that no name of the catalogue fits?

    python -m benchmarks.pulses                  # half an hour
    python -m benchmarks.pulses --records 40

First pulses of a sample each 20, 100 or 500 samples in white noise, 10 to 25 standard deviations of
the noise all together: how often `strongest_comb` finds them with a chance below .001. Then pulses
that jump up and die away in 0.5 to 4 s, at random times some 15 s apart and 0.6 to 4 standard
deviations high; such whose heights are exponential, of one sign and of both; and telegraphs of such
heights that last as long: what `explain` says of them.
"""

from collections import Counter

import numpy as np
from rich.progress import track
from scipy.signal import lfilter

import allanfit
from allanfit.explain.lines._comb import strongest_comb

from ._records import keep, record_options

SAMPLES, RATE_HZ, EVERY_S = 160_000, 100.0, 15.0
PULSES = ("jumps one way", "pulses of differing heights")
PERIODS, STRENGTHS = (20, 100, 500), (10, 15, 20, 25)


def repeated(rng: np.random.Generator, period: int, strength: float) -> np.ndarray:
    values = rng.standard_normal(SAMPLES)
    values[rng.integers(period) :: period] += strength / np.sqrt(SAMPLES / period)
    return values


def dying(rng: np.random.Generator) -> np.ndarray:
    """Pulses of one height at random times, each a jump that dies away."""
    height, lasts = 10 ** rng.uniform(-0.22, 0.6), RATE_HZ * 10 ** rng.uniform(-0.3, 0.6)
    starts = rng.random(SAMPLES) < 1 / (EVERY_S * RATE_HZ)
    return height * np.asarray(lfilter([1], [1, -np.exp(-1 / lasts)], starts))


def differing(rng: np.random.Generator) -> np.ndarray:
    """The same, but of exponential heights."""
    return _of_exponential_heights(rng, rng.exponential(1, SAMPLES))


def popping(rng: np.random.Generator) -> np.ndarray:
    """And of both signs."""
    return _of_exponential_heights(rng, rng.laplace(0, 1, SAMPLES))


def _of_exponential_heights(rng: np.random.Generator, heights: np.ndarray) -> np.ndarray:
    height, lasts = 10 ** rng.uniform(-0.22, 0.6), RATE_HZ * 10 ** rng.uniform(-0.3, 0.6)
    starts = rng.random(SAMPLES) < 1 / (EVERY_S * RATE_HZ)
    return height * np.asarray(lfilter([1], [1, -np.exp(-1 / lasts)], starts * heights))


def switching(rng: np.random.Generator) -> np.ndarray:
    """Two levels, of which the upper lasts as long as such pulses do."""
    height, lasts = 10 ** rng.uniform(-0.22, 0.6), RATE_HZ * 10 ** rng.uniform(-0.3, 0.6)
    dwells = rng.exponential(np.tile([EVERY_S * RATE_HZ, lasts], SAMPLES // 100)) + 1
    return height * (np.searchsorted(np.cumsum(dwells), np.arange(SAMPLES), "right") % 2)


def named(values: np.ndarray) -> str:
    """What `explain` names, with `PULSES` as they are told."""
    recording = allanfit.recording_of(values, rate_hz=RATE_HZ, unit="deg/s")
    (told,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    return ", ".join(
        next((each for each in PULSES if each in effect["sentence"]), effect["name"])
        for effect in told["effects"]
    )


def main(arguments=None):
    options = record_options(__doc__, 20, arguments)
    rows = []
    print("| samples a period | " + " | ".join(f"{each} sigma" for each in STRENGTHS) + " | of |")
    print("|---" * (len(STRENGTHS) + 2) + "|")
    for period in PERIODS:
        found = []
        for strength in STRENGTHS:
            draws = [
                np.random.default_rng((5, period, strength, i)) for i in range(options.records)
            ]
            combs = [strongest_comb(repeated(rng, period, strength)) for rng in draws]
            found.append(int(sum(comb is not None and comb.log_p < np.log(1e-3) for comb in combs)))
        print(f"| {period} | " + " | ".join(map(str, found)) + f" | {options.records} |")
        rows.append({"period": period, "found": found})
    print()
    for number, make in enumerate((switching, dying, differing, popping)):
        said = Counter()
        for i in track(range(options.records), make.__name__):
            rng = np.random.default_rng((6, number, i))
            values = make(rng) + 1e-3 * np.cumsum(rng.standard_normal(SAMPLES))
            said[named(values + rng.standard_normal(SAMPLES))] += 1
        print(
            f"{make.__name__}: " + "; ".join(f"{what or 'nothing'} {n}" for what, n in said.items())
        )
        pulses = sum(n for what, n in said.items() if any(each in what for each in PULSES))
        telegraphs = sum(n for what, n in said.items() if "random_telegraph" in what)
        print(f"  {pulses} told as pulses, {telegraphs} as telegraphs, of {options.records}")
        rows.append({"kind": make.__name__, "said": dict(said)})
    keep(options, "pulses", rows)


if __name__ == "__main__":
    main()
