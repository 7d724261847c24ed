"""Intervals of samples, as flags and as `[start, stop)`."""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool


def runs(flags: Bool[np.ndarray, " samples"]) -> list[tuple[int, int]]:
    """`[start, stop)` of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def widened(flags: Bool[np.ndarray, " samples"], margin: int) -> Bool[np.ndarray, " samples"]:
    """True as well where a true value is at most `margin` samples away."""
    near = flags.copy()
    for a, b in runs(flags):
        near[max(a - margin, 0) : b + margin] = True
    return near


def cut_out(
    pieces: tuple[tuple[int, int], ...], intervals: list[tuple[int, int]]
) -> tuple[tuple[int, int], ...]:
    """The stretches less some intervals; what is left must be long enough to use."""
    left = []
    for start, stop in pieces:
        at = start
        for a, b in sorted(intervals):
            if a < stop and b > start:
                if a - at >= 64:
                    left.append((at, a))
                at = max(at, b)
        if stop - at >= 64:
            left.append((at, stop))
    return tuple(left)


def joined(
    pieces: tuple[tuple[int, int], ...],
    intervals: list[tuple[int, int]],
    breaks: tuple[int, ...] = (),
) -> tuple[tuple[int, int], ...]:
    """The stretches and some intervals together, one where they touch but at a break."""
    flags = np.zeros(max(stop for _, stop in (*pieces, *intervals)), bool)
    for start, stop in (*pieces, *intervals):
        flags[start:stop] = True
    whole = []
    for start, stop in runs(flags):
        ends = [start, *(each for each in breaks if start < each < stop), stop]
        whole += pairwise(ends)
    return tuple(whole)
