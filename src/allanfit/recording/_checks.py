"""What is wrong with samples, told from the samples alone."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64
from scipy.stats import nbinom

from ..physics import AngleCodes
from ._angle_codes import angle_codes
from ._lateness import SHORTEST_STRETCH
from ._no_sensor import why_counter
from ._spikes import about_spikes, written
from ._wording import count, percent, quantity

FEWEST_SAMPLES = 256
"""Below this no noise coefficient can be told from another."""

# The squares of larger and smaller ones leave the range of floating point.
_LARGEST = 1e100
_SMALLEST = 1e-100
# As many values tell how coarse the codes are, and they are quick to sort.
_ENOUGH = 200_000
# As many samples on one extreme value may be no chance, if they are as many times those expected,
# and chance is less than this.
_PILE, _HIGHER, _NO_CHANCE = 3, 3.0, 1e-4
# What is nearer than this to an extreme value, of the whole range, is the same but for arithmetic.
_SAME = 1e-9
# Samples in the bin next to an extreme, at least.
_IN_BIN = 8
# Codes as wide as the noise cut a tail into few bins. There as many samples at the end are told by
# how the codes before it fall, if they are so many times more and as many deviations beyond chance.
_IN_CODE, _BEYOND, _DEVIATIONS = 50, 1.3, 5.0
# Parts of a code within which a value lies on one, codes over which their width is known as well,
# and how much alike the places of values between two codes are then.
_AT_CODE, _NEAR, _ALIKE = 0.02, 8.0, 0.95
# Of repeats in a dead band as many are of one value.
_NEARLY_ALL = 0.8
# Samples apart at which equal ones are no held ones; drifts move them apart as well.
_APART = (8, 16, 32, 64, 128)
# So many repeats beyond chance, and as many of its deviations, are none of chance, though few.
_FEWEST_REPEATS, _CLEARLY = 10, 7.0
_WINDOW = 64


def split(
    good: Bool[np.ndarray, " samples"], breaks: tuple[int, ...]
) -> tuple[tuple[int, int], ...]:
    """`[start, stop)` of each run of good samples between `breaks` that is long enough to use."""
    starts = good.copy()
    starts[1:] &= ~good[:-1]
    starts[list(breaks)] = good[list(breaks)]
    stops = good.copy()
    stops[:-1] &= ~good[1:]
    before = np.asarray(breaks, dtype=int) - 1
    stops[before] = good[before]
    runs = zip(np.flatnonzero(starts).tolist(), (np.flatnonzero(stops) + 1).tolist(), strict=True)
    return tuple((start, stop) for start, stop in runs if stop - start >= SHORTEST_STRETCH)


def usable(
    samples: Float64[np.ndarray, " samples"], stretches: tuple[tuple[int, int], ...]
) -> Float64[np.ndarray, " usable"]:
    """The samples inside the stretches, end to end."""
    if stretches == ((0, samples.size),):
        return samples
    return np.concatenate([samples[:0], *(samples[start:stop] for start, stop in stretches)])


def why_useless(samples: Float64[np.ndarray, " usable"]) -> str:
    """Why these usable samples cannot be analysed at all; empty when they can."""
    if samples.size < FEWEST_SAMPLES:
        return (
            f"it has {count(samples.size, 'usable sample')}, and at least {FEWEST_SAMPLES} are "
            "needed"
        )
    if samples.min() == samples.max():
        return "it is constant"
    if too_large := why_too_large(samples):
        return too_large
    if (range_ := np.ptp(samples)) < _SMALLEST:
        return f"it varies by {range_:.1g} in all, which no sensor can tell"
    return why_counter(samples)


def why_too_large(samples: Float64[np.ndarray, " finite"]) -> str:
    """Why finite samples are beyond what can be squared; empty if they are not."""
    largest = max(-samples.min(), samples.max()) if samples.size else 0.0
    if largest <= _LARGEST:
        return ""
    return f"it holds values as large as {largest:.1g}, which no sensor gives"


def about_samples(
    samples: Float64[np.ndarray, " samples"],
    still: Bool[np.ndarray, " samples"],
    stretches: tuple[tuple[int, int], ...],
    unit: str,
    rate_hz: float,
) -> tuple[str, ...]:
    """Findings on the samples of one channel, given in the user's `unit`; `still` are frozen."""
    values = usable(samples, stretches)
    width = code_width(values)
    sigma = local_deviation(values)
    coarse = wide(width, sigma or fresh_deviation(values))
    ends = () if coarse else rails(values, width)
    lost = _about_lost(samples, still, stretches, values.size, rate_hz)
    codes = angle_codes(values, width)
    if codes is not None:
        return (*lost, _about_angle(codes, width, unit))
    return (
        *lost,
        *_about_rails(values, ends, unit),
        *_about_repeats(values, ends, width, unit),
        *(() if coarse else about_spikes(values, unit)),
        *(_about_width(values, width, sigma, unit) if coarse else ()),
    )


