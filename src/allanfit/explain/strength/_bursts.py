"""Brief disturbances: power that stands out in a tile of time and frequency.

A knock rings at its own frequency for a second. Averaged over all frequencies, or over the whole
record, it drowns; a short spectrum at its time shows it. Windows of 16, 32, ... samples are looked
at, bells and decays; where the record is white and lasts, each ordinate is exponential with mean
one. Knocks come again: how many tiles reach a height by chance is a Poisson variate, so that two or
more of them say what the strongest alone does not.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.signal.windows import hann
from scipy.stats import binom, poisson

# From a few samples to what rings for long.
_WINDOWS = tuple(2**k for k in range(4, 11))
# Slower than so many periods in its window, an ordinate may belong to a step or a drift.
_FEWEST_PERIODS = 3
# A row of tiles this much above one on the median has a level of its own, by a line or a resonance.
_OWN_LEVEL = 1.3
# A window belongs to a disturbance from this log chance on, once one stands out.
# So near to it, in lengths of its window; and from a smaller one anywhere else.
_BESIDE = float(np.log(0.05))
_NEAR, _ELSEWHERE = 16.0, float(np.log(0.001))
# Independent places for each sample, shape and length of window, by 850 records of white noise.
_TRIALS = 1.0
# The chance of the strongest tile, and of the second, third and fourth beside it, is allotted so.
_ALLOTTED = (1 / 2, 1 / 6, 1 / 6, 1 / 6)
# Windows of one shape that are looked at for each of them: a knock shows in several.
_HIGHEST = 8
# Windows whose middles are closer than this many lengths of the longer tell of one knock.
_APART = 2.0
# The share of windows that chance lifts above a level, and the chance of more of them from which on
# it is no brief disturbance that does.
_COMMON, _LASTING = 0.01, 1e-6
# An ordinate that stands out in a larger share of the windows is no brief one.
_SELDOM = 0.03
# A decay falls by this many powers of e within its window.
_DECAYS = 4.0
# Samples of windows that are transformed together.
_TOGETHER = 2**20


class Burst(NamedTuple):
    """Where some tiles stand out."""

    #: Which samples belong to such windows.
    loud: Bool[np.ndarray, " samples"]
    #: Log of the chance that the strongest tile of all, or the few strongest, are as strong.
    log_p: float
    #: The strongest tile's power over what is expected.
    ratio: float
    #: Samples of its window.
    window: int


def bursts(white: Float[np.ndarray, " samples"], tail: float = 1.0) -> Burst:
    """Look for disturbances in a whitened record whose spikes are pulled in.

    Powers of tiles are taken for so many times less as the `tail` of the noise is longer than that
    of a normal one.
    """
    loud = np.zeros(white.size, bool)
    windows = [
        (shape, hop, fewest)
        for width in _WINDOWS
        if white.size >= 64 * width
        for shape, hop, fewest in (
            (hann(width, sym=False), width // 2, _FEWEST_PERIODS),
            # With fewer periods a decay's ordinates are no circular noise any more.
            (np.exp(-_DECAYS * np.arange(width) / width), width // 8, 4 * _FEWEST_PERIODS),
        )
        if 2 * fewest < width // 2
    ]
    trials = np.log(_TRIALS * max(white.size, 2) * max(len(windows), 1))
    tiles: list[_Tile] = []
    beside: list[_Tile] = []
    for shape, hop, fewest in windows:
        power = _powers(white, shape / np.sqrt(np.sum(shape**2)), hop, fewest)
        own = np.median(power, axis=0) / np.log(2)
        power /= np.where(own > _OWN_LEVEL, own, 1.0) * tail
        strongest = _brief(power).max(axis=1, initial=0.0)
        beside += [
            _Tile(float(strongest[at]), at * hop + shape.size / 2, shape.size)
            for at in np.flatnonzero(trials - strongest < _BESIDE)
        ]
        if not _lasts(strongest, power.shape[1], trials):
            high = np.argsort(-strongest)[: _HIGHEST * len(_ALLOTTED)]
            tiles += [
                _Tile(float(strongest[at]), at * hop + shape.size / 2, shape.size) for at in high
            ]
    apart = _apart(tiles)
    if not apart:
        return Burst(loud, 0.0, 1.0, _WINDOWS[0])
    chances = [
        float(poisson.logsf(k, np.exp(trials - tile.power)) - np.log(allotted))
        for k, (tile, allotted) in enumerate(zip(apart, _ALLOTTED, strict=False))
    ]
    log_p = min(chances)
    # Several that are strong together may each be no more than chance.
    heard = apart[: chances.index(log_p) + 1]
    near = [
        tile
        for tile in beside
        if trials - tile.power < _ELSEWHERE
        or any(abs(tile.middle - other.middle) < _NEAR * other.window for other in heard)
    ]
    for tile in heard + near:
        begin = round(tile.middle - tile.window / 2)
        loud[begin : begin + tile.window] = True
    return Burst(loud, min(0.0, log_p), tail * apart[0].power, apart[0].window)


def _powers(
    white: Float[np.ndarray, " samples"],
    shape: Float[np.ndarray, " window"],
    hop: int,
    fewest: int,
) -> Float[np.ndarray, "windows ordinates"]:
    """Of windows `hop` apart, without the outermost ordinates."""
    frames = np.lib.stride_tricks.sliding_window_view(white, shape.size)[::hop]
    power = np.empty((len(frames), shape.size // 2 + 1 - 2 * fewest))
    # Few at a time: overlapping windows hold many times the samples.
    together = max(1, _TOGETHER // shape.size)
    for at in range(0, len(frames), together):
        spectra = np.fft.rfft(frames[at : at + together] * shape)
        spectra = spectra[:, fewest : spectra.shape[1] - fewest]
        power[at : at + together] = spectra.real**2 + spectra.imag**2
    return power


def _brief(power: Float[np.ndarray, "windows ordinates"]) -> Float[np.ndarray, "windows brief"]:
    """The ordinates that seldom stand out: a line that wanders comes to its own again and again."""
    high = np.log(power.shape[1] / _COMMON)
    return power[:, np.mean(power > high, axis=0) < _SELDOM]


class _Tile(NamedTuple):
    """One ordinate of a short spectrum."""

    #: Over what is expected.
    power: float
    #: The middle of its window, and how many samples that has.
    middle: float
    window: int


def _apart(tiles: list[_Tile]) -> list[_Tile]:
    """The few strongest tiles that do not tell of one another's knock, the strongest first."""
    kept: list[_Tile] = []
    for tile in sorted(tiles, reverse=True):
        if all(
            abs(tile.middle - other.middle) > _APART * max(tile.window, other.window)
            for other in kept
        ):
            kept.append(tile)
        if len(kept) == len(_ALLOTTED):
            break
    return kept


def _lasts(strongest: Float[np.ndarray, " windows"], tiles: int, trials: float) -> bool:
    """Whether windows stand out a little all the time, as by a line that moves."""
    others = strongest[trials - strongest > _BESIDE]
    high = np.log(tiles / _COMMON)
    return bool(binom.sf(np.sum(others > high) - 1, others.size, _COMMON) < _LASTING)
