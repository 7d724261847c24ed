"""Coefficients as uncertain as the name of what is beside them.

Correlated noise and a power law may fit one spectrum equally well and leave different white and
flicker noise to it, by many standard errors of either fit; and so may white noise behind a filter
and correlated noise beside less of it, where quantization hides what is beyond.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .._chance import score
from .._state import Investigation
from . import _model, _search
from ._model import Model
from ._posterior import Draws, sample_structure

# Broad noises stand for one another, lines do not: beside those the coefficients are what they are.
_BROAD = ("gauss_markov", "power_law")
# A rival with a smaller share of the odds moves no interval of 95 % by much.
_OPEN = 0.03


@dataclass(frozen=True)
class _Rival:
    model: Model
    #: How likely, the named structure being 1.
    odds: float


def averaged(state: Investigation, draws: Draws, seed: int, *, quick: bool) -> Draws:
    """The draws with powers of all structures, a rival in place of a filter or broad noise as well.

    Each structure has as many as its odds say (Hoeting et al. 1999, Statist. Sci. 14:382, eq. 1);
    everything but `power` stays that of the structure which was named.
    """
    found = [
        rival
        for place, name in enumerate(state.model.kinds.added)
        if name in _BROAD
        for rival in _rivals(state, place)
    ]
    if state.model.kinds.filtering:
        found += _unfiltered(state)
    if not found:
        return draws
    rng = np.random.default_rng(seed)
    total = 1 + sum(rival.odds for rival in found)
    whose = rng.choice(
        len(found) + 1,
        size=len(draws.power),
        p=[1 / total, *(rival.odds / total for rival in found)],
    )
    power = draws.power.copy()
    for index, rival in enumerate(found, start=1):
        other = sample_structure(rival.model, state.data, seed + index, quick=quick).power
        power[whose == index] = _some(other, int(np.sum(whose == index)), rng)
    return draws._replace(power=power)


def _some(
    power: Float[np.ndarray, "draws terms"], count: int, rng: np.random.Generator
) -> Float[np.ndarray, "count terms"]:
    return power[rng.choice(len(power), size=count, replace=count > len(power))]


def _unfiltered(state: Investigation) -> list[_Rival]:
    """A broad noise in place of the filter, as likely as it was when the filter was named."""
    named, data = state.finding("low_pass"), state.data
    rivals = {} if named is None else named.rivals
    bare = _model.rescaled(_model.without(state.model, 0), data)
    found = []
    for name in _BROAD:
        odds = np.exp((rivals.get(name, -np.inf) - rivals.get("low_pass", 0.0)) / 2)
        rival = _search.beside(bare, name, data) if odds > _OPEN else None
        if rival is not None:
            found.append(_Rival(rival, float(odds)))
    return found


def _rivals(state: Investigation, place: int) -> list[_Rival]:
    model, data = state.model, state.data
    name = model.kinds.added[place]
    own = score(name, 0.0) + _model.rarity(model, data, place)
    found = []
    for other in _BROAD:
        rival = _search.instead(model, place, other, data) if other != name else None
        if rival is not None:
            worth = score(other, model.deviance - rival.deviance) + _model.rarity(rival, data)
            odds = float(np.exp(np.clip((worth - own) / 2, -50, 0)))
            if odds > _OPEN:
                found.append(_Rival(rival, odds))
    return found
