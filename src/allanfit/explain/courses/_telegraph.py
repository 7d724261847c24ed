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
from scipy.stats import norm

from ..values._contamination import normal

_SURROGATES = 199
# Modes beyond this many corner frequencies of the process are noise.
_CORNERS = 12
# Moments of two of its time constants.
_BLOCK = 8
# Bins of values, in standard deviations, and where the search for two levels starts.
_EDGES = np.linspace(-6, 6, 121)
_VALUES = np.concatenate([[_EDGES[0]], (_EDGES[:-1] + _EDGES[1:]) / 2, [_EDGES[-1]]])
_SHARES = np.array([0.03, 0.15, 0.5, 0.85, 0.97])
_ROUNDS = 60
# Width of what stands for one level, beside the spread of all.
_NARROWEST = 0.05
#: Chances below exp of less this are all alike.
SURE = 600.0


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
    weight = _filter(signal, total, corner)
    count = weight.size
    series = _series(weight * amplitude[:count])
    rng = np.random.default_rng(seed)
    spread = np.sqrt(total[:count])
    # A histogram of each: the series themselves may be long.
    drawn = (
        _often(_series(weight * spread * rng.standard_normal(count))) for _ in range(_SURROGATES)
    )
    found = _mixture(np.stack([_often(series), *drawn]))
    gain, null = float(found.gain[0]), found.gain[1:]
    beyond = float(np.mean(null >= gain))
    if beyond == 0:
        # A gain has an exponential tail, if of a size that the memory of the process sets.
        beyond = float(np.exp(-min(gain / null.mean(), SURE)))
        beyond = min(1 / _SURROGATES, beyond)
    return Levels(gain, beyond, float(found.upper[0]), series > found.middle[0])


def one_way(
    amplitude: Float[np.ndarray, " modes"],
    signal: Float[np.ndarray, " modes"],
    total: Float[np.ndarray, " modes"],
    corner: int,
) -> float:
    """Log of the chance that the filtered process jumps one way, and comes back, as much.

    Arguments as of `two_levels`. Backward in time a normal process is one, and so is a telegraph:
    the cubes of their moves have a mean of zero. Each block of moves has as much of it by chance as
    it shows itself, whatever their distribution.
    """
    weight = _filter(signal, total, corner)
    cubes = np.diff(_series(weight * amplitude[: weight.size])) ** 3
    blocks = cubes[: cubes.size // _BLOCK * _BLOCK].reshape(-1, _BLOCK).sum(axis=1)
    leans = abs(blocks.sum()) / np.sqrt(np.sum(blocks**2))
    return float(norm.logsf(leans) + np.log(2))


def _filter(
    signal: Float[np.ndarray, " modes"], total: Float[np.ndarray, " modes"], corner: int
) -> Float[np.ndarray, " count"]:
    """What takes the process out of the other noise, as far as there is any of it."""
    count = min(total.size, max(_CORNERS * corner, 64))
    return (signal / total)[:count]


def _series(coefficients: Float[np.ndarray, " modes"]) -> Float[np.ndarray, " moments"]:
    """Of a standard deviation of one."""
    # Neither a mean nor the order that only says how a ramp ends.
    series = np.asarray(idct(np.concatenate([[0.0, 0.0], coefficients]), norm="ortho"))
    return series / series.std()


def _often(series: Float[np.ndarray, " moments"]) -> Float[np.ndarray, " values"]:
    """The share of the moments at each of `_VALUES`."""
    return np.bincount(np.searchsorted(_EDGES, series), minlength=_VALUES.size) / series.size


class _Mixture(NamedTuple):
    """Two normal distributions of one width in each of several histograms."""

    #: Twice the gain in log likelihood over one, a sample.
    gain: Float[np.ndarray, " histograms"]
    #: The share of the upper, and the middle between the two.
    upper: Float[np.ndarray, " histograms"]
    middle: Float[np.ndarray, " histograms"]


def _mixture(often: Float[np.ndarray, "histograms values"]) -> _Mixture:
    """By expectation and maximization, from several starts at once."""
    mean = often @ _VALUES
    variance = np.sum(often * (_VALUES - mean[:, None]) ** 2, axis=1)
    one = _normal(mean, np.sqrt(variance))
    # The starts are an axis from here on.
    mean, variance, each = mean[:, None], variance[:, None], often[:, None]
    upper = np.broadcast_to(_SHARES, (len(often), _SHARES.size))
    # Apart as two levels are that make up most of the variance.
    apart = np.sqrt(0.6 * variance / (upper * (1 - upper)))
    low, width = mean - upper * apart, np.broadcast_to(np.sqrt(0.4 * variance), upper.shape)
    high = low + apart
    for _ in range(_ROUNDS):
        below = (1 - upper)[..., None] * _normal(low, width)
        above = upper[..., None] * _normal(high, width)
        total = np.maximum(below + above, 1e-300)
        weight = each * above / total
        upper = np.clip(weight.sum(axis=-1), 1e-9, 1 - 1e-9)
        high = weight @ _VALUES / upper
        low = (mean - upper * high) / (1 - upper)
        within = variance - upper * (1 - upper) * (high - low) ** 2
        width = np.sqrt(np.maximum(within, _NARROWEST**2))
    best = np.sum(np.log(total) * each, axis=-1)
    index = np.argmax(best, axis=1)[:, None]

    def of_best(values):
        return np.take_along_axis(values, index, axis=1)[:, 0]

    gain = 2 * (of_best(best) - np.sum(np.log(np.maximum(one, 1e-300)) * often, axis=1))
    return _Mixture(gain, of_best(upper), of_best((low + high) / 2))


def _normal(middle, width):
    """The density at `_VALUES`, an axis behind those of the middles."""
    return normal((_VALUES - middle[..., None]) / width[..., None]) / width[..., None]
