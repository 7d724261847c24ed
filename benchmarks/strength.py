"""Is a strength that changes told, and how often by chance? Simulated noise made white.

    python -m benchmarks.strength [--records 1000] [--seed 1]

Noise that is as strong at all times says how true the chance is, also where whitening leaves a
correlation or values are not normal. Loud times are those of `benchmarks.concealed`, two to five
stretches, or one tenth of the record, or it is louder and louder, with lambda of twelve to fifty:
what the squares say of them, half of the samples times the variance of the relative power. The
chance by windows, by levels that last, and by either, as `explain` takes it; at last windows alone,
of few and of many degrees of freedom, of which levels that last have to make as little.
"""

import argparse
from functools import partial

import numpy as np
from jaxtyping import Float
from rich.progress import track

from allanfit.explain._investigate import ALARM
from allanfit.explain.strength._levels import levels_that_last
from allanfit.explain.strength._modulation import either, lasting_levels, uneven

from .concealed._slow import inside, stretches

SAMPLES = 120_000
LEVELS = (0.05, 0.01, ALARM)
WINDOWS = ((64, 32), (64, 1000), (128, 100), (256, 32), (256, 1000))
STRENGTHS = (12.0, 25.0, 50.0)


def normal(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    return rng.standard_normal(SAMPLES)


def averaged(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    """Each sample with its neighbours: about as alike as a filter's zeros leave them."""
    noise = rng.standard_normal(SAMPLES + 2)
    return (noise[2:] + noise[1:-1] + noise[:-2]) / 3**0.5


def laplace(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    return rng.laplace(size=SAMPLES) / 2**0.5


def loud_stretches(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    return inside(np.arange(SAMPLES) + 0.5, stretches(rng, SAMPLES)).astype(float)


def loud_tenth(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    begin = rng.uniform(0.0, 0.9) * SAMPLES
    return inside(np.arange(SAMPLES) + 0.5, ((begin, begin + SAMPLES / 10),)).astype(float)


def louder_and_louder(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    return np.linspace(*rng.permutation([0.0, 1.0]), SAMPLES)


def changing(course, strength: float, rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    """Noise whose power goes with such a course."""
    course = course(rng)
    excess = np.sqrt(2 * strength / SAMPLES / np.var(course))
    noise = rng.standard_normal(SAMPLES) * np.sqrt(1 + excess * course)
    return noise / noise.std()


def chances(white: Float[np.ndarray, " samples"]) -> tuple[float, float, float]:
    """By windows, by levels that last, and by either."""
    windows, _, variance = uneven(white)
    found, _ = lasting_levels(white, variance)
    assert found is not None
    return windows, found.p_value, either(windows, found)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(arguments)
    kinds = {"normal": normal, "averaged over three": averaged, "Laplace": laplace}
    courses = {
        "two to five stretches": loud_stretches,
        "a tenth": loud_tenth,
        "louder and louder": louder_and_louder,
    }
    for name, course in courses.items():
        for strength in STRENGTHS:
            kinds[f"{name}, lambda {strength:g}"] = partial(changing, course, strength)
    rows = []
    for place, (name, made) in enumerate(kinds.items()):
        told = [
            chances(made(np.random.default_rng((asked.seed, place, index))))
            for index in track(range(asked.records), name)
        ]
        rows.append(_row(name, np.array(told)))
    for windows, freedom in WINDOWS:
        rng = np.random.default_rng((asked.seed, windows, freedom))
        told = [
            levels_that_last(rng.chisquare(freedom, windows) / freedom, float(freedom)).p_value
            for _ in track(range(10 * asked.records), f"{windows} windows of {freedom}")
        ]
        rows.append(_row(f"{windows} windows of {freedom}, ten times as many", np.array(told)))
    print(f"{asked.records} records of {SAMPLES:,} samples, seed {asked.seed}\n")
    ways = [f"{way} < {level:g}" for way in ("windows", "levels", "either") for level in LEVELS]
    print("| noise | " + " | ".join(ways) + " |")
    print("|---" * (1 + len(ways)) + "|")
    print("\n".join(rows))


def _row(name: str, told: Float[np.ndarray, "..."]) -> str:
    """The shares of chances below each level, by windows, levels and either, or by levels alone."""
    if told.ndim == 1:
        told = np.stack([np.full_like(told, np.nan), told, np.full_like(told, np.nan)], axis=1)
    shares = [
        "" if np.isnan(way[0]) else f"{np.mean(way < level):.4f}"
        for way in told.T
        for level in LEVELS
    ]
    return f"| {name} | " + " | ".join(shares) + " |"


if __name__ == "__main__":
    main()
