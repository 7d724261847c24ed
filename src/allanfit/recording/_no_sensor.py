"""Columns that no sensor wrote: counters, time stamps, flags."""

import numpy as np
from jaxtyping import Float64

# Fewer changes may go the same way by chance.
_FEWEST_CHANGES = 16
# Of the changes of noise, half go each way; of a counter that has three values, a third go back.
_MOST_BACK = 0.4
# As many steps of a counter that has three values are alike, and damage leaves the most of them.
_EVEN = 0.6
# A flag has no more values, and changes at a smaller share of samples than noise does.
_MOST_STATES, _MOST_CHANGES = 16, 0.1


def why_counter(samples: Float64[np.ndarray, " usable"]) -> str:
    """Why samples that count up, or down, are no noise; nothing of others."""
    steps = np.diff(samples)
    if steps.size and (steps.min() > 0 or steps.max() < 0):
        how = "changes the same way at every sample"
    elif np.count_nonzero(steps) < _FEWEST_CHANGES:
        return ""
    elif _is_one_way(steps) or _is_one_way(-steps):
        how = "changes the same way at every sample, apart from repeats and from beginning anew"
    elif _is_even(steps):
        how = "changes by the same amount at most samples"
    else:
        return ""
    return f"it {how}, as a counter or time stamps do, or an angle or a velocity that was summed up"


def _is_one_way(steps: Float64[np.ndarray, " steps"]) -> bool:
    """Whether all of them rise, but for those that go back by more than half the range."""
    back = steps < 0
    values = np.cumsum(steps)
    if (steps[back] >= -0.5 * np.ptp(np.append(values, 0.0))).any():
        return False
    # Two values by turns are the lowest bit of a counter; held at random they are a flag.
    few = np.count_nonzero(back) < _MOST_BACK * np.count_nonzero(steps)
    return bool(few or (steps != 0).all())


def _is_even(steps: Float64[np.ndarray, " steps"]) -> bool:
    """Whether most of them are alike, as those of noise never are."""
    usual = np.median(steps)
    return bool(usual != 0 and np.mean(np.abs(steps - usual) < 1e-6 * abs(usual)) >= _EVEN)


def why_flag(samples: Float64[np.ndarray, " usable"]) -> str:
    """Why samples of a few whole numbers that seldom change are no noise; nothing of others.

    Coarse codes of a sensor in counts may look the same, and hold as little of its noise.
    """
    changes = np.count_nonzero(np.diff(samples))
    if not 0 < changes < _MOST_CHANGES * samples.size or (samples % 1).any():
        return ""
    states = np.unique(samples).size
    if states > _MOST_STATES:
        return ""
    return (
        f"it has {states} values, all whole numbers, and seldom changes, as a button or a flag "
        "does; if it is a sensor, ask for it with --channel"
    )
