"""Where in a record courses are looked for: scans of means over blocks, in the noise as it is."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from .._chance import course_log_chance
from ..spectrum._model import Model
from ..spectrum._ordinates import Ordinates
from ..spectrum._structure import Data
from ._blocks import FINE_BLOCKS, Scan, Stretch, Waves, blocks_of, length_of
from ._course import Course, late, ordinate_variance, oscillation, step, warm_up
from ._step_scores import step_sums

# A shorter stretch of a record with gaps is looked at for steps if it has so many samples; slow
# courses are looked for in so many stretches.
_LONG, _SLOW_PIECES = 256, 4
_SHORTLIST = 3
# Log of the chance of a scan's maximum below which a course is fitted at all.
_WORTH = float(np.log(0.3))
# Slower than this many periods in the record, an oscillation is no line yet.
_FEWEST_PERIODS, _TOO_FEW_PERIODS = 1.5, 1.0
_MOST_PERIODS = 160
# Half the turn of a block [rad] below which a wave does not turn.
_SAME = 1e-9
# White noise of so many times Q^2/N^2 samples is stronger than one error of the angle.
_FIRST_ERROR = 4.0
# A sensor follows its surroundings late by such parts of the record, or its thermometer does.
_LAGS = (0.0, 0.003, 0.01, 0.03, 0.1, -0.003, -0.01, -0.03, -0.1)


def propose(
    samples: int,
    pieces: tuple[tuple[int, int], ...],
    values: Float[np.ndarray, " samples"],
    spectrum: Ordinates,
    model: Model,
    data: Data,
    drivers: dict[str, Float[np.ndarray, "samples columns"]],
) -> list[Course]:
    """The courses that look most promising, a few of each name.

    Block means of the stretches, and a scan that keeps the noise as it is; once as fitted, and
    once with nearly no random walk, since a course hides behind the walk that it made.
    """
    longest = max(pieces, key=length_of)
    slow = blocks_of(values, sorted(sorted(pieces, key=length_of)[-_SLOW_PIECES:]))
    fine = blocks_of(
        values, [p for p in pieces if p == longest or length_of(p) >= _LONG], FINE_BLOCKS
    )
    flat = ordinate_variance(spectrum, model, data)
    calm = model._replace(
        theta=np.where(np.arange(model.theta.size) == 3, model.theta - 4.0, model.theta)
    )
    found: list[Course] = []
    # How far a scan goes is a matter of the noise that is believed in.
    paths: dict[str, float] = {}
    # The first and the last error of the angle are rates of which no spectrum knows, soon over.
    brief = _FIRST_ERROR * float(np.exp(np.clip(model.theta[0] - model.theta[1], -50, 50)))
    for variance in (flat, ordinate_variance(spectrum, calm, data)):
        scan = slow.scan(spectrum, variance)
        found += _oscillations(scan, longest, samples)
        found += _warm_ups(scan, samples, paths, brief)
        found += _steps(fine.scan(spectrum, variance), samples, paths, brief)
    for name, columns in drivers.items():
        found += _driven(name, columns, samples)
    return found


def _path(cosines: Float[np.ndarray, " steps"]) -> float:
    """The length of a path on the sphere, from the cosines of its steps."""
    return float(np.sum(np.arccos(np.clip(np.abs(cosines), 0.0, 1.0))))


def _oscillations(scan: Scan, longest: tuple[int, int], samples: int) -> list[Course]:
    """Each stretch by itself at first, and near what is best all of them with one phase."""
    blocks, length = scan.blocks, length_of(longest)
    most = max(blocks.counts)
    periods = np.arange(_FEWEST_PERIODS, min(_MOST_PERIODS, most / 8), 0.25)
    if periods.size == 0:
        return []
    gains, sizes = np.zeros(periods.size), 0
    for stretch in scan.stretches:
        part = stretch.count * blocks.size / length
        # Too few periods in a shorter stretch are no more than its ramp.
        heard = periods * part > _TOO_FEW_PERIODS
        if heard.any():
            waves = _slow_waves(stretch.count, part, periods.size)
            gains[heard] += stretch.gains(waves)[heard]
            sizes += 2
    courses, time = [], blocks.time - longest[0]
    every = np.arange(samples) - float(longest[0])
    # Each whole period is a place of its own, and the best lies between them.
    places = 3.0 * float(periods[-1])
    reach = float(time[-1] - time[0]) / length
    closely = 2 * int(np.ceil(4 * min(reach, _SLOW_PIECES))) + 1
    for at in _tops(gains, 4, sizes, places):
        fine = (periods[at] + np.linspace(-0.25, 0.25, closely)) / length
        each = [oscillation(float(frequency), time).draw() for frequency in fine]
        best_place = float(fine[int(np.argmax(scan.gains(np.stack(each, axis=1))))])
        courses.append(oscillation(best_place, every)._replace(places=places))
    return courses


@lru_cache(maxsize=_SLOW_PIECES)
def _slow_waves(count: int, part: float, waves: int) -> Waves:
    """The cosines and sines that are looked for in every round.

    The `count` blocks of a stretch are a `part` of the longest, in which periods are counted.
    """
    periods = (_FEWEST_PERIODS + 0.25 * np.arange(waves)) * part
    orders = np.arange(1, max(count // 2, 2))
    # Of p periods, times the cosine of order k: half the waves of p + k/2 and of p - k/2 periods.
    # One of c periods sums to sin(2 pi c)/(2 sin(pi c/n)), and its sine to (1 - cos(2 pi c)) over
    # the same.
    wave, order = np.pi * periods[:, None] / count, np.pi * orders / (2 * count)
    one, other = np.sin(wave) * np.cos(order), np.cos(wave) * np.sin(order)
    turned = np.where(orders % 2, -1.0, 1.0)
    cosine = turned * np.sin(2 * np.pi * periods)[:, None]
    sine = 1 - turned * np.cos(2 * np.pi * periods)[:, None]
    found = np.zeros((waves, 2, orders.size))
    for half in (one + other, one - other):
        # A wave of the order's own cycles is one all along.
        same = np.abs(half) < _SAME
        below = 2 * np.where(same, 1.0, half)
        found[:, 0] += np.where(same, count, cosine / below)
        found[:, 1] += np.where(same, 0.0, sine / below)
    found /= np.sqrt(2 * count)
    cosines, sines = found[:, 0], found[:, 1]
    return Waves(found, np.stack([cosines**2, cosines * sines, sines**2], axis=1))


def _warm_ups(scan: Scan, samples: int, paths: dict[str, float], brief: float) -> list[Course]:
    """With constants from a part of the record on, and longer than what is `brief`."""
    time = scan.blocks.time
    length = float(time[-1])
    shortest = min(max(length / 300, 4 * scan.blocks.size, brief), length / 8)
    constants = np.geomspace(shortest, length / 1.5, 24)
    ways = scan.directions(np.exp(-time[:, None] / constants))
    path = paths.setdefault("warm_up", _path(np.sum(ways[:, 1:] * ways[:, :-1], axis=0)))
    gains = (scan.white @ ways) ** 2
    return [
        warm_up(float(constants[at]), samples)._replace(length=path)
        for at in _tops(gains, 3, 1, 1.0, path)[:1]
    ]


def _steps(scan: Scan, samples: int, paths: dict[str, float], brief: float) -> list[Course]:
    """No nearer to the ends of a stretch than what is `brief`."""
    every, times, path = [np.zeros(0)], [np.zeros(0)], 0.0
    for stretch, start in zip(scan.stretches, scan.blocks.starts, strict=True):
        gains, length = _step_gains(stretch, brief / scan.blocks.size)
        every.append(gains)
        within = np.arange(1, gains.size + 1) / (gains.size + 1)
        times.append(within * (stretch.count * scan.blocks.size) + start)
        path += length
    gains, at = np.concatenate(every), np.concatenate(times)
    path = paths.setdefault("step", path)
    return [
        step(round(at[i]), samples)._replace(length=path)
        for i in _tops(gains, gains.size // 85, 1, 1.0, path)
    ]


def _step_gains(stretch: Stretch, brief: float) -> tuple[Float[np.ndarray, " places"], float]:
    """What steps gain at evenly spaced places within a stretch, and the length of their path.

    None nearer to its ends than `brief` blocks.
    """
    top, bottom, beside = step_sums(stretch)
    gains = top**2 / bottom
    path = _path(beside / np.sqrt(bottom[1:] * bottom[:-1]))
    # A step at the very ends is an outlier or a ramp, or an error of the angle.
    places = gains.size + 1
    ends = int(np.ceil(places * min(max(1 / 256, brief / stretch.count), 1 / 8)))
    gains[:ends] = gains[-ends:] = 0.0
    return gains, path


def _driven(name: str, columns: Float[np.ndarray, "samples columns"], samples: int) -> list[Course]:
    if name != "temperature":
        return [Course(name, lambda: columns, columns.shape[1], {})]
    felt = columns[:, 0]
    return [late(felt, lag * samples)._replace(places=float(len(_LAGS))) for lag in _LAGS]


def _tops(
    gains: Float[np.ndarray, " gains"], apart: int, sizes: int, places: float, path: float = 0.0
) -> list[int]:
    """The highest places that are worth a fit, none within `apart` of a higher one."""
    known = 1e9
    left = gains.copy()
    tops = []
    for _ in range(_SHORTLIST):
        at = int(np.argmax(left))
        if left[at] <= 0 or course_log_chance(left[at], sizes, known, places, path) >= _WORTH:
            break
        tops.append(at)
        left[max(0, at - apart) : at + apart + 1] = 0.0
    return tops
