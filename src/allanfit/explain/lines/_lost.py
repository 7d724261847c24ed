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
# And by so much than jumps by such other parts of the angle. What the phase diffuses beside them is
# such a part of their variance at most.
_OTHER_ANGLES, _SHARPER, _DIFFUSE = (0.5, 1.5), 2.0, 0.5
# Where more samples than this are lost for each that is not, nobody would call it a recording.
_MOST_LOST = 0.2
# A line that turns by less in a sample [rad] does not jump.
_TURNS = 0.1


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

    def frequency(self, drift: float) -> float:
        """Of a phase that goes on by so much."""
        return self.lowest + drift / (2 * np.pi * self.apart)


def lost_on_the_way(state: Investigation) -> Lost | None:
    """The losses that blur the strongest line, if it is they that do."""
    line = _strongest(state)
    if line is None or not 0 < line.rate <= _MOST_LOST:
        return None
    angle = 2 * np.pi * line.middle
    if angle < _TURNS:
        return None
    band = _band(state, state.longest, line, 1 / (_OFTEN * line.rate))
    asked = _Asked(band, line)
    losses = jumps_by(angle)
    others = (NO_JUMPS, 0.0), (ANY_JUMPS, asked.most)
    part = asked.searched(losses, asked.most)
    rivals = []
    for jumps, most in others:
        rival = asked.searched(jumps, most)
        if part.likelihood - rival.likelihood < _HOPEFUL:
            return None
        rivals.append((jumps, rival.way))
    found = asked.refined(losses, part.way)
    gain = min(found.likelihood - asked.refined(*rival).likelihood for rival in rivals)
    # A line whose phase diffuses as far as it jumps is one that wanders.
    jumped = 2 * found.way.jumps * (1 - np.cos(angle))
    if gain < _LIKELIER or found.way.spread > _DIFFUSE * jumped:
        return None
    # Where a line wanders more to one side than to the other, jumps that are none are as likely by
    # another angle.
    for times in _OTHER_ANGLES:
        as_wide = (1 - np.cos(angle)) / (1 - np.cos(times * angle))
        other = asked.best(jumps_by(times * angle), asked.most * min(as_wide, 1 / times))
        if found.likelihood - other.likelihood < _SHARPER:
            return None
    way = found.way
    placed = [_placed(state, piece, line, band, way) for piece in state.long_pieces]
    frequency = band.frequency(way.drift)
    rate, deviation = (each / band.apart for each in jumps_told(asked.whole, way, losses))
    return Lost(rate / (1 + rate), tuple(chain(*placed)), frequency, gain, deviation / rate)


class _Found(NamedTuple):
    way: Turning
    likelihood: float


class _Asked:
    """How likely the phase of a line turns in this way or that, in few moments and in many."""

    def __init__(self, band: _Band, line: _Line):
        self.few, self.whole = band.moments[:_FEW], band.moments[:_MOST]
        self.drift = band.drift(line.middle)
        self.width = 2 * np.pi * line.half_width * band.apart
        #: The jumps in a moment that make a sinusoid as wide.
        self.most = line.rate * band.apart

    def searched(self, jumps: Jumps, most: float) -> _Found:
        """The likeliest way in few moments."""
        way = search(self.few, self.drift, self.width, jumps, most)
        return _Found(way, log_likelihood(self.few, way, jumps))

    def refined(self, jumps: Jumps, way: Turning) -> _Found:
        """The likeliest in many near to it; of few a drift is known to a part of a turn in them."""
        way = refined(self.whole, way, 1 / self.few.size, jumps)
        return _Found(way, log_likelihood(self.whole, way, jumps))

    def best(self, jumps: Jumps, most: float) -> _Found:
        """The likeliest in many."""
        return self.refined(jumps, self.searched(jumps, most).way)


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
    drift = band.drift(known.frequency(way.drift))
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
