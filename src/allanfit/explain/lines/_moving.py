"""Whether the power of a band stands still: a resonance does, a line that wanders or sweeps not."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.stats import t as student
from scipy.stats import theilslopes

# Segments are long enough to see a band's shape, and numerous enough to see it change.
_FEWEST_CELLS, _FEWEST_SEGMENTS, _MOST_SEGMENTS = 12, 16, 2048
# A line among the cells of a segment, as it is expected: by so much above the rest.
_HEIGHT = 8.0
# What it costs a path to go on by a cell more than a few, and to break off.
_FREE_CELLS, _FAR_PENALTY, _BREAK_PENALTY = 3, 1.0, 6.0
# A sweep's path stays within such a part of its travel, for such a part of its power.
_EVEN, _MOSTLY = 0.05, 0.75
# Shorter travels are none: cells.
_TRAVEL = 6.0

Cells = Float[np.ndarray, "segments cells"]


class Path(NamedTuple):
    """Where the power of a band is in the course of the recording."""

    #: Log of the chance that the power of a band that stands still looks as unsteady.
    log_p: float
    #: Cycles per sample, one a segment.
    frequency: Float[np.ndarray, " segments"]
    #: Whether it goes evenly from one end to the other.
    even: bool

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the straight line through it that most segments are near."""
        at = np.arange(self.frequency.size)
        slope, start, *_ = np.asarray(theilslopes(self.frequency, at), float)
        return float(start), float(start + slope * at[-1])


class Band(NamedTuple):
    """A band of a white record, and which share of its power is the cause's own."""

    #: Cycles per sample.
    low: float
    high: float
    #: Where the share is told, in ascending order.
    frequency: Float[np.ndarray, " frequencies"]
    share: Float[np.ndarray, " frequencies"]


def moving(white: Float[np.ndarray, " samples"], band: Band) -> Path | None:
    """The path of a band's power, if it has one; None where it cannot be told or stands still.

    In each segment, normal noise that stands still fills all cells of a band alike, each with an
    exponential variate, however strong it is just then. What moves fills one at a time.
    """
    best_log_p, best = 0.0, None
    length = _FEWEST_CELLS / (band.high - band.low)
    length = max(int(length), white.size // _MOST_SEGMENTS, 2)
    tried = 0
    while white.size // length >= _FEWEST_SEGMENTS:
        tried += 1
        at, cells = _cells(white, length, band)
        share = np.interp(at, band.frequency, band.share)
        log_p = _unsteady(cells, share)
        if log_p < best_log_p:
            best_log_p, best = log_p, (at, cells)
        length *= 2
    if best is None:
        return None
    at, cells = best
    place = _follow(cells)
    power = cells[np.arange(len(cells)), place]
    spread = float(np.std(place))
    if spread < 1.5:
        return None
    log_p = min(best_log_p + float(np.log(tried)), 0.0)
    return Path(log_p, at[place], _even(place, power))


def _cells(
    white: Float[np.ndarray, " samples"], length: int, band: Band
) -> tuple[Float[np.ndarray, " cells"], Cells]:
    """Powers of a band in segments; one is expected of each."""
    count = white.size // length
    frequency = np.fft.rfftfreq(length)
    inside = (frequency > band.low) & (frequency < band.high)
    segments = white[: count * length].reshape(count, length)
    return frequency[inside], np.abs(np.fft.rfft(segments)[:, inside]) ** 2 / length


def _unsteady(cells: Cells, share: Float[np.ndarray, " cells"]) -> float:
    """Log of the chance that cells are as uneven within segments.

    Of exponential variates of one mean the mean square is twice the mean product of two. Cells are
    divided by their means over time, which takes (n - 1)/(n + 1) off that.
    """
    count = len(cells)
    cells = cells / np.maximum(cells.mean(axis=0), 1e-300)
    total, square = share.sum(), np.sum(share**2)
    if total**2 <= 1.5 * square:
        return 0.0
    alone = cells**2 @ share / total * (count + 1) / (2 * count)
    together = ((cells @ share) ** 2 - cells**2 @ share**2) / (total**2 - square)
    excess = alone - together
    score = np.sqrt(count) * excess.mean() / max(excess.std(ddof=1), 1e-300)
    return float(student.logsf(score, count - 1))


def _follow(cells: Cells) -> Int[np.ndarray, " segments"]:
    """The likeliest path of a line through the cells (Viterbi 1967, IEEE Trans. IT 13:260)."""
    gain = cells * _HEIGHT / (1 + _HEIGHT) - np.log1p(_HEIGHT)
    count, width = gain.shape
    here = np.arange(width)
    best = gain[0]
    came = np.zeros((count, width), int)
    for row in range(1, count):
        top = int(np.argmax(best))
        reached, origin = np.full(width, best[top] - _BREAK_PENALTY), np.full(width, top)
        for move in range(-_FREE_CELLS, _FREE_CELLS + 1):
            old = here - move
            inside = (old >= 0) & (old < width)
            old = np.clip(old, 0, width - 1)
            value = best[old] - _FAR_PENALTY * max(abs(move) - 1, 0)
            better = inside & (value > reached)
            reached, origin = np.where(better, value, reached), np.where(better, old, origin)
        came[row], best = origin, reached + gain[row]
    path = np.empty(count, int)
    path[-1] = int(np.argmax(best))
    for row in range(count - 1, 0, -1):
        path[row - 1] = came[row, path[row]]
    return path


def _even(place: Int[np.ndarray, " segments"], power: Float[np.ndarray, " segments"]) -> bool:
    time = np.arange(place.size)
    slope, intercept = np.asarray(theilslopes(place, time)[:2], float)
    travel = abs(slope) * place.size
    if travel < _TRAVEL:
        return False
    near = np.abs(place - intercept - slope * time) < max(_EVEN * travel, 1.5)
    return bool(power[near].sum() > _MOSTLY * power.sum())
