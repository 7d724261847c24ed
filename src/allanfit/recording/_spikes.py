"""Samples that stand alone, far from those beside them: errors in transmission, or fill-ins."""

import numpy as np
from jaxtyping import Float64, Int

from ._wording import count, percent, quantity

# Of so many samples the scatter is known well enough.
_ENOUGH = 200_000
# Noise stays within as many standard deviations in records of any length.
_FAR = 8.0
# What comes closer together than this is a knock, or a time that is loud, and no sample alone.
_NEAR = 16
_FEWEST = 3
# Below this they matter less to N than its interval does.
_LEAST = 1.02


def about_spikes(values: Float64[np.ndarray, " usable"], unit: str) -> tuple[str, ...]:
    """A finding when samples that stand alone make much of the noise from sample to sample."""
    if values.size < _NEAR:
        return ()
    apart = values[1:-1] - (values[:-2] + values[2:]) / 2
    scale = _deviation(apart[:: max(1, apart.size // _ENOUGH)])
    at = _alone(apart, _FAR * scale)
    if at.size < _FEWEST or scale == 0:
        return ()
    # In its neighbours' differences a spike shows too.
    beside = np.unique(at[:, None] + np.arange(-1, 2)).clip(0, apart.size - 1)
    whole = float(apart @ apart)
    rest = whole - float(apart[beside] @ apart[beside])
    ratio = np.sqrt(whole / rest * (apart.size - beside.size) / apart.size)
    if not ratio > _LEAST:
        return ()
    found = values[at + 1]
    same = f", all of exactly {quantity(found[0], unit)}," if np.ptp(found) == 0 else ""
    return (
        f"{count(at.size, 'sample')} ({percent(at.size / values.size)}){same} stand alone, more "
        f"than {_FAR:.0f} standard deviations from those beside them, as errors in transmission or "
        f"a logger's fill-ins make them. With them N comes out {ratio:.3g} times as large or more: "
        "`allanfit explain` tells it without them.",
    )


def written(values: Float64[np.ndarray, " fresh"], end: float) -> bool:
    """Whether the extreme value `end` was written by a logger, and is not where a range ends.

    Of a range that cuts off, some of what it leaves is near its end. What stands in for lost
    samples, or for an error, is far from all that was measured.
    """
    others = values[values != end]
    if others.size < 2:
        return False
    nearest = float(np.abs(others - end).min())
    return nearest > max(
        abs(float(np.median(others)) - end) / 2, _FAR * _deviation(np.diff(others))
    )


def _deviation(values: Float64[np.ndarray, " values"]) -> float:
    return 1.4826 * float(np.median(np.abs(values)))


def _alone(apart: Float64[np.ndarray, " inner"], least: float) -> Int[np.ndarray, " alone"]:
    """Which samples are that far from the middle of their neighbours; none if they come in swarms.

    The neighbours of a spike are half as far from the middle of theirs.
    """
    size = np.abs(apart)
    at = np.flatnonzero(size > least)
    left, right = (size[np.clip(at + step, 0, size.size - 1)] for step in (-1, 1))
    at = at[(size[at] > 1.5 * left) & (size[at] > 1.5 * right)]
    close = np.diff(at) < _NEAR
    return at[:0] if np.count_nonzero(close) > at.size / 2 else at
