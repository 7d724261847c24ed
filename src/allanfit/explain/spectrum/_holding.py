"""What holding samples at random does to a spectrum: each is the one before it with some chance.

White noise of known size that is no N, as rounding adds it, is held with them.
"""

import numpy as np
from jaxtyping import Float

from ._structure import Data


def held_rows(data: Data) -> Float[np.ndarray, "terms bins"]:
    """What unit powers of Q, N, B, K put into each bin when samples are held, and nothing else.

    With the gain |H|^2 of the mean delay, each sample being fresh with chance 1 - p, samples of a
    density S that are held at random have |H|^2 S and, as `holding` goes with frequency, the mean
    of (1 - |H|^2) S. Here S is 1/sin(pi f) of B and 1/(2 sin^2(pi f)) of K, at an instant.
    """
    plain = np.ascontiguousarray(np.asarray(data.bins.expected).T)
    if data.repeat == 1:
        return plain
    held, white, p = holding(data), plain[1], 1 - 1 / data.repeat
    # A value is late by a random time. What is slow is late as through a filter, whose gain is one
    # at zero frequency; and what changes meanwhile comes and goes as fresh values do.
    late = held * late_part(data)
    changed = np.array(
        [8 / np.pi * np.sqrt(p) / (1 + p) * np.arctanh(np.sqrt(p)), 2 * p / (1 - p**2)]
    )
    slow = plain[2:] * late + changed[:, None] * held
    return np.stack([white * _held_angle(data), white * held, *slow])


def foreign(data: Data) -> float | Float[np.ndarray, " bins"]:
    """White noise in each bin that is not N, held as N is."""
    return float(data.foreign) * (holding(data) if data.repeat != 1 else 1.0)


def holding(data: Data) -> Float[np.ndarray, " bins"]:
    """What holding samples does to the density of white noise."""
    middle = np.asarray(data.bins.nodes)[:, 1]
    p = 1 - 1 / data.repeat
    return (1 - p**2) / ((1 - p) ** 2 + 4 * p * np.sin(np.pi * middle) ** 2)


def late_part(data: Data) -> float:
    """Of white noise that is held, the part that is late; the other changes meanwhile."""
    p = 1 - 1 / data.repeat
    return (1 - p) / (1 + p)


def changing(data: Data) -> Float[np.ndarray, " bins"]:
    """The other part, bin by bin: the mean of 1 - |H|^2, of which only short waves have much."""
    used, part = data.bins.used, 1 - late_part(data) * holding(data)
    middle = data.bins.frequency[used]
    edges = np.concatenate([[0.0], (middle[1:] + middle[:-1]) / 2, [0.5]])
    part[~used] = 0.0
    part[used] *= np.diff(edges)
    return part / part.sum() * (1 - late_part(data))


def _held_angle(data: Data) -> Float[np.ndarray, " bins"]:
    """Quantized angle, held, over white noise of the same power, not held.

    The difference of white noise, held with chance p: one is the next fresh value after another
    only where it comes at once, so that the autocovariance is 2 p^m - (1 - p)^2 p^(m-1). That is
    far above zero at low frequency, where the difference itself vanishes.
    """
    middle = np.asarray(data.bins.nodes)[:, 1]
    p, turn = 1 - 1 / data.repeat, np.exp(2j * np.pi * middle)
    powers = (p * turn / (1 - p * turn)).real
    return 2 * (1 + powers * (2 - (1 - p) ** 2 / p))
