"""Running means that a spectrum may have come through, by a quick look at all of them."""

from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import brentq

from ...physics import LowPass, running_mean_gain
from ._ordinates import averaged
from ._structure import Data

#: Of more samples, bins are wider than what lies between two zeros.
_TAPS = np.arange(2, 41)
_TIMES = (1, 2, 3, 4)
# As many are fitted.
_SHORTLIST = 8
# Slower noise is not white [cycles per sample].
_FAST = 0.005
# What a zero leaves of a bin.
_LEAST = 1e-9
# Most records came through none, and are not to wait for it: twice the log-likelihood at least.
_WORTH = 40.0


def running_means(data: Data) -> list[tuple[float, float]]:
    """The cut-off frequency [cycles per sample] and order of the likeliest, the best first."""
    bins = data.bins
    fast = bins.used & (bins.frequency > _FAST)
    if fast.sum() < _SHORTLIST:
        return []
    weight = np.asarray(bins.shape)[fast]
    level = np.log(np.asarray(bins.density)[fast] / np.asarray(bins.expected)[fast, 1])

    def scatter(rest: Float[np.ndarray, " fast"]) -> float:
        return float(weight @ (rest - weight @ rest / weight.sum()) ** 2)

    expected = np.log(np.asarray(_expected(bins.nodes))[:, :, fast] + _LEAST)
    found = [
        (scatter(level - each), float(taps), float(times))
        for times, several in zip(_TIMES, expected, strict=True)
        for taps, each in zip(_TAPS, several, strict=True)
    ]
    enough = scatter(level) - _WORTH
    best = [each for each in sorted(found)[:_SHORTLIST] if each[0] < enough]
    return [(cutoff_frequency(taps, times), times) for _, taps, times in best]


@jax.jit
def _expected(nodes: Float[Array, "bins three"]) -> Float[Array, "times taps bins"]:
    """The gain of every running mean in each bin."""
    once = running_mean_gain(nodes, _TAPS[:, None, None])
    return jnp.stack([averaged(once**times) for times in _TIMES])


def nearest_running_means(cutoff: float) -> list[tuple[float, float]]:
    """Cut-off frequency and order of those that are nearest to a cut-off frequency."""
    found = []
    for times in map(float, _TIMES):
        sieve = LowPass(jnp.asarray(cutoff), jnp.asarray(times), running_mean=True)
        between = float(sieve.taps(1.0))
        for taps in {np.floor(between), np.ceil(between)} & {*map(float, _TAPS)}:
            found.append((cutoff_frequency(taps, times), times))
    return found


@lru_cache(maxsize=1024)
def cutoff_frequency(taps: float, times: float) -> float:
    """Where a running mean of so many samples, so many times, lets half of the power through."""

    def above_half(frequency: float) -> float:
        return float(running_mean_gain(np.asarray(frequency), np.asarray(taps))) ** times - 0.5

    return brentq(above_half, 1e-6, 1 / taps)  # pyright: ignore[reportReturnType]
