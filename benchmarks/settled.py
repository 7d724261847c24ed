"""Have the posteriors behind the intervals of `explain` settled?

    python -m benchmarks.settled                 # 4 records a row, ten minutes
    python -m benchmarks.settled --records 12

White noise of N = 1 on a walk of K = 0.001 a sample, with a Gauss-Markov process, a resonance or
noise that falls as f^-0.5 beside it, or behind a Butterworth filter or two exponential averages.
What `explain` finds is drawn with three seeds, and once with turns of emcee that go on for four
times as long. In standard deviations of the posterior, of both ends of 95 % intervals of all
coefficients and parameters: how far seeds are apart, median and largest, and how far the mean of
them is from the long run.
"""

import time
from unittest.mock import patch

import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.signal import butter, lfilter

from allanfit.explain._investigate import investigate
from allanfit.explain.spectrum import _population
from allanfit.explain.spectrum._posterior import Draws, sample_structure
from allanfit.explain.spectrum._structure import TERMS, active

from ._records import keep, record_options

SAMPLES, BEFORE = 60_000, 2_000
KINDS = ("Gauss-Markov", "resonance", "power law", "Butterworth", "two averages")
SEEDS, LONG = (0, 1, 2), {"_TURNS": 6, "_SETTLED": 0.0}
ENDS = (0.025, 0.975)


def record(kind: str, seed: int) -> np.ndarray:
    """Values of one channel, of a sampling interval of one."""
    rng = np.random.default_rng((97, KINDS.index(kind), seed))
    white, more = rng.standard_normal((2, SAMPLES + BEFORE))
    x = white + 1e-3 * np.cumsum(rng.standard_normal(white.size))
    if kind == "Gauss-Markov":
        kept = np.exp(-1 / 10 ** rng.uniform(1, 2.5))
        x += 0.3 * lfilter([np.sqrt(1 - kept**2)], [1, -kept], more)
    elif kind == "resonance":
        turn, damped = 2 * np.pi * rng.uniform(0.02, 0.3), 10 ** rng.uniform(-2.5, -1.5)
        ringing = lfilter([1], [1, -2 * (1 - damped) * np.cos(turn), (1 - damped) ** 2], more)
        x += 0.3 * ringing / ringing.std()
    elif kind == "power law":
        shape = np.fft.rfftfreq(x.size)
        shape[1:] **= -0.25
        x += np.fft.irfft(0.5 * shape * np.fft.rfft(more), x.size)
    elif kind == "Butterworth":
        x = lfilter(*butter(int(rng.integers(1, 4)), rng.uniform(0.1, 0.6)), x)
    else:
        kept = np.exp(-2 * np.pi * rng.uniform(0.03, 0.2))
        x = lfilter([(1 - kept) ** 2], np.convolve([1, -kept], [1, -kept]), x)
    return np.asarray(x)[BEFORE:]


def columns(draws: Draws, moving: np.ndarray) -> np.ndarray:
    """Coefficients, and cut-off frequency and order of a filter or the parameters of a noise."""
    sizes = np.sqrt(draws.power[:, moving[:TERMS]])
    if draws.filtering is not None:
        return np.hstack([sizes, np.log(np.maximum(draws.filtering[:, :2], 1e-9))])
    return np.hstack([sizes, draws.theta[:, TERMS:][:, moving[TERMS:]]])


def apart(kind: str, seed: int) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Between seeds and from the long run, of each column the larger; and seconds of one run.

    None where nothing is found.
    """
    x = record(kind, seed)
    power = np.array([0.0, np.var(x) / 2, 0.0, 0.0])
    state = investigate(x, ((0, x.size),), "point", power)
    model, data = state.model, state.data
    if not model.kinds.names:
        return None
    moving = np.asarray(active(model.kinds, data.terms))

    def ends(of_seed: int) -> tuple[np.ndarray, np.ndarray]:
        found = columns(sample_structure(model, data, of_seed), moving)
        return np.quantile(found, ENDS, axis=0), found.std(axis=0)

    ends(99)
    begin = time.perf_counter()
    short = np.array([ends(each)[0] for each in SEEDS])
    seconds = (time.perf_counter() - begin) / len(SEEDS)
    with patch.multiple(_population, **LONG):
        long, deviation = ends(100)
    # What all draws agree on, as an order of two, has none.
    deviation = np.where(deviation > 0, deviation, np.inf)
    between = short.std(axis=0, ddof=1).max(axis=0) / deviation
    return between, (np.abs(short.mean(axis=0) - long) / deviation).max(axis=0), seconds


def main(arguments=None):
    options = record_options(__doc__, 4, arguments)
    rows = []
    for kind in KINDS:
        found = [
            apart(kind, seed)
            for seed in track(range(options.records), kind, console=Console(stderr=True))
        ]
        told = [each for each in found if each is not None]
        between, from_long = (np.concatenate([each[at] for each in told]) for at in (0, 1))
        rows.append(
            {
                "kind": kind,
                "found": len(told),
                "between seeds": round(float(np.median(between)), 3),
                "at most": round(float(between.max()), 2),
                "from the long run": round(float(np.median(from_long)), 3),
                "at most from it": round(float(from_long.max()), 2),
                "seconds": round(float(np.median([each[2] for each in told])), 1),
                "of": options.records,
            }
        )
    print("| " + " | ".join(rows[0]) + " |\n" + "|---" * len(rows[0]) + "|")
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()) + " |")
    keep(options, "settled", rows)


if __name__ == "__main__":
    main()
