"""Output that wraps around: too large for its integer, it goes on from the other end of the range.

With its ends joined the range is a circle, on which such samples go on as if nothing was there.
Those of two levels, of a converter at its limits, or of spikes have a dip or a heap where the ends
meet, or take far steps there, or seldom go over it from near.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from ._checks import code_width, piled
from ._wording import quantity

# As many values tell how fine the codes are.
_ENOUGH = 200_000
# Bits of a range. Chance gives a small one too easily.
_FEWEST_BITS, _MOST_BITS = 8, 32
# Steps from one end to the other, and samples at each of them, from which something is known.
_FEWEST = 6
_AT_END = 8
# Steps that are neither small nor from end to end, for each of those that are.
_BETWEEN = 0.05
# Samples that tell how dense they are at an end.
_DENSE = 64
# How much denser they may be farther from the end, how near to the outer edge of a band they may be
# on average, and how much the two ends may differ: more of each than chance makes at both ends.
_DIP, _OUTWARD, _UNLIKE = 1.6, 0.65, 3.0
# On the circle, steps over the end beside the others: of rare ones noise makes 4.4.
_FAR = 5.0
# In codes: the root mean square of steps of noise that is told from two levels.
_FINE = 2.8
# Different values at each end: one that stands for no value is alone.
_VALUES = 4
# Two levels change less often than samples that are independent do, and from anywhere: not from
# nearer to the end than others are, on average, by so many deviations.
_SELDOM, _CLEARLY = 0.5, 3.0
# Samples at an end that are told from those in the next codes, by how many of their deviations, and
# the logarithm of how much the first code is beyond what those leave to it.
_IN_CODE, _DEVIATIONS, _BEYOND = 20, 2.0, 0.2


class Wrap(NamedTuple):
    """The range of an output that wraps around."""

    #: In the unit of the samples.
    period: float
    bits: int
    #: Steps from one end to the other.
    steps: int


def why_wraps(samples: Float64[np.ndarray, " usable"], unit: str = "") -> str:
    """Why samples that wrap around, given in `unit`, cannot be analysed; nothing of others."""
    found = wrap(samples)
    if found is None:
        return ""
    period = f"{found.period:.10g}"
    size = (
        "" if found.period == 2**found.bits and not unit else f" ({quantity(found.period, unit)})"
    )
    return (
        f"its output wraps around: {found.steps} times it jumps by {2**found.bits} codes{size} "
        "from one end of its range to the other; record with a wider range, or undo it with "
        f"numpy.unwrap(samples, period={period})"
    )


def wrap(samples: Float64[np.ndarray, " usable"]) -> Wrap | None:
    """The range of samples that go on from the other end when they leave it; None of others."""
    if samples.size < 2:
        return None
    low, high = samples.min(), samples.max()
    middle, range_ = (low + high) / 2, high - low
    steps = np.abs(np.diff(samples))
    far = np.count_nonzero(steps > range_ / 2)
    # Hardly any channel goes beyond this.
    if far < _FEWEST or np.count_nonzero(steps < range_ / 4) == 0:
        return None
    half = samples[samples > middle] if np.median(samples) > middle else samples[samples <= middle]
    for width in (_lattice(half), code_width(half)):
        if width <= 0:
            continue
        bits = int(np.ceil(np.log2(range_ / width + 1) - 1e-5))
        period = width * 2.0**bits
        if _FEWEST_BITS <= bits <= _MOST_BITS and _goes_on(samples, period, width):
            return Wrap(float(period), bits, int(far))
    return None


def _lattice(values: Float64[np.ndarray, " half"]) -> float:
    """The largest width of which all differences are multiples, 0 if arithmetic hides it.

    However few of the codes are met, unlike what `code_width` takes from the smallest differences;
    but digits that were cut off have a lattice of their own.
    """
    known = np.unique(values[:_ENOUGH])
    steps = np.diff(known)
    # Errors of a large multiple would pass for a remainder.
    steps = steps[steps <= np.median(steps)] if steps.size else steps
    error = 1e4 * np.finfo(float).eps * float(np.abs(known).max(initial=0.0))
    width = 0.0
    while steps.size:
        width = float(steps.min())
        steps = np.abs(steps - width * np.rint(steps / width))
        steps = steps[steps > error]
    if width <= 10 * error:
        return 0.0
    # Over the whole range they are known best.
    whole = known[-1] - known[0]
    return float(whole / np.rint(whole / width))


def _goes_on(samples: Float64[np.ndarray, " usable"], period: float, width: float) -> bool:
    """Whether samples are as one where the ends of their range are joined to a circle."""
    steps = np.diff(samples)
    over = np.abs(steps) > period / 2
    near = np.abs(np.where(over, np.abs(steps) - period, steps))
    if np.count_nonzero(over) < _FEWEST:
        return False
    if np.count_nonzero(near > period / 4) > _BETWEEN * np.count_nonzero(over):
        return False
    if np.sqrt(np.mean(near**2)) < _FINE * width:
        return False
    # A value that is held has no step of its own.
    usual = near[~over & (near > 0)]
    if usual.size == 0:
        return False
    if np.median(near[over]) > _FAR * np.median(usual):
        return False
    middle = (samples.min() + samples.max()) / 2
    return _crosses(samples > middle, over, np.abs(samples - middle)) and _is_even(
        samples, period, width
    )


def _crosses(
    high: Bool[np.ndarray, " usable"],
    over: Bool[np.ndarray, " steps"],
    apart: Float64[np.ndarray, " usable"],
) -> bool:
    """Whether samples go over the end often, or from near it; `apart` is how far from middle."""
    share = float(np.mean(high))
    if np.mean(over) > _SELDOM * 2 * share * (1 - share):
        return True
    ranks = []
    for side in (high, ~high):
        near_last = np.sort(apart[side])
        before = apart[:-1][over & side[:-1]]
        # Of equal values the middle one.
        place = np.searchsorted(near_last, before) + np.searchsorted(near_last, before, "right")
        ranks.append(1 - place / (2 * near_last.size))
    rank = np.concatenate(ranks)
    return bool(np.mean(rank) < 0.5 - _CLEARLY / np.sqrt(12 * rank.size))


def _is_even(samples: Float64[np.ndarray, " usable"], period: float, width: float) -> bool:
    """Whether samples are as dense on both sides of where the ends of the range meet."""
    low, high = samples.min(), samples.max()
    # The end itself is in the middle of what is not met.
    beyond = (period - (high - low)) / 2
    ends = [np.sort(each[each < period / 4]) for each in (samples - low, high - samples)]
    fewest = min(each.size for each in ends)
    if fewest < _AT_END or any(np.unique(each).size < _VALUES for each in ends):
        return False
    if _is_heap(ends[0], ends[1], width):
        return False
    number = min(_DENSE, fewest // 2)
    reach = min(each[number - 1] for each in ends) + width / 2
    band = beyond + reach
    inner = [beyond + each[each < reach] for each in ends]
    outer = [np.count_nonzero((each >= reach) & (each < reach + band)) for each in ends]
    sizes = [near.size for near in inner]
    if max(sizes) > _UNLIKE * min(sizes):
        return False
    return not all(
        more > _DIP * near.size or near.mean() > _OUTWARD * band
        for near, more in zip(inner, outer, strict=True)
    )


def _is_heap(
    one: Float64[np.ndarray, " one"], other: Float64[np.ndarray, " other"], width: float
) -> bool:
    """Whether a heap stands on an end: of a converter at its limit, or of what stands for no value.

    A steep tail falls as fast from code to code, but no faster from the other end to its own.
    """
    heaps = [piled(each / width) or _is_beyond(each / width) for each in (one, other)]
    fewer, more = sorted(np.count_nonzero(each < width / 2) for each in (one, other))
    return all(heaps) or (any(heaps) and bool(more > _UNLIKE * fewer))


def _is_beyond(codes: Float64[np.ndarray, " end"]) -> bool:
    """Whether an end has more samples than the next two codes leave to one that is log-concave."""
    last, next_one, after = (np.count_nonzero(np.abs(codes - k) < 0.5) for k in range(3))
    if min(last, next_one, after) < _IN_CODE:
        return False
    more = np.log(last * after / next_one**2)
    return bool(more > max(_BEYOND, _DEVIATIONS * np.sqrt(1 / last + 4 / next_one + 1 / after)))
