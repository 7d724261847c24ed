"""The likeliest path between two variances, and between two of each where there are more."""

from itertools import accumulate

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import chi2

FEWEST_WINDOWS = 8
# From such a chance on the strength is followed.
UNEVEN = 1e-3
# Loud for less of the record, and by more, is a knock and no change of the noise.
KNOCK_SHARE, KNOCK_RATIO = 0.15, 2.0
# How much louder the loud times may be than the quiet ones, to begin with.
_EXCESSES = (0.03, 0.1, 0.3, 1.0, 10.0)

Windows = Float[np.ndarray, " windows"]


def levels_of(power: Windows, weight: float) -> Int[np.ndarray, " windows"]:
    """Which level each window is of, from the quietest: two, and each of them two if it must be."""
    path, *_ = two_levels_of(power, weight)
    labels = path.astype(int)
    if not path.any() or path.all():
        return np.zeros(power.size, int)
    if path.mean() < KNOCK_SHARE:
        # Perhaps a knock, which is looked at first, by itself.
        return labels
    for place in (1, 0):
        mine = path == place
        own = power[mine]
        if own.size < FEWEST_WINDOWS or chance_of_scatter(own, weight) > UNEVEN:
            continue
        within = levels_of(own, weight)
        if place == 0:
            labels[~mine] += within.max()
        labels[mine] += within
    return labels


def chance_of_scatter(power: Windows, weight: float) -> float:
    """The chance that windows of one level scatter as much, each as certain as `weight` samples."""
    scatter = float(np.sum((power / power.mean() - 1) ** 2)) * weight / 2
    return float(chi2.sf(scatter, power.size - 1))


def two_levels_of(
    power: Windows, samples: float, prices: tuple[float, ...] = ()
) -> tuple[Bool[np.ndarray, " windows"], float, float]:
    """The likeliest path between two variances, and the two; begun from several ratios.

    `prices` are those of a change, in the log of its odds, each tried where others leave nothing.
    """
    mean = float(power.mean())
    best = np.zeros(power.size, bool), mean, mean
    # Leaving a level must be worth some evidence, or noise would chop intervals up.
    for price in prices or (np.log(power.size) + 2, np.log(power.size)):
        highest = _likelihood(power, mean, samples).sum()
        for excess in _EXCESSES:
            # As if a third of the time were loud.
            quiet = mean / (1 + excess / 3)
            path, *levels, score = climbed(power, samples, price, quiet, quiet * (1 + excess))
            if score > highest:
                best, highest = (path, levels[0], levels[1]), score
        if best[0].any():
            break
    return best


def climbed(
    power: Windows, samples: float, price: float, quiet: float, loud: float
) -> tuple[Bool[np.ndarray, " windows"], float, float, float]:
    """Path and levels by turns (Viterbi), and their log-likelihood less the price of changes."""
    path, score = np.zeros(power.size, bool), -np.inf
    for _ in range(20):
        likelihood = np.stack([_likelihood(power, level, samples) for level in (quiet, loud)])
        # By how much the best path to each window that is loud there beats the best that is quiet.
        ahead = np.fromiter(
            accumulate(
                (likelihood[1] - likelihood[0]).tolist(),
                lambda before, now: min(max(before, -price), price) + now,
            ),
            float,
        )
        # By more than the price, and the path is there whatever comes; else where it is next.
        sure = np.abs(ahead) > price
        sure[-1] = True
        told = np.where(sure, np.arange(power.size), power.size - 1)
        found = ahead[np.minimum.accumulate(told[::-1])[::-1]] > 0
        same, path = np.array_equal(found, path), found
        if not path.any() or path.all():
            return path, quiet, loud, -np.inf
        changes = np.count_nonzero(np.diff(path))
        score = float(np.where(path, likelihood[1], likelihood[0]).sum()) - price * changes
        quiet, loud = float(power[~path].mean()), float(power[path].mean())
        if same:
            break
    if loud < quiet:
        path, quiet, loud = ~path, loud, quiet
    return path, quiet, loud, score


def _likelihood(power: Windows, level: float, samples: float) -> Windows:
    """The log-likelihood of mean squares of so many samples, Gamma variates about a level."""
    return -samples / 2 * (np.log(level) + power / level)
