"""What samples that were lost on the way do to the others, and to a record made white."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.fft import irfft
from scipy.linalg import toeplitz
from scipy.ndimage import uniform_filter1d

from .._refit import refit
from .._state import Investigation
from ..spectrum._whiten import KERNEL, kernel_density, level
from ._alone import Others, read_again

# Samples on either side of a loss that may hear of it.
_REACH = 256
# Less of a variance is no matter.
_HEARD = 0.05
# N is too large at first, and what was lost is known the better the smaller it is.
_PASSES = 5
_DRAWS = 400
# And of their fraction.
_DRAWN = 2000


class Lost(NamedTuple):
    """Samples that were lost, as time stamps say or a line."""

    fraction: float
    #: The first sample after each loss, and how many were lost there.
    losses: tuple[tuple[int, int], ...] = ()
    #: Of the line [cycles per sample].
    frequency: float | None = None
    #: How much likelier it is with losses, in log-likelihood; stamps leave no doubt.
    gain: float = 1e3
    #: Of the logarithm of the odds, if that is more than so many by chance, one by one, make it.
    deviation: float = 0.0

    def draws(self, samples: int, rng: np.random.Generator) -> Float[np.ndarray, " draws"]:
        """What the fraction may be, by what so many `samples` that are left tell of it.

        Few losses tell a rate to a factor, and no rate is below zero.
        """
        odds = self.fraction / (1 - self.fraction)
        spread = max(self.deviation, 1 / math.sqrt(odds * samples))
        odds = odds * np.exp(spread * rng.standard_normal(_DRAWN))
        return odds / (1 + odds)


def count_losses_out(state: Investigation, losses: int, seed: int) -> None:
    """Let errors of the angle that do not cancel across losses be no noise of the rate.

    They cancel from sample to sample. Where it is known what was lost when, it is found from all
    others and goes into the next sample, as if none had been lost.
    """
    rng = np.random.default_rng(seed)
    square = float(np.exp(state.model.theta[0]))
    added = 2 * losses / state.values.size * square
    most = float(np.max(np.diff(state.place), initial=1.0)) - 1
    heard = added > _HEARD * float(np.exp(state.model.theta[1]))
    state.bridged = heard and 0 < most < _REACH and state.format.normal
    if state.bridged:
        added = _bridge(state, rng)
    # Of so many errors at random. What was put in place of lost ones is noise of N's own.
    unsure = added * rng.chisquare(losses, _DRAWS) / losses - added
    state.count_unsure(0.0 if state.bridged else added, unsure)
    refit(state)


def _bridge(state: Investigation, rng: np.random.Generator) -> float:
    """Put what was lost into the next samples, and say how uncertain that is, a sample.

    With errors of their own, as large as it is uncertain: else N would lack them.
    """
    recorded, size = state.values, state.looked_at.size
    in_time, lost, after = [], [], []
    for start, stop in state.long_pieces:
        at = (state.place[start:stop] - state.place[start]).astype(int)
        gone = np.ones(at[-1] + 1, bool)
        gone[at] = False
        whole = np.zeros(gone.size)
        whole[at] = recorded[start:stop]
        in_time.append(whole)
        lost.append(gone)
        after.append(start + np.searchsorted(at, np.flatnonzero(gone)))
    sizes = [each.size for each in in_time]
    whole, wrong = np.concatenate(in_time), np.flatnonzero(np.concatenate(lost))
    following, loss = np.unique(np.concatenate(after), return_inverse=True)
    counts = np.bincount(loss)
    # The next sample has the bias already.
    bias = counts * uniform_filter1d(recorded, 2 * _REACH + 1)[following]
    left = np.zeros(counts.size)
    for _ in range(_PASSES):
        sums = np.bincount(loss, Others(state, sizes).expect(whole, wrong))
        left = _left_open(state, counts)
        state.values = recorded.copy()
        state.values[following] += sums - bias + np.sqrt(left) * rng.standard_normal(counts.size)
        read_again(state)
        refit(state)
    return float(np.sum(left)) / size


def _left_open(
    state: Investigation, counts: Int[np.ndarray, " losses"]
) -> Float[np.ndarray, " losses"]:
    """Variance of the sum of so many samples in a row, given all others."""
    density = kernel_density(state.left, level(state.left, state.variance))
    inverse = np.asarray(irfft(1 / density, KERNEL))
    of = {
        count: float(np.sum(np.linalg.inv(toeplitz(inverse[:count]))))
        for count in map(int, np.unique(counts))
    }
    return np.array([of[int(count)] for count in counts])


def beside_losses(state: Investigation) -> Float[np.ndarray, " looked_at"]:
    """Standard deviation of each sample of the white record, as losses make it.

    Whitening takes neighbours in the log for neighbours in time. Where these are correlated, as
    errors of an angle are or noise behind a filter, the record is not white about a loss.
    """
    variance = np.ones(state.values.size)
    lost = np.diff(state.place, prepend=state.place[0] - 1) - 1
    after = np.flatnonzero(lost > 0)
    if state.bridged or not after.size:
        return variance[state.looked_at]
    density = kernel_density(state.left, level(state.left, state.variance))
    covariance = np.asarray(irfft(density, KERNEL))
    kernel = np.asarray(irfft(1 / np.sqrt(density), KERNEL))
    for count in map(int, np.unique(lost[after])):
        added = _added(covariance, kernel, count)
        if np.abs(added).max() < _HEARD:
            continue
        for at in after[lost[after] == count]:
            first = max(at - _REACH, 0)
            here = variance[first : at + _REACH]
            here += added[first - at + _REACH :][: here.size]
    return np.sqrt(np.maximum(variance, _HEARD))[state.looked_at]


def _added(
    covariance: Float[np.ndarray, " lags"], kernel: Float[np.ndarray, " lags"], lost: int
) -> Float[np.ndarray, " about"]:
    """What so many `lost` add to the variance of each of `_REACH` white samples before and after.

    Samples before and after are correlated less, or more, than it takes for them.
    """
    lags = np.arange(1, 2 * _REACH + 1)
    # Row i is the i-th sample before the loss from its end, column j the j-th after it.
    apart = lags[:_REACH, None] + lags[None, :_REACH] - 1
    change = covariance[apart + lost] - covariance[apart]
    about = toeplitz(kernel[: 2 * _REACH])
    before, later = about[:, _REACH - 1 :: -1], about[:, _REACH:]
    return 2 * np.sum((before @ change) * later, axis=1)
