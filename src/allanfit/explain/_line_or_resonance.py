"""Whether a narrow band is a line that wanders, or a resonance: told in time, where spectra fail.

Of both the spectrum is a peak, and shapes are alike within what a few hundred ordinates tell.
"""

import numpy as np
from jaxtyping import Float

from . import _search
from ._narrow import Narrow, beside, narrow_groups, resolve
from ._ordinates import points
from ._search import Model
from ._state import Finding, Investigation, whitened_piece
from ._structure import EACH, NARROW, added_density, bounds, free, shape_of
from ._tracked import inside, narrow_band, normal_likelihood, tracked_likelihood

# Standard deviations of a line's frequency to either side that its band takes in.
_REACH = 3.5
# Bands of fewer ordinates show no line that moves.
_FEWEST = 24
# More moments of a band than this tell nothing that matters.
_MOST = 8192
# Of the width that is told the other shape starts at these parts.
_PARTS = (0.5, 1.0, 2.0)
# The half-width of a resonance whose core looks like a line of this standard deviation.
_ALIKE = 1.2
_LINE, _RESONANCE = "drifting_line", "resonance"


def tell_apart(state: Investigation) -> None:
    """Give each narrow noise that stands alone the name that its course in time asks for."""
    if not narrow_groups(state):
        return
    resolve(state)
    white = whitened_piece(state, state.longest, model_only=True)
    for group in narrow_groups(state):
        if len(group) == 1:
            _tell(state, white, group[0])


def _tell(state: Investigation, white: Float[np.ndarray, " samples"], one: Narrow) -> None:
    finding = _finding(state, one)
    if finding is None:
        return
    fitted = {name: _as(state, one, name) for name in NARROW}
    tracked = _tracked(state, white, one, fitted[_LINE])
    if tracked is None:
        return
    # As twice the log of the odds, which scores are.
    gain = fitted[_RESONANCE].deviance - fitted[_LINE].deviance + 2 * tracked
    gain += _search.rarity(fitted[_LINE], state.data, one.place)
    gain -= _search.rarity(fitted[_RESONANCE], state.data, one.place)
    best, other = (_LINE, _RESONANCE) if gain > 0 else (_RESONANCE, _LINE)
    top = max((finding.rivals[name] for name in NARROW if name in finding.rivals), default=0.0)
    finding.rivals |= {best: top, other: top - abs(gain)}
    finding.name = best
    state.model = fitted[best]


def _finding(state: Investigation, one: Narrow) -> Finding | None:
    """The finding that belongs to a noise of the model: both are in the order they were found."""
    alike = [each for each in state.findings if each.name == one.name]
    before = state.model.kinds.added[: one.place].count(one.name)
    return alike[before] if before < len(alike) else None


def _as(state: Investigation, one: Narrow, name: str) -> Model:
    """The model at its best with a noise of this name in place of one."""
    kinds, samples = state.model.kinds, float(state.data.samples)
    if name == one.name:
        return state.model
    added = tuple(name if place == one.place else each for place, each in enumerate(kinds.added))
    first, second = bounds(name, samples)
    starts = []
    for part in _PARTS:
        theta, begin = np.array(state.model.theta), kinds.first_slot + EACH * one.place
        # A line's width is a standard deviation, and that of a resonance twice the half-width.
        width = part * one.width
        shape = width / (2 * _ALIKE) if name == _LINE else 1 / (2 * _ALIKE * width)
        shape = shape / one.middle if name == _LINE else shape * one.middle
        theta[begin + 1 : begin + EACH] = free(one.middle, *first), free(shape, *second)
        starts.append((kinds._replace(added=added), theta))
    return min(_search.best(starts, state.data), key=lambda model: model.deviance)


def _tracked(
    state: Investigation, white: Float[np.ndarray, " samples"], one: Narrow, line: Model
) -> float | None:
    """What a line gains when it is tracked, over normal noise of its spectrum.

    None in bands that are too narrow.
    """
    samples = float(state.data.samples)
    begin = line.kinds.first_slot + EACH * one.place
    three = line.theta[begin : begin + EACH]
    middle, breadth = (float(each) for each in shape_of(_LINE, three, samples))
    width = middle * breadth
    low, high = max(middle - _REACH * width, 1 / samples), min(middle + _REACH * width, 0.5)
    ordinates = inside(white.size, low, high)
    frequency = np.arange(ordinates.start, ordinates.stop) / white.size
    if frequency.size < _FEWEST:
        return None
    level = beside(state, [one], frequency)
    excess = np.asarray(added_density(_LINE, three, points(frequency), samples)) / level
    # The record is white with what is in the band now; the level stands beside it.
    made_white = np.interp(frequency, state.left.frequency, state.variance)
    flat = np.fft.fft(narrow_band(white, low, high)) * np.sqrt(made_white / level)
    band = np.fft.ifft(flat)[:_MOST]
    excess_in_part = np.interp(
        np.linspace(0, 1, band.size, endpoint=False),
        np.linspace(0, 1, excess.size, endpoint=False),
        excess,
    )
    place = (middle * white.size - ordinates.start) / frequency.size
    spread = width * white.size / frequency.size
    tracked = tracked_likelihood(band, place, spread, float(np.mean(excess)))
    return tracked - normal_likelihood(band, excess_in_part)
