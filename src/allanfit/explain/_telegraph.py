"""Two levels, or a normal process? What second-order statistics cannot say.

A random telegraph has the spectrum and the Allan variance of a Gauss-Markov process. Seen through
the Wiener filter that takes it out of the other noise, it dwells at two values, and a mixture of
two normal distributions of one width fits better than one, more than it does to a normal process
seen the same way.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import idct

from ._spread import normal

_SURROGATES = 199
# Modes beyond this many corner frequencies of the process are noise.
_CORNERS = 12
# Bins of values, in standard deviations, and where the search for two levels starts.
_EDGES = np.linspace(-6, 6, 121)
_VALUES = np.concatenate([[_EDGES[0]], (_EDGES[:-1] + _EDGES[1:]) / 2, [_EDGES[-1]]])
_SHARES = np.array([0.03, 0.15, 0.5, 0.85, 0.97])
_ROUNDS = 60
# Width of what stands for one level, beside the spread of all.
_NARROWEST = 0.05
# Chances below exp of less this are all alike.
_SURE = 600.0


class Levels(NamedTuple):
    """Two levels in a process that was filtered out of other noise."""

    #: Twice the gain in log likelihood over one normal distribution, a sample.
    gain: float
    #: The chance that a normal process gains as much.
    chance: float
    #: Share of the samples on the upper level.
    upper: float
    #: Which level it is on at moments that divide the stretch evenly.
    high: Bool[np.ndarray, " moments"]


def two_levels(
    amplitude: Float[np.ndarray, " modes"],
    signal: Float[np.ndarray, " modes"],
    total: Float[np.ndarray, " modes"],
    corner: int,
    seed: int,
) -> Levels:
    """Whether the filtered process dwells at two levels.

    `amplitude` are the signed cosine amplitudes of one stretch from order 2 on, as `ordinates`
    makes them, `signal` and `total` the expected squares of the process alone and of everything;
    `corner` is the mode at which the process's density has fallen to half.
    """
    count = min(amplitude.size, max(_CORNERS * corner, 64))
    weight = (signal / total)[:count]
    series = _series(weight * amplitude[:count])
    gain, upper, middle = _mixture(series)
    rng = np.random.default_rng(seed)
    spread = np.sqrt(total[:count])
    null = np.array(
        [
            _mixture(_series(weight * spread * rng.standard_normal(count)))[0]
            for _ in range(_SURROGATES)
        ]
    )
    beyond = float(np.mean(null >= gain))
    if beyond == 0:
        # A gain has an exponential tail, if of a size that the memory of the process sets.
        beyond = float(np.exp(-min(gain / null.mean(), _SURE)))
        beyond = min(1 / _SURROGATES, beyond)
    return Levels(gain, beyond, upper, series > middle)


def _series(coefficients: Float[np.ndarray, " modes"]) -> Float[np.ndarray, " moments"]:
    """Of a standard deviation of one."""
    # Neither a mean nor the order that only says how a ramp ends.
    series = np.asarray(idct(np.concatenate([[0.0, 0.0], coefficients]), norm="ortho"))
    return series / series.std()


def _mixture(series: Float[np.ndarray, " moments"]) -> tuple[float, float, float]:
    """Two normal distributions of one width against one.

    The gain, the share of the upper, and the middle between the two, by expectation and
    maximization on a histogram, from several starts at once.
    """
    counts = np.bincount(np.searchsorted(_EDGES, series), minlength=_VALUES.size)
    often = counts / counts.sum()
    mean = often @ _VALUES
    variance = often @ (_VALUES - mean) ** 2
    upper = _SHARES
    # Apart as two levels are that make up most of the variance.
    apart = np.sqrt(0.6 * variance / (upper * (1 - upper)))
    low, width = mean - upper * apart, np.full(upper.size, np.sqrt(0.4 * variance))
    high = low + apart
    for _ in range(_ROUNDS):
        below, above = (
            share[:, None] * _normal(_VALUES, middle, width)
            for share, middle in ((1 - upper, low), (upper, high))
        )
        total = np.maximum(below + above, 1e-300)
        weight = often * above / total
        upper = np.clip(weight.sum(axis=1), 1e-9, 1 - 1e-9)
        high = weight @ _VALUES / upper
        low = (mean - upper * high) / (1 - upper)
        within = variance - upper * (1 - upper) * (high - low) ** 2
        width = np.sqrt(np.maximum(within, _NARROWEST**2))
    best = np.log(total) @ often
    one = np.log(np.maximum(_normal(_VALUES, mean, np.sqrt(variance)), 1e-300)) @ often
    index = int(np.argmax(best))
    middle = float(low[index] + high[index]) / 2
    return float(2 * (best[index] - one)), float(upper[index]), middle


def _normal(at, middle, width):
    middle, width = np.asarray(middle)[..., None], np.asarray(width)[..., None]
    return normal((at - middle) / width) / width
