"""Coefficients as uncertain as the name of what is beside them.

Correlated noise and a power law may fit one spectrum equally well and leave different white and
flicker noise to it, by many standard errors of either fit; and so may white noise behind a filter
and correlated noise beside less of it, where quantization hides what is beyond. A power law that
reaches half the sampling rate folds there if samples are values, and hardly if they are averages.
"""

from dataclasses import dataclass

import jax
import numpy as np
from jaxtyping import Float

from ...curves._design import NOISE_TERMS, expected_ordinates
from .._chance import score
from .._state import Investigation
from . import _model, _search
from ._model import Model
from ._posterior import Draws, sample_structure
from ._structure import Data

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


def of_either_sampling(state: Investigation, draws: Draws, seed: int, *, quick: bool) -> Draws:
    """The draws, some on samples that are averages, as likely as these are, beside a power law."""
    model, data = state.model, state.data
    if "power_law" not in model.kinds.added or model.kinds.shaping is not None or data.averaging:
        return draws
    data = _of_averages(data)
    (other,) = _model.best([(model.kinds, model.theta)], data)
    share = 1 / (1 + np.exp(np.clip((other.deviance - model.deviance) / 2, -50, 50)))
    if share < _OPEN:
        return draws
    drawn, rng = sample_structure(other, data, seed, quick=quick), np.random.default_rng(seed)
    swapped = rng.random(len(draws.power)) < share
    chosen = rng.choice(len(drawn.power), int(np.sum(swapped)))
    power, theta = draws.power.copy(), draws.theta.copy()
    power[swapped], theta[swapped] = drawn.power[chosen], drawn.theta[chosen]
    return draws._replace(power=power, theta=theta)


def _of_averages(data: Data) -> Data:
    """The same spectrum, as if of samples that are averages over their interval."""
    expected, frequency = np.array(data.bins.expected), np.clip(data.bins.frequency, 1e-12, 0.5)
    # Between Q and N as they are logged there is no difference.
    for place, term in list(enumerate(NOISE_TERMS))[2:]:
        with jax.enable_x64(True):
            of_averages, of_values = (
                expected_ordinates(term, 1, frequency, sampling, low_modes=False)
                for sampling in ("averaged", "point")
            )
        expected[:, place] *= of_averages / of_values
    return data._replace(averaging=1.0, bins=data.bins._replace(expected=expected))


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
