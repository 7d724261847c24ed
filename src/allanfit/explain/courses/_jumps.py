"""What a knock leaves behind: another mean than before.

The knock is cut out, and stretches on either side of a cut have means of their own. So the jump
from one to the other is no course of the better model, and is told by itself.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .._state import Investigation

# Samples whose means are compared: the fewest, and by how many times more until too few are left.
_FEWEST, _MORE = 64, 4
# Elsewhere as many such differences tell how much they scatter, and a jump is as many times that.
_PLACES, _CLEAR = 40, 7.0


class Jump(NamedTuple):
    """A change of the mean across a knock."""

    #: The first sample after the knock.
    after: int
    #: By how much, and the standard deviation of that [u].
    height: float
    deviation: float


def jumps(state: Investigation) -> list[Jump]:
    """Where the mean after a knock is another than before it, beyond what it does elsewhere."""
    begins = {start: (start, stop) for start, stop in state.pieces}
    ends = {stop: (start, stop) for start, stop in state.pieces}
    calm = state.calm
    longest = calm[slice(*state.longest)]
    found = []
    for start, stop in state.knocks:
        if start in ends and stop in begins:
            before, after = calm[slice(*ends[start])], calm[slice(*begins[stop])]
            best = _clearest(before, after, stop - start, longest)
            if best is not None:
                found.append(Jump(stop, *best))
    return found


def _clearest(
    before: Float[np.ndarray, " before"],
    after: Float[np.ndarray, " after"],
    gap: int,
    longest: Float[np.ndarray, " longest"],
) -> tuple[float, float] | None:
    """Height and standard deviation by the length that tells most clearly; None if none does."""
    best, length = None, _FEWEST
    while length <= min(before.size, after.size):
        usual = _differences(longest, length, gap)
        if usual.size < _PLACES:
            break
        deviation = float(np.sqrt(np.mean(usual**2)))
        height = float(after[:length].mean() - before[-length:].mean())
        if best is None or abs(height) / deviation > abs(best[0]) / best[1]:
            best = height, deviation
        length *= _MORE
    return best if best is not None and abs(best[0]) > _CLEAR * best[1] else None


def _differences(
    x: Float[np.ndarray, " samples"], length: int, gap: int
) -> Float[np.ndarray, " places"]:
    """Of the means of `length` samples with a gap between, at places half a length apart."""
    sums = np.concatenate([[0.0], np.cumsum(x - x.mean())])
    first = np.arange(0, x.size - 2 * length - gap + 1, max(length // 2, 1))
    second = first + length + gap
    return (sums[second + length] - sums[second] - sums[first + length] + sums[first]) / length
