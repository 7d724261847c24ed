"""Whether a narrow band is a line that wanders, one that is switched, or a resonance.

Of all the spectrum is a peak, and shapes are alike within what a few hundred ordinates tell: it is
time that tells them apart.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .._intervals import runs
from .._state import Investigation, whitened_piece
from ..spectrum import _model
from ..spectrum._model import Model
from ..spectrum._narrow import Narrow, alone, density_of, narrow_groups, narrow_noises, resolve
from ..spectrum._structure import EACH, NARROW, bounds, free
from ._moments import moments
from ._one_phase import OnePhase, one_phase
from ._tracked import Followed, normal_likelihood, tracked

# Standard deviations of a line's frequency to either side that its band takes in.
_REACH = 3.5
# And those in which its sidebands are, if its strength changes.
_SIDEBANDS = 6.0
# A band takes in as many ordinates at least, and its middle is sought among so many.
_FEWEST, _FEW = 48, 2.0
# More moments of a band than this tell nothing that matters.
_MOST = 8192
# Of the width that is told the other shape starts at these parts.
_PARTS = (0.5, 1.0, 2.0)
# The half-width of a resonance whose core looks like a line of this standard deviation.
_ALIKE = 1.2
_LINE, _RESONANCE = "drifting_line", "resonance"
# For what parts of the record a line that is switched may be on, how often it goes on or off, and
# the longest band in which it is looked for.
_ON, _CHANGES = (0.25, 0.5, 0.75), 8.0
_MOST_SWITCHED = 2048


class Told(NamedTuple):
    """What following a narrow noise in time gains, in log-likelihood."""

    #: As a line that wanders, over normal noise of its spectrum; nothing if it is no line.
    wanders: float = 0.0
    #: As a line that is off at times, over all that is not; and when it is on, in parts of the
    #: longest stretch.
    switched: float = -np.inf
    on: tuple[tuple[float, float], ...] = ()


class _Gains(NamedTuple):
    """Log-likelihoods of courses of a line, over that of normal noise of its spectrum."""

    wanders: float
    #: For what part of the stretch its frequency lasts then.
    lasts: float
    #: Any of which is at any frequency when it comes back: the first without having been off.
    leaps: float = -np.inf
    switched: float = -np.inf
    #: When it is on then.
    on: tuple[tuple[float, float], ...] = ()


def tell_apart(state: Investigation) -> dict[int, Told]:
    """Give each narrow noise that stands alone the name that its course in time asks for.

    Returns what following it gains, by its place.
    """
    if not narrow_groups(state):
        return {}
    resolve(state)
    white = whitened_piece(state, state.longest, model_only=True)
    gains = {}
    for group in narrow_groups(state):
        if len(group) == 1:
            (one,) = group
            gains[one.place] = _tell(state, white, one)
    return gains


def _tell(state: Investigation, white: Float[np.ndarray, " samples"], one: Narrow) -> Told:
    names = state.model.kinds.names
    finding = state.findings_of(names)[one.place - len(state.model.kinds.added)]
    if finding is None:
        return Told()
    fitted = {name: _as(state, one, name) for name in NARROW}
    gained = _followed(state, white, one, fitted[_LINE])
    better = (fitted[_RESONANCE].deviance - fitted[_LINE].deviance) / 2
    switched = gained.switched - max(gained.wanders, gained.leaps, 0.0, -better)
    # As twice the log of the odds, which scores are.
    gain = 2 * (better + gained.wanders)
    gain += _model.rarity(fitted[_LINE], state.data, one.place)
    gain -= _model.rarity(fitted[_RESONANCE], state.data, one.place)
    best, other = (_LINE, _RESONANCE) if gain > 0 else (_RESONANCE, _LINE)
    top = max((finding.rivals[name] for name in NARROW if name in finding.rivals), default=0.0)
    finding.rivals |= {best: top, other: top - abs(gain)}
    finding.name = best
    state.model = fitted[best]
    if best == _RESONANCE:
        return Told(switched=switched, on=gained.on)
    line = _in(state.model, one.place, state)
    state.followed[one.place] = Followed(gained.lasts, moments(state, line))
    return Told(gained.wanders, switched, gained.on)


def in_one_phase(
    state: Investigation, white: Float[np.ndarray, " samples"], group: list[Narrow]
) -> OnePhase | None:
    """Whether narrow noises are one line whose strength changes; None in wide bands."""
    main = min(group, key=_spread)
    spread = max(_spread(each) + abs(each.middle - main.middle) for each in group)
    half = max(_SIDEBANDS * spread, _FEWEST / 2 / white.size)
    if 2 * half * white.size > _MOST:
        return None
    found = alone(state, white, group, main.middle, half)
    level = float(np.interp(main.middle, found.frequency, found.level))

    def excess(order: np.ndarray) -> np.ndarray:
        aside = order / white.size
        above, below = (density_of(state, group, main.middle + end * aside) for end in (1, -1))
        return (above + below) / 2 / level

    middle = (main.middle - found.frequency[0]) * white.size
    return one_phase(found.band, middle, max(2 * _spread(main) * white.size, _FEW), excess)


def _spread(one: Narrow) -> float:
    """The standard deviation of a line's frequency, or what looks like it."""
    return one.width if one.name == _LINE else one.width / (2 * _ALIKE)


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
    return min(_model.best(starts, state.data), key=lambda model: model.deviance)


def _in(model: Model, place: int, state: Investigation) -> Narrow:
    """The narrow noise at a place of a model."""
    every = narrow_noises(model, float(state.data.samples))
    return next(each for each in every if each.place == place)


def _followed(
    state: Investigation, white: Float[np.ndarray, " samples"], one: Narrow, line: Model
) -> _Gains:
    fitted = _in(line, one.place, state)
    middle, width = fitted.middle, fitted.width
    found = alone(state, white, [one], middle, max(_REACH * width, _FEWEST / 2 / white.size))
    frequency, band = found.frequency, found.band[:_MOST]
    excess = density_of(state, [fitted], frequency) / found.level
    part = np.arange(band.size) / band.size * excess.size
    normal = normal_likelihood(band, np.interp(part, np.arange(excess.size), excess))
    place = (middle - frequency[0]) * white.size / frequency.size
    spread = width * white.size / frequency.size
    power = float(np.mean(excess))
    steady = tracked(band, place, spread, power)
    gains = _Gains(steady.log_likelihood - normal, steady.memory / frequency.size)
    if band.size > _MOST_SWITCHED:
        return gains
    leaps = tracked(band, place, spread, power, changes=_CHANGES)
    past = tracked(band, place, spread, power, on=_ON, changes=_CHANGES)
    gains = gains._replace(
        leaps=leaps.log_likelihood - normal, switched=past.log_likelihood - normal
    )
    if gains.switched < max(gains.wanders, gains.leaps, 0.0):
        return gains
    # Its past tells late when it goes, and its future early when it comes.
    backward = np.conj(band[::-1])
    future = tracked(backward, place, spread, power, on=_ON, changes=_CHANGES)
    on = runs(past.on + future.on[::-1] > 1)
    return gains._replace(on=tuple((a / band.size, b / band.size) for a, b in on))
