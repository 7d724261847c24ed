"""Running means that a spectrum may have come through, by a quick look at all of them."""

from functools import lru_cache, partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.optimize import brentq

from ...physics import LowPass, oversampled_gain, running_mean_gain
from ._ordinates import averaged
from ._structure import OVERSAMPLED, RUNNING_MEAN, Data

#: Of more samples, bins are wider than what lies between two zeros.
_TAPS = np.arange(2, 41)
_TIMES = (1, 2, 3, 4)
# Of what is sampled faster than the log means may be shorter than it and of any length; those that
# are taken once are the same as of its samples, or flat.
_LENGTHS = np.array([1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 40])
_TIMES_OVER = (2, 3, 4)
_SOUGHT = ((RUNNING_MEAN, _TAPS, _TIMES), (OVERSAMPLED, _LENGTHS, _TIMES_OVER))
# As many are fitted.
_SHORTLIST = 8
# Slower noise is not white [cycles per sample].
_FAST = 0.005
# What a zero leaves of a bin.
_LEAST = 1e-9
# Most records came through none, and are not to wait for it: twice the log-likelihood at least.
_WORTH = 40.0


def running_means(data: Data) -> list[tuple[str, float, float]]:
    """Kind, cut-off frequency [cycles per sample] and order of the likeliest, the best first."""
    bins = data.bins
    fast = bins.used & (bins.frequency > _FAST)
    if fast.sum() < _SHORTLIST:
        return []
    weight = np.asarray(bins.shape)[fast]
    level = np.log(np.asarray(bins.density)[fast] / np.asarray(bins.expected)[fast, 1])

    def scatter(rest: Float[np.ndarray, " fast"]) -> float:
        return float(weight @ (rest - weight @ rest / weight.sum()) ** 2)

    found = []
    for kind, lengths, many in _SOUGHT:
        expected = np.log(np.asarray(_expected(kind, bins.nodes))[:, :, fast] + _LEAST)
        found += [
            (scatter(level - each), kind, float(length), float(times))
            for times, several in zip(many, expected, strict=True)
            for length, each in zip(lengths, several, strict=True)
        ]
    enough = scatter(level) - _WORTH
    best = [each for each in sorted(found)[:_SHORTLIST] if each[0] < enough]
    return [(kind, cutoff_frequency(kind, length, times), times) for _, kind, length, times in best]


@partial(jax.jit, static_argnums=0)
def _expected(kind: str, nodes: Float[Array, "bins three"]) -> Float[Array, "times lengths bins"]:
    """The gain of every running mean of a kind in each bin."""
    if kind == RUNNING_MEAN:
        once = running_mean_gain(nodes, _TAPS[:, None, None])
        return jnp.stack([averaged(once**times) for times in _TIMES])
    every = [
        [averaged(oversampled_gain(nodes, np.asarray(length), float(times))) for length in _LENGTHS]
        for times in _TIMES_OVER
    ]
    return jnp.stack([jnp.stack(each) for each in every])


def nearest_running_means(cutoff: float) -> list[tuple[str, float, float]]:
    """Kind, cut-off frequency and order of those that are nearest to a cut-off frequency."""
    found = []
    for kind, lengths, many in _SOUGHT:
        for times in map(float, many):
            oversampled = kind == OVERSAMPLED
            sieve = LowPass(
                jnp.asarray(cutoff), jnp.asarray(times), running_mean=True, oversampled=oversampled
            )
            place = int(np.searchsorted(lengths, float(sieve.taps(1.0))))
            for length in map(float, lengths[max(place - 1, 0) : place + 1]):
                found.append((kind, cutoff_frequency(kind, length, times), times))
    return found


@lru_cache(maxsize=1024)
def cutoff_frequency(kind: str, length: float, times: float) -> float:
    """Where a running mean of so many samples, so many times, lets half of the power through."""

    def above_half(frequency: float) -> float:
        if kind == OVERSAMPLED:
            return float(np.sinc(length * frequency)) ** (2 * times) - 0.5
        return float(running_mean_gain(np.asarray(frequency), np.asarray(length))) ** times - 0.5

    return brentq(above_half, 1e-6, 1 / length)  # pyright: ignore[reportReturnType]
