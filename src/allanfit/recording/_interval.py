"""The interval at which most samples come, whatever gaps, losses and bursts there are."""

import numpy as np
from jaxtyping import Float64, Int64

from ._lateness import CATCH_UP, GAP

# Where stamps are rounded to half an interval or less, a step differs from the median step by up to
# half of that (two clock steps and one more), a step with a loss by at least 2/3 (three and five).
_NEAR = 0.6
# Steps between the first and the last of these quantiles are alike. Late samples and losses make
# some too long; fewer are too short, where stamps catch up.
_ALIKE = (0.1, 0.5, 0.85)
# So much of the recording has alike steps of a coarse clock, and fewer steps tell nothing.
_MOST, _FEWEST = 0.9, 3


def typical_interval(time: Float64[np.ndarray, " samples"]) -> float:
    """The interval away from gaps and losses, evened out over the shortest window that does."""
    new = fresh(time)
    if new.size:
        counts, steps = np.diff(new), np.diff(time[new])
        near = _near(steps) & _near(counts)
        return float(np.sum(steps[near]) / np.sum(counts[near]))
    steps = np.diff(time)
    low, typical, high = np.quantile(steps, _ALIKE)
    reach = _NEAR * typical
    if max(typical - low, high - typical) < reach and _few_pauses(steps, typical):
        # The median of stamps that a coarse clock rounds is a whole number of its steps.
        typical = np.mean(steps[np.abs(steps - typical) < reach])
        # That leaves out steps over losses. Once they are counted too, the roundings cancel.
        counts = np.round(steps / typical)
        few = np.abs(counts) < GAP
        return float(np.sum(steps[few]) / np.sum(counts[few]))
    for window in (4, 16, 64, 256, CATCH_UP):
        if 4 * window > time.size:
            break
        low, typical, high = np.quantile((time[window:] - time[:-window]) / window, _ALIKE)
        if high - low < 0.25 * typical and _few_pauses(steps, typical):
            break
    return float(typical)


def fresh(time: Float64[np.ndarray, " samples"]) -> Int64[np.ndarray, " fresh"]:
    """Index of each stamp that differs from the one before, where a coarse clock repeats most.

    None where the numbers of repeats or the steps between are unlike: as of a computer that is busy
    now and then, and stamps late what came meanwhile.
    """
    new = np.flatnonzero(np.diff(time)) + 1
    if not _FEWEST <= new.size <= time.size // 2:
        return new[:0]
    counts = np.diff(new)
    alike = _near(counts) & _near(np.diff(time[new]))
    return new if np.sum(counts[alike]) > _MOST * np.sum(counts) else new[:0]


def _near(steps: np.ndarray) -> np.ndarray:
    """Which of them are about as long as most."""
    typical = np.median(steps)
    return np.abs(steps - typical) < _NEAR * typical


def _few_pauses(steps: Float64[np.ndarray, " steps"], typical: float) -> bool:
    """Whether these are no bursts, in which steps are alike too."""
    return bool(np.mean(steps > 5 * typical) < 0.01)
