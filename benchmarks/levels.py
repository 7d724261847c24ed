"""Are weak changes of the strength of noise found, and by chance as rarely as stated?

    python -m benchmarks.levels [--records 4000]

First the log of the mean likelihood ratio of two levels in windows of nothing but white noise: how
often its stated chance is below .1, .01 and .001, by how many windows there are and how many
degrees of freedom each has. Then white noise that is louder in two to five stretches, in one tenth
of the record, or more and more, so that lambda is 12, 25 or 50: how often it is found at the alarm
of `explain` by windows, by levels that last, and by either as explain does.
"""

from collections.abc import Callable, Sequence

import numpy as np
from rich.progress import track

from allanfit.explain._investigate import ALARM
from allanfit.explain.strength._lasting import WAYS
from allanfit.explain.strength._levels import levels_that_last
from allanfit.explain.strength._modulation import modulation, uneven

from ._records import keep, record_options

WINDOWS = ((64, 32), (64, 1000), (128, 100), (256, 32), (256, 1000))
CHANCES = (0.1, 0.01, 0.001)
SAMPLES, LAMBDAS = 1 << 17, (12, 25, 50)
# Records of noise that changes, for each that does not.
_FEWER = 20

Draw = Callable[[np.random.Generator], np.ndarray]


def stretches(rng: np.random.Generator) -> np.ndarray:
    """Two to five, at random times."""
    edges = np.sort(rng.uniform(size=2 * rng.integers(2, 6)))
    return np.searchsorted(edges, np.arange(SAMPLES) / SAMPLES) % 2.0


def tenth(rng: np.random.Generator) -> np.ndarray:
    """One of a tenth of the record."""
    begin = rng.uniform(0, 0.9)
    time = np.arange(SAMPLES) / SAMPLES
    return ((time >= begin) & (time < begin + 0.1)).astype(float)


def rising(rng: np.random.Generator) -> np.ndarray:
    """More and more, or less and less."""
    return np.linspace(*rng.permutation([0.0, 1.0]), SAMPLES)


def main(arguments: Sequence[str] | None = None) -> None:
    options = record_options(__doc__, 4000, arguments)
    rng = np.random.default_rng(1)
    null = []
    print("white noise: how many times the stated chance it is as odd, at", *CHANCES)
    for windows, freedom in WINDOWS:
        power = rng.chisquare(freedom, (options.records, windows)) / freedom
        chances = [levels_that_last(each, float(freedom)).p_value for each in track(power)]
        times = [float(np.mean(np.array(chances) < at) / at) for at in CHANCES]
        null.append({"windows": windows, "freedom": freedom, "times": times})
        print(f"{windows} windows of {freedom}: " + ", ".join(f"{each:.2f}" for each in times))
    found = []
    draws: tuple[Draw, ...] = (stretches, tenth, rising)
    for draw in draws:
        for size in LAMBDAS:
            row = _found(rng, draw, size, max(options.records // _FEWER, 1))
            found.append(row)
            print(
                f"{row['shape']}, lambda {size}: by windows {row['windows']:.2f}, "
                f"either {row['either']:.2f} of {row['of']}"
            )
    keep(options, "levels", null, found=found)


def _found(rng: np.random.Generator, draw: Draw, size: float, count: int) -> dict:
    """The shares that are found, by windows alone and by either."""
    windows, either = 0, 0
    for _ in track(range(count)):
        course = draw(rng)
        # Of n samples each tells (change of the log of the variance)^2 / 4 nats, and lambda is
        # twice that.
        excess = np.sqrt(2 * size / (SAMPLES * np.var(course)))
        white = rng.standard_normal(SAMPLES) * np.sqrt(1 + excess * course)
        white /= white.std()
        windows += uneven(white)[0] < ALARM
        told = modulation(white, 0)
        either += told.p_value < WAYS * ALARM and bool(told.loud.any())
    return {
        "shape": draw.__name__,
        "lambda": size,
        "windows": windows / count,
        "either": either / count,
        "of": count,
    }


if __name__ == "__main__":
    main()
