"""What samples that were lost on the way do to a record made white."""

import numpy as np
from jaxtyping import Float
from scipy.fft import irfft
from scipy.linalg import toeplitz

from .._state import Investigation
from ..spectrum._whiten import level

# Samples on either side of a loss that may hear of it, and a kernel long enough for them.
_REACH, _KERNEL = 256, 4096
# Less of a variance is no matter.
_HEARD = 0.05


def beside_losses(state: Investigation) -> Float[np.ndarray, " looked_at"]:
    """Standard deviation of each sample of the white record, as losses make it.

    Whitening takes neighbours in the log for neighbours in time. Where these are correlated, as
    errors of an angle are or noise behind a filter, the record is not white about a loss.
    """
    variance = np.ones(state.values.size)
    lost = np.diff(state.place, prepend=state.place[0] - 1) - 1
    after = np.flatnonzero(lost > 0)
    if not after.size:
        return variance[state.looked_at]
    frequency = np.arange(_KERNEL // 2 + 1) / _KERNEL
    density = np.interp(frequency, state.left.frequency, level(state.left, state.variance) / 2)
    covariance = np.asarray(irfft(density, _KERNEL))
    kernel = np.asarray(irfft(1 / np.sqrt(density), _KERNEL))
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