def code_width(samples: Float64[np.ndarray, " usable"]) -> float:
    """The difference between neighbouring output codes, in the unit of `samples`.

    Tiny for samples that are not rounded at all, 0 for constant ones.
    """
    if samples.size == 0:
        return 0.0
    values = np.sort(_fresh(samples)[:_ENOUGH])
    if values[0] == values[-1]:
        return 0.0
    # The end of a range need not be a code.
    inside = values[(values > values[0]) & (values < values[-1])]
    values = inside if inside.size and inside[0] < inside[-1] else values
    low, high = np.quantile(values, [0.05, 0.95])
    steps = np.diff(values)
    steps = steps[steps > 0]
    # A code stored in floating point may come out as several values close together. But where
    # hardly a step is wider than that, the range holds many codes, and those steps are holes.
    wide = steps > 1e-4 * (high - low)
    if np.mean(wide) > 0.01:
        steps = steps[wide]
    small = np.quantile(steps, 0.1)
    return float(steps[steps < 1.5 * small].mean())


def codes_of(samples: Float64[np.ndarray, " usable"]) -> AngleCodes | None:
    """How an angle moves among wide codes, where `samples` are its differences in such codes."""
    return angle_codes(samples, code_width(samples[:_ENOUGH]))


def local_deviation(samples: Float64[np.ndarray, " usable"]) -> float:
    """Standard deviation within short windows, in most of them: no drift and no outliers."""
    length = min(_WINDOW, samples.size)
    windows = samples[: samples.size // length * length].reshape(-1, length)
    # From the first value, so that a window of equal ones has a deviation of exactly 0.
    return float(np.median((windows - windows[:, :1]).std(axis=1)))


def fresh_deviation(samples: Float64[np.ndarray, " usable"]) -> float:
    """Standard deviation of the values that are new: of those held longer than a window too."""
    return float(np.std(_fresh(samples)))


def wide(width: float, deviation: float) -> bool:
    """Whether codes of this width are wide beside the noise, so that samples show few of them."""
    return width > 0.75 * deviation


def _fresh(samples: Float64[np.ndarray, " usable"]) -> Float64[np.ndarray, " fresh"]:
    """The first of each run of equal values, so that no code fills more than half of them."""
    return samples[np.concatenate([[True], np.diff(samples) != 0])]


def _about_lost(
    samples: Float64[np.ndarray, " samples"],
    still: Bool[np.ndarray, " samples"],
    stretches: tuple[tuple[int, int], ...],
    used: int,
    rate_hz: float,
) -> tuple[str, ...]:
    broken = int(np.count_nonzero(~np.isfinite(samples)))
    frozen = int(np.count_nonzero(still))
    stray = samples.size - used - broken - frozen
    findings = ()
    if broken:
        findings += (
            f"Left out as missing or not finite: {count(broken, 'sample')} "
            f"({broken / rate_hz:.3g} s); the longest stretch between has "
            f"{max(stop - start for start, stop in stretches) / rate_hz:.4g} s.",
        )
    if frozen:
        runs = int(np.count_nonzero(still[1:] & ~still[:-1]))
        findings += (
            f"Left out as frozen: {count(frozen, 'sample')} in {count(runs, 'run')} "
            f"({frozen / rate_hz:.3g} s) repeat one value, as a sensor that hangs or a logger "
            "that fills up a gap makes them.",
        )
    if stray:
        findings += (
            f"Left out in stretches shorter than {SHORTEST_STRETCH} samples: "
            f"{count(stray, 'sample')} ({stray / rate_hz:.3g} s).",
        )
    return findings


def rails(values: Float64[np.ndarray, " usable"], width: float) -> tuple[float, ...]:
    """The extreme values at which samples pile up."""
    # A value that is held counts once, however long it is.
    fresh = _fresh(values)
    ends = (fresh.min(), fresh.max())
    margin = _SAME * (ends[1] - ends[0])
    if not np.any((fresh > ends[0] + margin) & (fresh < ends[1] - margin)):
        # Counts of none and one are what a sensor counts so fast, and no rails.
        return ()
    codes = [np.abs(fresh - end) / width for end in ends]
    # Of one code and less the mean itself may stand on the last.
    noisy = float(np.median(np.abs(np.diff(fresh)))) > 0.99 * width if fresh.size > 1 else False
    found = tuple(
        float(end)
        for end, each in zip(ends, codes, strict=True)
        if piled(each) or _between(each) or (noisy and _stops_falling(each))
    )
    # Spikes that are cut off stand at both ends, far from all others.
    return () if len(found) == 1 and written(values, fresh, found[0]) else found


def _between(codes: Float64[np.ndarray, " fresh"]) -> bool:
    """Whether several samples stand at an extreme that is no code: cut off after rounding.

    The values next to it are whole codes apart then, and none is whole codes away from it.
    """
    near = codes[(codes > _AT_CODE) & (codes < _NEAR)]
    if np.count_nonzero(codes <= _AT_CODE) < _PILE or near.size < _IN_BIN:
        return False
    turn = np.mean(np.exp(2j * np.pi * near))
    return bool(np.abs(turn) > _ALIKE and np.abs(np.angle(turn)) > 2 * np.pi * 2 * _AT_CODE)


def piled(codes: Float64[np.ndarray, " fresh"]) -> bool:
    """Whether more samples stand at an extreme than the tail of their distribution has there.

    `codes` are the distances from it, in codes. A tail falls toward its end, so that a code there
    has no more than those of the bin next to it on average; and as that bin has few samples, what
    stands at the extreme by chance is a negative binomial variate.
    """
    there = np.count_nonzero(codes < 0.5)
    tail = codes[codes >= 0.5]
    if there < _PILE or tail.size < _IN_BIN:
        return bool(there >= _PILE)
    width = max(1.0, float(np.ceil(np.partition(tail, _IN_BIN - 1)[_IN_BIN - 1])))
    near = np.count_nonzero(tail < width + 0.5)
    # One is always at the extreme.
    chance = nbinom.sf(there - 2, near, width / (width + 1))
    return bool(there > _HIGHER * near / width) and bool(chance < _NO_CHANCE)


def _stops_falling(codes: Float64[np.ndarray, " fresh"]) -> bool:
    """Whether a tail that falls toward the end has more there than it falls to.

    Of a normal distribution, as of all that are log-concave, a code has no more than the square of
    the next one's share over that of the one after, however wide the codes are.
    """
    last, next_one, after = (np.count_nonzero(np.abs(codes - k) < 0.5) for k in range(3))
    if min(last, next_one, after) < _IN_CODE or next_one >= after:
        return False
    more = np.log(last * after / next_one**2)
    deviation = np.sqrt(1 / last + 4 / next_one + 1 / after)
    return bool(more > np.log(_BEYOND) and more > _DEVIATIONS * deviation)


def _about_rails(
    values: Float64[np.ndarray, " usable"], ends: tuple[float, ...], unit: str
) -> tuple[str, ...]:
    return tuple(
        f"{percent(np.mean(values == rail))} of the samples stand exactly at the extreme value "
        f"{quantity(rail, unit)}: the output was saturated."
        for rail in ends
    )


class Repeats(NamedTuple):
    """Samples that repeat the one before, as shares of all samples."""

    share: float
    #: What rounding makes of fresh values, as it seems, and at most.
    by_chance: float
    most_by_chance: float
    #: Whether the share is beyond chance, at values of all kinds: the sensor is read too fast.
    beyond: bool
    #: The one value at which it is beyond chance, as within a dead band; NaN if there is none.
    dead: float = np.nan
    #: Whether there are few, but by far more than chance makes: a logger filled in for others.
    few: bool = False


def repeated(
    values: Float64[np.ndarray, " usable"], ends: tuple[float, ...], width: float
) -> Repeats:
    """How many samples repeat the one before, and whether chance explains that.

    First differences of noise are log-concave in distribution, so two bins next to zero bound
    what zero may hold by chance. Values mixed from coarser codes make other steps frequent too,
    so zero has to stand out of these as well. Held samples do both, however coarse the codes are.
    Where a converter misses codes, or has some that are wide, samples far from one another are
    equal as often. Samples at the `ends` of the range do not count.
    """
    steps = np.diff(values)
    steps = steps[~np.isin(values[1:], ends)]
    repeats = np.count_nonzero(steps == 0) / values.size
    changes = steps[steps != 0]
    codes = np.round(np.abs(changes[:_ENOUGH]) / width)
    # Where a few values are far apart beside the others, no bin holds them all.
    bin_codes = min(max(1, int(np.median(codes)) // 2), _ENOUGH)
    # Both as the share of all steps that falls on one code, either sign.
    scale = changes.size / (codes.size * steps.size * 2 * bin_codes)
    near = np.count_nonzero(codes <= bin_codes) * scale
    far = np.count_nonzero((codes > bin_codes) & (codes <= 2 * bin_codes)) * scale
    if far <= 0.1 * near:
        # Hardly a step of more than one code: rounding explains any number of repeats.
        return Repeats(float(repeats), float(repeats), 1.0, False)
    most = max(
        near * (near / far) ** ((bin_codes + 1) / (2 * bin_codes)),
        np.unique_counts(codes).counts.max() / codes.size * changes.size / (2 * steps.size),
    )
    beyond = repeats >= max(0.01 + most, 1.5 * most, 10 / values.size)
    dead = _one_value(values[1:][np.diff(values) == 0]) if beyond else np.nan
    # A parabola in the logarithm, as that of a normal distribution, through the same two bins.
    step_codes = np.arange(1, 2 * bin_codes + 1).reshape(2, bin_codes)
    inner, outer = np.mean(step_codes**2, axis=1)
    likely = near * (near / far) ** (inner / (outer - inner)) if far > 0 else most
    apart = _equal_apart(values, ends) if beyond else 0.0
    held = beyond and not np.isfinite(dead) and repeats >= max(0.01 + apart, 1.5 * apart)
    chance = most * values.size
    clear = max(1.5 * chance, chance + _CLEARLY * chance**0.5 + _FEWEST_REPEATS)
    few = not beyond and repeats * values.size >= clear
    return Repeats(
        float(repeats), float(min(likely, most)), float(most), bool(held), dead, bool(few)
    )


def _equal_apart(values: Float64[np.ndarray, " usable"], ends: tuple[float, ...]) -> float:
    """The share of samples that equal another so far from them that none is held as long."""
    inside = ~np.isin(values, ends)
    lags = [lag for lag in _APART if lag < values.size]
    return min(float(np.mean((values[lag:] == values[:-lag]) & inside[lag:])) for lag in lags)


def _one_value(again: Float64[np.ndarray, " repeats"]) -> float:
    """The value of nearly all repeats; NaN if they have many, as those of a slow sensor do."""
    found, times = np.unique_counts(again)
    return float(found[np.argmax(times)]) if times.max() > _NEARLY_ALL * again.size else np.nan


def _about_repeats(
    values: Float64[np.ndarray, " usable"], ends: tuple[float, ...], width: float, unit: str
) -> tuple[str, ...]:
    found = repeated(values, ends, width)
    if np.isfinite(found.dead):
        return (
            f"{percent(np.mean(values == found.dead))} of the samples are exactly "
            f"{quantity(found.dead, unit)}, many more than are near it: values within a dead band "
            "come out as one, and N is not that of the sensor. Switch the dead band off, or record "
            "what is before it.",
        )
    if found.few:
        return (
            f"{found.share * values.size:.0f} of the {values.size} samples are exactly "
            f"the one before, where chance explains {found.most_by_chance * values.size:.0f} at "
            "most: a logger repeats a value when it has no fresh one. Time stamps do not tell of "
            "samples that were lost so.",
        )
    if not found.beyond:
        return ()
    return (
        f"{percent(found.share)} of the samples repeat the one before, where chance explains "
        f"{percent(found.most_by_chance)} at most: the sensor is read faster than it gives fresh "
        "values.",
    )


def _about_angle(codes: AngleCodes, width: float, unit: str) -> str:
    return (
        f"The samples are differences of an angle (or a velocity) that was rounded: one code is "
        f"{quantity(width, unit)} for a sample, of which the noise moves it by {codes.move:.2g}. "
        "Q is the error of these codes, which is alike in neighbouring samples; `allanfit fit` and "
        "`allanfit explain` allow for that, and N is that of the sensor."
    )


def _about_width(
    values: Float64[np.ndarray, " usable"], width: float, sigma: float, unit: str
) -> tuple[str, ...]:
    repeats = np.count_nonzero(np.diff(values) == 0) / values.size
    size, then = "larger than the noise", "rounding hides part of the noise"
    if sigma:
        size = f"as large as the noise (standard deviation {quantity(sigma, unit)})"
        then = "rounding changes N, and `allanfit explain` tells by how much"
    return (
        f"The code width, {quantity(width, unit)}, is {size}, and {percent(repeats)} of the "
        f"samples repeat the one before: {then}.",
    )
