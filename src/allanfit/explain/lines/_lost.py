"""Samples that were lost on the way and of which no time stamp tells, by what they do to a line.

White noise knows nothing of a loss, but a line keeps time: after each lost sample its phase is
ahead by 2 pi f, and many of these make a narrow band of a sinusoid. A phase that diffuses, or that
jumps anywhere, makes the same spectrum: it is the size of the jumps that tells losses.
"""

from itertools import chain
from typing import NamedTuple

import numpy as np

from .._state import Investigation, whitened_piece
from ..spectrum._narrow import Narrow, alone, density_of, narrow_groups
from ..values._losses import Lost
from ._phase import (
    ANY_JUMPS,
    NO_JUMPS,
    Jumps,
    Turning,
    jumps_between,
    jumps_by,
    jumps_told,
    log_likelihood,
    log_likelihood_in_parts,
    refined,
    search,
)
from ._tracked import Baseband

# Moments are so many times as near as losses, and no more than so many to tell by: few at first. To
# place losses they are as near as a line has such a power in each, the noise's being one.
_OFTEN, _MOST, _FEW, _CLEAR, _PLACED = 8.0, 8192, 2048, 4.0, 131072
# By so much in log-likelihood losses have to be likelier than all else, and in a part of the record
# for the rest to be looked at.
_LIKELIER, _HOPEFUL = 6.0, 0.3
# Where more samples than this are lost for each that is not, nobody would call it a recording.
_MOST_LOST = 0.2


class _Line(NamedTuple):
    """A narrow band, its quartiles, and how many losses a sample make one as wide of a sinusoid."""

    group: list[Narrow]
    #: Cycles per sample.
    middle: float
    half_width: float
    rate: float


class _Band(NamedTuple):
    """The band about a line: its moments, how many samples these are apart, and where it begins."""

    moments: Baseband
    apart: float
    #: Cycles per sample.
    lowest: float

    def drift(self, frequency: float) -> float:
        """What a phase goes on by from moment to moment [rad]."""
        return 2 * np.pi * (frequency - self.lowest) * self.apart


def lost_on_the_way(state: Investigation) -> Lost | None:
    """The losses that blur the strongest line, if it is they that do."""
    line = _strongest(state)
    if line is None or line.rate > _MOST_LOST:
        return None
    band = _band(state, state.longest, line, 1 / (_OFTEN * line.rate))
    few, whole = band.moments[:_FEW], band.moments[:_MOST]
    most = line.rate * band.apart
    models = {
        "losses": (jumps_by(2 * np.pi * line.middle), most),
        "none": (NO_JUMPS, 0.0),
        "any": (ANY_JUMPS, most),
    }
    drift, width = band.drift(line.middle), 2 * np.pi * line.half_width * band.apart
    ways = {name: search(few, drift, width, *model) for name, model in models.items()}
    if _gain(few, ways, models) < _HOPEFUL:
        return None
    # Of few moments a drift is known to a part of a turn in all of them.
    step = 1 / few.size
    ways = {name: refined(whole, way, step, models[name][0]) for name, way in ways.items()}
    moving = log_likelihood_in_parts(whole, ways["none"], width, NO_JUMPS)
    gain = _gain(whole, ways, models)
    gain = min(gain, log_likelihood(whole, ways["losses"], models["losses"][0]) - moving)
    if gain < _LIKELIER:
        return None
    jumps = models["losses"][0]
    way = refined(whole, ways["losses"], step, jumps)
    placed = [_placed(state, piece, line, band, way) for piece in state.long_pieces]
    frequency = band.lowest + way.drift / (2 * np.pi * band.apart)
    rate, deviation = (each / band.apart for each in jumps_told(whole, way, jumps))
    return Lost(rate / (1 + rate), tuple(chain(*placed)), frequency, gain, deviation)


def _gain(
    moments: Baseband, ways: dict[str, Turning], models: dict[str, tuple[Jumps, float]]
) -> float:
    """How much likelier losses are than all else, in log-likelihood."""
    likely = {name: log_likelihood(moments, way, models[name][0]) for name, way in ways.items()}
    return likely.pop("losses") - max(likely.values())


def _placed(
    state: Investigation, piece: tuple[int, int], line: _Line, known: _Band, way: Turning
) -> list[tuple[int, int]]:
    """The first sample after each loss of a stretch, and how many are lost there.

    How the phase turns is told by the moments of the band that is `known`.
    """
    # As near as the line is clear in each moment.
    power = (float(np.mean(np.abs(known.moments) ** 2)) - 1) / known.apart
    apart = max(_CLEAR / max(power, 1e-9), (piece[1] - piece[0]) / _PLACED)
    band = _band(state, piece, line, min(apart, known.apart))
    times = band.apart / known.apart
    drift = band.drift(known.lowest + way.drift / (2 * np.pi * known.apart))
    nearer = Turning(drift, way.jumps * times, way.spread * times)
    jumps = jumps_between(band.moments, nearer, jumps_by(2 * np.pi * line.middle))
    counts = np.diff(np.round(np.cumsum(jumps)), prepend=0.0).astype(int)
    return [
        (piece[0] + round((float(at) - 0.5) * band.apart), int(counts[at]))
        for at in np.flatnonzero(counts > 0)
    ]


def _band(state: Investigation, piece: tuple[int, int], line: _Line, apart: float) -> _Band:
    """The band about a line in a stretch, whose moments are so many samples apart."""
    white = whitened_piece(state, piece, model_only=True)
    found = alone(state, white, line.group, line.middle, 1 / (2 * max(apart, 1.0)))
    return _Band(found.band, white.size / found.band.size, float(found.frequency[0]))


def _strongest(state: Investigation) -> _Line | None:
    groups = narrow_groups(state)
    if not groups:
        return None
    frequency = np.arange(1, state.spectrum.longest // 2) / state.spectrum.longest
    density = [density_of(state, group, frequency) for group in groups]
    best = int(np.argmax([each.sum() for each in density]))
    below = np.cumsum(density[best]) / density[best].sum()
    low, middle, high = np.interp([0.25, 0.5, 0.75], below, frequency)
    # Of the jumps of a Poisson process the spectrum is a Lorentz curve of such a half-width.
    half = (high - low) / 2
    rate = 2 * np.pi * half / (1 - np.cos(2 * np.pi * middle))
    return _Line(groups[best], float(middle), float(half), float(rate))
