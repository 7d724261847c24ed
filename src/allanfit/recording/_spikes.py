"""Samples that stand alone, far from those beside them: errors in transmission, or fill-ins."""

import numpy as np
from jaxtyping import Float64, Int

from ._wording import count, percent

# Of so many samples the scatter is known well enough.
_ENOUGH = 200_000
# Noise stays within as many standard deviations in records of any length.
_FAR = 8.0
# What is as far, and closer together than this, is a knock, or a time that is loud.
_LOUD, _NEAR = 6.0, 16
_FEWEST = 3
# Samples that a logger fills in one after another, on average.
_BRIEF = 2.5
# Below this they matter less to N than its interval does.
_LEAST = 1.02


def about_spikes(values: Float64[np.ndarray, " usable"], unit: str) -> tuple[str, ...]:
    """A finding when samples that stand alone make much of the noise from sample to sample."""
    if values.size < _NEAR:
        return ()
    at, apart = alone(values)
    if at.size < _FEWEST:
        return ()
    # In its neighbours' differences a spike shows too.
    beside = np.unique(at[:, None] + np.arange(-2, 1)).clip(0, apart.size - 1)
    whole = float(apart @ apart)
    rest = whole - float(apart[beside] @ apart[beside])
    ratio = np.sqrt(whole / rest * (apart.size - beside.size) / apart.size)
    if not ratio > _LEAST:
        return ()
    found = values[at]
    same = f", all of exactly {f'{found[0]:.6g} {unit}'.rstrip()}," if np.ptp(found) == 0 else ""
    return (
        f"{count(at.size, 'sample')} ({percent(at.size / values.size)}){same} stand alone, more "
        f"than {_FAR:.0f} standard deviations from those beside them, as errors in transmission or "
        f"a logger's fill-ins make them. With them N comes out {ratio:.3g} times as large or more: "
        "`allanfit explain` tells it without them.",
    )


def written(
    values: Float64[np.ndarray, " usable"], fresh: Float64[np.ndarray, " fresh"], end: float
) -> bool:
    """Whether the extreme value `end` was written by a logger, and is not where a range ends.

    Of a range that cuts off, some of what it leaves is near its end, or stays there for long. What
    stands in for lost samples, or for an error, is brief and far from all that was measured.
    `fresh` are the values without those that repeat the one before.
    """
    others = fresh[fresh != end]
    if np.count_nonzero(values == end) > _BRIEF * np.count_nonzero(fresh == end) or others.size < 2:
        return False
    nearest = float(np.abs(others - end).min())
    far = max(abs(float(np.median(others)) - end) / 2, _FAR * deviation(np.diff(others)))
    return nearest > far


def deviation(values: Float64[np.ndarray, " values"]) -> float:
    """The standard deviation of normal values, by the median of their sizes."""
    return 1.4826 * float(np.median(np.abs(values)))


def alone(
    values: Float64[np.ndarray, " usable"], far: float = _FAR
) -> tuple[Int[np.ndarray, " alone"], Float64[np.ndarray, " inner"]]:
    """Which samples are so `far`, in standard deviations, from the middle of their neighbours.

    As no others near them are. Second, how far each but the first and the last is from there.
    """
    apart = values[1:-1] - (values[:-2] + values[2:]) / 2
    usual = deviation(apart[:: max(1, apart.size // _ENOUGH)])
    size = np.abs(apart)
    loud = np.flatnonzero(size > _LOUD * usual) if usual > 0 else np.zeros(0, int)
    # The neighbours of a spike are half as far from the middle of theirs.
    left, right = (size[np.clip(loud + step, 0, size.size - 1)] for step in (-1, 1))
    high = size[loud] > np.maximum(1.5 * np.maximum(left, right), far * usual)
    at = loud[high]
    before = at - loud[np.maximum(np.searchsorted(loud, at - 1) - 1, 0)]
    after = loud[np.minimum(np.searchsorted(loud, at + 2), max(loud.size - 1, 0))] - at
    lonely = ((before <= 1) | (before > _NEAR)) & ((after <= 1) | (after > _NEAR))
    return at[lonely] + 1, apart
