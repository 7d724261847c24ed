"""Fresh values of a sensor that measures by a clock of its own, slower than that of the log.

Polled at 180 Hz, a sensor that measures at 100 Hz repeats each value once or twice, in a beat of
the two clocks. The log's spectrum then has an image of everything at every multiple of the
sensor's rate, but the fresh values in their order are as plain as any recording.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float, Int
from scipy.signal import find_peaks

from ...physics import SampleHold
from ._format import Repeat, sample_format

# Samples of a segment in which the beat is looked for: longer ones know its phase better, if the
# clocks keep step for so long. And the fewest segments.
_SEGMENTS = (2048, 512, 128)
_FEWEST = 4
# Changes, and repeats, without which nothing can be said.
_FEWEST_CHANGES = 64
# Fresh values of a stretch that can be used, and the share of the samples that such must cover.
_SHORTEST, _MOST = 16, 0.9
# Share of lengths among which the shortest is looked for, and that are multiples of it.
_SHORT, _ALIKE = 0.05, 0.95
# As many times what chance makes of changes a beat must be in a segment.
_CLEAR = 5.0
# Of the beat that two perfect clocks have, so much must be there; of values held at random a
# segment has some hundredths.
_COHERENT = 0.8
# Changes that fall on one fresh value: more, and the clock is another.
_CLASHES = 0.02
# A longer segment whose beat is nearly as good is better.
_AS_GOOD = 0.97
# Of the values that are seen once by a clock faster than half of the log's, so many are enough.
_PART_OF_SINGLES = 0.3
# Of what folds, so many orders are taken as they are, and those beyond as white.
_ORDERS = 8
# Points of a segment's spectrum for each of its ordinates.
_PADDING = 8


class Fresh(NamedTuple):
    """The values that a sensor made, equally far apart by its own clock."""

    values: Float[np.ndarray, " fresh"]
    #: The stretches among them.
    pieces: tuple[tuple[int, int], ...]
    #: Which sample of the log each is.
    at: Int[np.ndarray, " fresh"]
    repeat: Repeat


class _Clock(NamedTuple):
    """Fresh values in each sample of the log, and when."""

    rate: float
    #: Phase of the changes beside `rate` [cycles], at the middles of segments.
    middle: Float[np.ndarray, " segments"]
    phase: Float[np.ndarray, " segments"]
    #: Of what perfect clocks have.
    coherence: float


def fresh_values(
    values: Float[np.ndarray, " samples"], pieces: tuple[tuple[int, int], ...]
) -> Fresh | None:
    """The fresh values, if they are repeated and come by a steady clock of their own.

    None if nothing is repeated, or at random.
    """
    made = sample_format(values, pieces).repeat
    if made is None:
        return None
    beats = [start + _beat(values[start:stop]) for start, stop in pieces]
    beats = [beat for beat in beats if beat.size >= _SHORTEST]
    covered = sum(beat[-1] - beat[0] for beat in beats)
    if covered < _MOST * sum(stop - start for start, stop in pieces):
        return None
    sizes = np.cumsum([0, *(beat.size for beat in beats)])
    at = np.concatenate(beats)
    spans = [int(beat[-1] - beat[0]) for beat in beats]
    repeat = sum(spans) / (at.size - len(beats))
    whole = round(repeat)
    if abs(repeat - whole) * at.size < len(beats):
        # One clock for both, or two that slip by less than a sample.
        made = replace(made, samples=float(whole), deviation=0.0)
    else:
        # Either end is known to a sample.
        made = replace(made, samples=repeat, deviation=repeat / sum(spans))
    found = tuple((int(a), int(b)) for a, b in pairwise(sizes))
    return Fresh(values[at], found, at, made)


def _beat(values: Float[np.ndarray, " samples"]) -> Int[np.ndarray, " fresh"]:
    """Where one stretch has its fresh values; empty where no clock makes them."""
    changes = 1 + np.flatnonzero(np.diff(values))
    if min(changes.size, values.size - changes.size) < _FEWEST_CHANGES:
        return np.empty(0, int)
    slots = _slots(changes, values.size)
    if slots is None:
        return _whole_beat(changes)
    # Rounding may make two fresh values alike, so that not each is a change.
    last = np.zeros(slots[-1] + 1, int)
    last[slots] = changes
    return np.maximum.accumulate(last)


def _whole_beat(changes: Int[np.ndarray, " changes"]) -> Int[np.ndarray, " fresh"]:
    """Fresh values that are all held for the same number of samples; empty if they are not."""
    lengths = np.diff(changes)
    # Where rounding makes neighbours alike, two or three are held as one.
    usual = round(float(np.quantile(lengths, _SHORT)))
    if usual == 1 or np.mean(lengths % usual == 0) < _ALIKE:
        return np.empty(0, int)
    return np.arange(changes[0], changes[-1] + 1, usual)


def logged_density(
    frequency: Float[np.ndarray, " frequencies"],
    stride: float,
    fresh: Callable[[Float[np.ndarray, " frequencies"]], Float[np.ndarray, " frequencies"]],
) -> Float[np.ndarray, " frequencies"]:
    """The density of a log, each fresh value of which is held for `stride` samples.

    `frequency` is in cycles per sample of the log, and what `fresh` takes in cycles per fresh
    value, from 0 to 0.5. Held values are a staircase: the spectrum of the fresh values, repeated
    without end, times a squared sinc. The log takes samples of it, and folds all of that.
    """
    if stride == 1:
        return fresh(frequency)
    # What white noise comes to.
    left = np.array(_white_gain(stride, frequency))
    total = np.zeros_like(frequency)
    for order in range(-_ORDERS, _ORDERS + 1):
        turns = stride * (frequency + order)
        weight = stride * np.sinc(turns) ** 2
        total += weight * fresh(np.abs(turns - np.round(turns)))
        left = left - weight
    return total + np.maximum(left, 0.0) * fresh(np.full(frequency.shape, 0.25))


@jax.jit
def _white_gain(
    stride: Float[Array, ""], frequency: Float[Array, " frequencies"]
) -> Float[Array, " frequencies"]:
    return SampleHold(stride, regular=True).gain(frequency, 1.0)


def _slots(
    changes: Int[np.ndarray, " changes"], samples: int
) -> Int[np.ndarray, " changes"] | None:
    """Which fresh value each change brings, the first being zero."""
    clocks, share = [], changes.size / samples
    for length in _SEGMENTS:
        if samples < _FEWEST * length:
            continue
        parts = _segments(changes, samples, length)
        if not parts.any():
            continue
        line = _line(parts)
        rate = _unmirrored(line, changes, samples)
        chance = np.sqrt(length * share * (1 - share))
        # Beside one half a line and its mirror image are one.
        if 0.5 - line > 2 / length and share * length * np.sinc(rate) > _CLEAR * chance:
            clocks.append(_follow(parts, share, rate))
    best = max((each.coherence for each in clocks), default=0.0)
    if not _COHERENT < best < 1 / _COHERENT:
        return None
    clock = next(each for each in clocks if each.coherence > _AS_GOOD * best)
    slots = np.round(clock.rate * changes - np.interp(changes, clock.middle, clock.phase))
    slots = np.maximum.accumulate(slots.astype(int))
    if np.mean(np.diff(slots) == 0) > _CLASHES:
        return None
    return slots - slots[0]


def _unmirrored(line: float, changes: Int[np.ndarray, " changes"], samples: int) -> float:
    """The rate of which a line is the image, below or above one half [cycles per sample].

    Only a clock faster than half of that of the log makes values that are seen once.
    """
    faster = 1 - line
    # Seen where neither the value before nor the one after is rounded to the same.
    seen = min(changes.size / samples / faster, 1.0) ** 2
    expected = samples * (2 * faster - 1) * seen
    once = np.count_nonzero(np.diff(changes) == 1)
    return faster if once > _PART_OF_SINGLES * expected else line


def _segments(
    changes: Int[np.ndarray, " changes"], samples: int, length: int
) -> Float[np.ndarray, "segments times"]:
    """Ones where the value changes, in segments, less their means."""
    flags = np.zeros(samples)
    flags[changes] = 1.0
    parts = flags[: samples // length * length].reshape(-1, length)
    return parts - parts.mean(axis=1, keepdims=True)


def _line(parts: Float[np.ndarray, "segments times"]) -> float:
    """The first of the lines of the mean spectrum of segments [cycles per sample]."""
    length = _PADDING * parts.shape[1]
    power = np.mean(np.abs(np.fft.rfft(parts, length, axis=1)) ** 2, axis=0)
    # Harmonics are nearly as strong, if values are seldom repeated or often; and the highest may
    # stand at the very end.
    return float(find_peaks(np.append(power, 0.0), height=power.max() / 2)[0][0] / length)


def _follow(parts: Float[np.ndarray, "segments times"], share: float, rate: float) -> _Clock:
    """The phase of the changes beside a clock of about this rate, and how well they keep to it.

    `share` is that of samples that differ from the one before.
    """
    count, length = parts.shape
    total = parts @ np.exp(-2j * np.pi * rate * np.arange(length))
    begin = length * np.arange(count)
    middle = begin + length / 2
    # The beginnings of segments turn the phase; what turns steadily belongs to the rate.
    phase = np.unwrap(2 * np.pi * rate * begin - np.angle(total)) / (2 * np.pi)
    slope = np.polyfit(middle, phase, 1)[0]
    rate, phase = rate - slope, phase - slope * middle
    # Fresh values come each 1/rate samples and are seen at the next sample: phases spread evenly
    # over `rate` cycles. Those that rounding hides are missed everywhere alike.
    perfect = share * length * np.sinc(rate)
    return _Clock(rate, middle, phase, float(np.median(np.abs(total)) / perfect))
