"""Does the noise lean to one side, by more than spikes on that side make it do?"""

import numpy as np
from jaxtyping import Float
from scipy.stats import norm

# Widths of the two odd functions compared, in standard deviations. Between them they see half of
# what the third moment sees in normal values whose characteristic is a little curved; wider ones
# would see more of that, and more of spikes.
_NARROW, _WIDE = 0.7, 1.4
# Spikes lie beyond so many standard deviations.
_BEYOND = 3.0
# Newton steps to the middle: from the median, two are enough.
_STEPS = 4


def _odd(x: Float[np.ndarray, " samples"], width: float) -> Float[np.ndarray, " samples"]:
    """Grows to x = width, and falls to nothing from there: far values count as little."""
    return x * np.exp(-((x / width) ** 2) / 2)


def _slope(x: Float[np.ndarray, " samples"], width: float) -> float:
    return float(np.mean((1 - (x / width) ** 2) * np.exp(-((x / width) ** 2) / 2)))


def skewness(values: Float[np.ndarray, " samples"], spikes: float = 0.0) -> float:
    """How far values lean to one side, in standard errors; positive with a tail to the right.

    About the middle by the wide one of two odd functions the narrow one has the mean zero if they
    are symmetric, whatever their distribution (an M-estimate of location: Huber and Ronchetti
    2009, 3.2). Both are smooth, for values may lie on a lattice, and return to zero, for spikes may
    have any height. `spikes` is a share of the values that is beyond the others on one side: what
    they could make of it is taken off.
    """
    low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
    x = 1.349 * (values - middle) / (high - low)
    for _ in range(_STEPS):
        x = x - np.mean(_odd(x, _WIDE)) / _slope(x, _WIDE)
    part = _slope(x, _NARROW) / _slope(x, _WIDE)
    each = part * _odd(x, _WIDE) - _odd(x, _NARROW)
    reach = np.linspace(_BEYOND, 3 * _BEYOND, 400)
    most = spikes * float(np.max(np.abs(part * _odd(reach, _WIDE) - _odd(reach, _NARROW))))
    lean = float(np.mean(each))
    beyond = np.sign(lean) * max(abs(lean) - most, 0.0)
    return float(beyond / (np.std(each) / np.sqrt(values.size)))


def leans(values: Float[np.ndarray, " samples"], spikes: float) -> float:
    """Log of the chance that symmetric values lean so, a share of which are `spikes`."""
    return min(float(norm.logsf(abs(skewness(values, spikes)))) + float(np.log(2)), 0.0)
