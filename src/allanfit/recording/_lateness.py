"""How late time stamps are beside the even grid: what of that is lost time, and what is wrong.

A stamp is late by what it is ahead of the grid. Lateness that all later stamps share is time in
which samples were lost. Where it goes away at once, by a step back that no clock takes, and those
before and after continue each other, the stamps between are wrong: damaged, or of rows that stand
out of order.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64

from ._wording import count

SHORTEST_STRETCH = 16
"""Fewer samples than this between two gaps carry nothing an analysis could use."""

CATCH_UP = 1024
"""Stamps catch up within a burst or a blocked moment; no transport holds more samples than this."""

GAP = 10
"""A loss of fewer samples moves the time axis too little to matter, and cutting there would take
the long averaging times away."""

# Stamps of one place scatter by no more than so many times the range of most of them, or by half an
# interval where they hardly do.
_SLACK, _LEAST = 3.0, 0.5
_MOST = (0.1, 0.9)
_BLOCK = 32


def lost_time(
    time: Float64[np.ndarray, " samples"], interval: float, window: int
) -> Float64[np.ndarray, " steps"]:
    """By how much the next `window` samples stay behind the even grid through a step's start."""
    late = time - interval * np.arange(time.size)
    # The smallest lateness of the `window` samples from each one on, by doubling.
    earliest = np.concatenate([late[1:], np.full(window, np.inf)])
    seen = 1
    while seen < window:
        shift = min(seen, window - seen)
        earliest = np.minimum(earliest[:-shift], earliest[shift:])
        seen += shift
    return earliest[: time.size - 1] - late[:-1]


def mended(
    time: Float64[np.ndarray, " samples"], interval: float
) -> tuple[Float64[np.ndarray, " samples"], Bool[np.ndarray, " samples"]]:
    """Stamps with the wrong ones replaced by what those before them say, and which these are."""
    wrong = np.zeros(time.size, bool)
    steps = np.diff(time)
    if steps.min() >= -_LEAST * interval:
        return time, wrong
    grid = interval * np.arange(time.size)
    late = time - grid
    blocks = late[: late.size // _BLOCK * _BLOCK].reshape(-1, _BLOCK)
    low, high = np.quantile(blocks, _MOST, axis=1)
    slack = max(_LEAST * interval, _SLACK * float(np.median(high - low)))
    for step in np.flatnonzero(steps < -slack):
        if late[step + 1] - late[step] > -slack:
            # Mended with a step back before it.
            continue
        before, after = _around(late, int(step), slack, GAP * interval)
        between = slice(before + 1, after)
        ends = np.array([at for at in (before, after) if 0 <= at < late.size])
        levels = late[ends]
        off = (late[between] < levels.min() - slack) | (late[between] > levels.max() + slack)
        told = levels[0] + grid[between]
        if ends.size == 2:
            # Of a burst both ends have one stamp.
            told = np.clip(told, *(levels + grid[ends]))
        late[between][off] = (told - grid[between])[off]
        wrong[between] |= off
    return np.where(wrong, late + grid, time), wrong


def _around(
    late: Float64[np.ndarray, " samples"], step: int, slack: float, gap: float
) -> tuple[int, int]:
    """The nearest stamps before and after a step back that continue each other.

    These are the two beside the step where the clock was set for good. One is beyond the end of
    the recording where too few stamps are left there to tell.
    """
    most, beyond = reach(late.size), step + 1
    # Lowest of the stamps so far back, and highest of those so far on.
    lowest = np.minimum.accumulate(late[max(0, beyond - most) : beyond][::-1])
    highest = np.maximum.accumulate(late[beyond : beyond + most])
    on = np.searchsorted(highest, lowest - slack)
    between = np.where(on < highest.size, np.arange(lowest.size) + on, late.size)
    back = int(np.argmin(between))
    before, after = step - back, beyond + int(on[back])
    # Fewer between are of no use as a stretch; more may be one, behind a gap, of a clock set back.
    if between[back] < SHORTEST_STRETCH:
        return before, after
    if between[back] < most and late[after] - late[before] < gap:
        return before, after
    if late.size - beyond < SHORTEST_STRETCH:
        return step, late.size
    if beyond < SHORTEST_STRETCH:
        return -1, beyond
    return step, beyond


def reach(samples: int) -> int:
    """Samples after which stamps have caught up, in a recording of so many."""
    return max(SHORTEST_STRETCH, min(CATCH_UP, samples // 8))


def about_wrong(wrong: Sequence[int], off_s: float) -> tuple[str, ...]:
    """A finding on the samples whose stamps are wrong, the first by `off_s`."""
    if not wrong:
        return ()
    one = len(wrong) == 1
    where = f"{'at' if one else 'the first at'} sample {wrong[0]}, off by {off_s:.4g} s"
    return (
        f"{count(len(wrong), 'time stamp')} {'does' if one else 'do'} not fit those before "
        f"and after, damaged or of rows out of order: {where}. The samples stay in the order of "
        "the file, at the times that the other stamps tell.",
    )
