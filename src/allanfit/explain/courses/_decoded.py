"""The likeliest path between two levels beside white noise and a slow baseline.

Steps that stand out one by one are found without knowing how tall they are; once that is known,
all moments together tell which level each is on (Viterbi 1967, IEEE Trans. IT 13:260).
"""

from itertools import accumulate

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import dct, idct

# Dwells over which the baseline is smooth, moments a dwell, and the most moments of all.
_SMOOTH, _A_DWELL, _MOST = 4.0, 32, 8192
_ROUNDS = 4

Samples = Float[np.ndarray, " samples"]


def decoded(values: Samples, level: Samples, white: float) -> Samples:
    """A path of zeros and ones like `level`, but likelier; `white` is a variance [u^2]."""
    for _ in range(_ROUNDS):
        switches = int(np.count_nonzero(np.diff(level)))
        if switches == 0:
            break
        dwell = values.size / (switches + 1)
        height = _height(values, level, dwell)
        rest = values - _baseline(values - height * level, dwell)
        size = max(round(dwell / _A_DWELL), values.size // _MOST, 1)
        count = values.size // size
        means = rest[: count * size].reshape(count, size).mean(axis=1)
        path = likeliest(means / height, white / size / height**2, size / dwell)
        found = np.append(np.repeat(path, size), np.full(values.size % size, path[-1]))
        if np.array_equal(found, level > 0):
            break
        level = found.astype(float)
    return level


def shortest(dwell: float, white: float) -> float:
    """Samples of the shortest dwell that such a path has as a rule.

    `white` is the variance of white noise over the square of the height.
    """
    return max(dwell / _A_DWELL, 4 * np.log(_A_DWELL) * white)


def _height(values: Samples, level: Samples, dwell: float) -> float:
    """Of the levels, beside a baseline that takes away some of them too."""
    slow = [each - _baseline(each, dwell) for each in (values, level)]
    return float(slow[0] @ slow[1] / (slow[1] @ slow[1]))


def _baseline(values: Samples, dwell: float) -> Samples:
    """What is slow, by the Wiener filter of a walk that rises above white noise in some dwells."""
    order = np.arange(values.size)
    corner = 1 / (_SMOOTH * dwell)
    rise = (2 * np.sin(np.pi * order / (2 * values.size)) / corner) ** 2
    return np.asarray(idct(np.asarray(dct(values, norm="ortho")) / (1 + rise), norm="ortho"))


def likeliest(
    means: Float[np.ndarray, " moments"], variance: float, leave: float
) -> Bool[np.ndarray, " moments"]:
    """Which moments are on the upper level of zero and one.

    By how much the upper is likelier says all that Viterbi's two paths do: of what came before, no
    more counts than a switch costs, and where it is more than that, the level is known whatever
    follows.
    """
    # Of a moment as long as a dwell nothing is known.
    leave = min(leave, 0.5)
    switch = float(np.log1p(-leave) - np.log(leave))
    gains = ((means - 0.5) / variance).tolist()
    with_next = accumulate(gains, lambda before, gain: min(max(before, -switch), switch) + gain)
    ahead = np.array([*with_next])
    known = np.abs(ahead) > switch
    known[-1] = True
    # Each moment is on the level of the next that is known.
    order = np.where(known, np.arange(means.size), means.size)
    return ahead[np.minimum.accumulate(order[::-1])[::-1]] > 0
