"""Values that a sensor or a logger repeats while nothing is measured."""

import numpy as np
from jaxtyping import Bool, Float64

from ._checks import code_width, fresh_deviation, local_deviation, rails, wide

# Shorter runs matter little, and a slow reader of a sensor makes them.
_SHORTEST = 64
# Of so many samples, one in each run of the shortest length is looked at first.
_STRIDE = _SHORTEST // 4
# Expected number of runs as long in the whole record, were repeats independent with their usual
# probability, below which a run is frozen.
_NO_CHANCE = 1e-6


def frozen(values: Float64[np.ndarray, " samples"]) -> Bool[np.ndarray, " samples"]:
    """Which samples repeat the one before in a run that no noise and no slow reader makes.

    Repeats of fresh values, by chance or since the sensor is read faster than it measures, come
    one by one, so that the lengths of their runs are geometric at worst. Where codes are wide
    beside the noise nothing is said, and values at which samples pile up are a matter of the range.
    """
    still = np.zeros(values.size, bool)
    coarse = values[::_STRIDE]
    same = coarse[1:] == coarse[:-1]
    if not np.any(same[1:] & same[:-1]):
        return still
    starts = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1]]))
    repeats = np.diff(starts, append=values.size) - 1
    moving = values[np.isfinite(values)]
    if moving.size == 0:
        return still
    # What no sensor gives is refused later, for its size.
    with np.errstate(over="ignore", invalid="ignore"):
        width = code_width(moving)
        # Wide codes repeat themselves for as long as a slow drift takes from one to the next.
        if width == 0 or _coarse(moving, width):
            return still
    long = repeats >= _SHORTEST
    long &= ~np.isin(values[starts], rails(moving, width))
    odd = np.zeros(starts.size, bool)
    while True:
        # Each run is one fresh value and its repeats.
        usual = repeats[~odd].sum() / max(starts.size - odd.sum() + repeats[~odd].sum(), 1)
        chance = np.log(values.size) + repeats * np.log(max(usual, 1 / values.size))
        found = long & (chance < np.log(_NO_CHANCE))
        if np.array_equal(found, odd):
            break
        odd = found
    for start, length in zip(starts[odd], repeats[odd], strict=True):
        still[start + 1 : start + 1 + length] = True
    return still


class FrozenBlocks:
    """`frozen` for a channel that comes block by block: a sensor may hang for longer than one."""

    def __init__(self):
        #: Whether the channel moves from sample to sample, once that is known.
        self._moves = False
        self._known = False
        self._last = np.nan

    def __call__(self, values: Float64[np.ndarray, " samples"]) -> Bool[np.ndarray, " samples"]:
        """Which of the next samples are frozen."""
        finite = np.isfinite(values)
        moving = values[finite]
        if moving.size and moving.min() == moving.max():
            still = finite & self._moves
            still[0] &= bool(values[0] == self._last)
        else:
            still = frozen(values)
        if not self._known and moving.size and moving.min() < moving.max():
            self._known, self._moves = True, not _coarse(moving, code_width(moving))
        if values.size:
            self._last = values[-1]
        return still


def _coarse(moving: Float64[np.ndarray, " finite"], width: float) -> bool:
    return wide(width, local_deviation(moving) or fresh_deviation(moving))
