"""Which lines are multiples of one frequency, folded at half the sampling rate or not."""

import math
from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

# Multiples that are looked for, and which of them the line may be that others are compared with.
_MULTIPLES, _FIRST = np.arange(1, 101), range(1, 9)
# Chance of such a family among lines that have nothing to do with one another.
_BY_CHANCE = 1e-3
# Error that a frequency is allowed, in standard deviations.
_DEVIATIONS = 3.0


class Line(NamedTuple):
    """A line and the standard deviation of its frequency [Hz]."""

    frequency: float
    deviation: float


class Family(NamedTuple):
    """Lines that are multiples of one frequency, which need not be among them [Hz]."""

    fundamental: float
    #: In rising order.
    lines: tuple[float, ...]
    #: Those of them that are beyond half the sampling rate, and appear where they fold to.
    folded: tuple[float, ...]


class _Guess(NamedTuple):
    fundamental: float
    #: The multiple that each line is, by its place; and the chance of as many.
    multiples: dict[int, int]
    chance: float

    def folded(self, nyquist_hz: float) -> list[int]:
        """The places of lines that are beyond half the sampling rate."""
        beyond = nyquist_hz / self.fundamental
        return [place for place, multiple in self.multiples.items() if multiple > beyond]


def families(lines: Sequence[Line], nyquist_hz: float) -> list[Family]:
    """Families of two lines and more that chance does not explain; a line is in one at most."""
    left, found = list(lines), []
    while len(left) > 1:
        guesses = [
            _guess(left, place, first, nyquist_hz)
            for place, first in product(range(len(left)), _FIRST)
        ]
        likely = [each for each in guesses if each.chance < _BY_CHANCE]
        if not likely:
            break
        # The most lines, and of those the lowest multiples, and of those the fewest that fold.
        best = min(
            likely,
            key=lambda each: (
                -len(each.multiples),
                sum(each.multiples.values()),
                len(each.folded(nyquist_hz)),
            ),
        )
        own, folded = (
            tuple(sorted(left[place].frequency for place in places))
            for places in (best.multiples, best.folded(nyquist_hz))
        )
        found.append(Family(_together(left, best, nyquist_hz), own, folded))
        left = [line for place, line in enumerate(left) if place not in best.multiples]
    return found


def _guess(lines: list[Line], place: int, first: int, nyquist_hz: float) -> _Guess:
    """Which lines are multiples, if that at `place` is the `first` one."""
    base = lines[place]
    fundamental = base.frequency / first
    beyond = (_MULTIPLES * fundamental) % (2 * nyquist_hz)
    appear = np.minimum(beyond, 2 * nyquist_hz - beyond)
    multiples, chance = {place: first}, 1.0
    for other, line in enumerate(lines):
        if other == place:
            continue
        allowed = _DEVIATIONS * np.hypot(line.deviation, _MULTIPLES / first * base.deviation)
        near = np.abs(appear - line.frequency) <= allowed
        if near.any():
            lowest = int(np.argmax(near))
            multiples[other] = int(_MULTIPLES[lowest])
            # By chance a line lies as near to so low a multiple.
            chance *= min(1.0, float(2 * allowed[: lowest + 1].sum()) / nyquist_hz)
    others = len(multiples) - 1
    tried = len(lines) * len(_FIRST) * math.comb(len(lines) - 1, others)
    # That the product of as many chances is as small (Fisher's method).
    by_chance = float(chi2.sf(-2 * math.log(chance), 2 * others)) if others else 1.0
    return _Guess(fundamental, multiples, tried * by_chance)


def _together(lines: list[Line], guess: _Guess, nyquist_hz: float) -> float:
    """The fundamental by all of its multiples: least squares, each by its own deviation."""
    places, multiples = list(guess.multiples), np.array(list(guess.multiples.values()))
    own = np.array([lines[place] for place in places])
    frequency, deviation = own.T
    # Where a line would be if it were not folded: the nearest of all that appear where it does.
    turns = 2 * nyquist_hz * np.round(multiples * guess.fundamental / (2 * nyquist_hz))
    unfolded = np.where(multiples * guess.fundamental < turns, turns - frequency, turns + frequency)
    weights = multiples / deviation**2
    return float(weights @ unfolded / (weights @ multiples))
