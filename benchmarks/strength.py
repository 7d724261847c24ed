"""Is a strength that changes told, and how often by chance? Simulated noise made white.

    python -m benchmarks.strength [--records 1000] [--seed 1]

Noise that is as strong at all times says how true the chance is, also where whitening leaves a
correlation or values are not normal. Loud times are those of `benchmarks.concealed`, two to five
stretches, with lambda of twelve to fifty: what the squares say of them, half of the samples times
the variance of the relative power.
"""

import argparse

import numpy as np
from jaxtyping import Float
from rich.progress import track

from allanfit.explain.strength._modulation import uneven

from .concealed._slow import inside, stretches

SAMPLES = 120_000
LEVELS = (0.05, 0.01, 0.001)
STRENGTHS = (12.0, 25.0, 50.0)


def normal(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    return rng.standard_normal(SAMPLES)


def averaged(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    """Each sample with its neighbours: about as alike as a filter's zeros leave them."""
    noise = rng.standard_normal(SAMPLES + 2)
    return (noise[2:] + noise[1:-1] + noise[:-2]) / 3**0.5


def laplace(rng: np.random.Generator) -> Float[np.ndarray, " samples"]:
    return rng.laplace(size=SAMPLES) / 2**0.5


def loud(rng: np.random.Generator, strength: float) -> Float[np.ndarray, " samples"]:
    times = inside(np.arange(SAMPLES) + 0.5, stretches(rng, SAMPLES))
    share = times.mean()
    excess = np.sqrt(2 * strength / SAMPLES / (share * (1 - share)))
    noise = rng.standard_normal(SAMPLES) * np.sqrt(1 + excess * times)
    return noise / noise.std()


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(arguments)
    kinds = {"normal": normal, "averaged over three": averaged, "Laplace": laplace}
    for each in STRENGTHS:
        kinds[f"loud stretches, lambda {each:g}"] = lambda rng, each=each: loud(rng, each)
    rows = []
    for place, (name, made) in enumerate(kinds.items()):
        chances = [
            uneven(made(np.random.default_rng((asked.seed, place, index))))[0]
            for index in track(range(asked.records), name)
        ]
        shares = "".join(f" {np.mean(np.less(chances, level)):.4f} |" for level in LEVELS)
        rows.append(f"| {name} |{shares}")
    print(f"{asked.records} records of {SAMPLES:,} samples, seed {asked.seed}\n")
    print("| noise |" + "".join(f" chance < {level:g} |" for level in LEVELS))
    print("|---" * (1 + len(LEVELS)) + "|")
    print("\n".join(rows))


if __name__ == "__main__":
    main()
