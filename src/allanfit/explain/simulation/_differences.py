"""In which bands a recording and a simulation differ by more than chance, and by what."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import f as fisher

from ...curves import unit_scale
from ...identify import Fit
from .._mismatch import Mismatch
from ._references import Reference, terms_of

#: Chance below which the two differ.
SIGNIFICANT = 0.005
# Compared in bands of about an octave.
_BINS_A_BAND = 5
# Ordinates of a density that is known.
_EXACT = 1e9


class Difference(NamedTuple):
    """Frequencies [Hz] at which the two differ by more than chance."""

    low: float
    high: float
    #: The recording's power over that of the simulation, where it is farthest from one, and where.
    ratio: float
    at: tuple[float, float]
    chance: float
    #: By how much Q, N, B and K differ in power, recording less simulation.
    off: Float[np.ndarray, " noise"]
    #: What is none of the five terms in the recording and in the simulation.
    beyond: tuple[float, float]
    #: The chance of what their coefficients leave of the ratio.
    rest: float

    @property
    def band(self) -> Mismatch:
        """Its place, as that of a mismatch."""
        return {"domain": "frequency", "low": self.low, "high": self.high, "unit": "Hz"}


def differences(
    before: Fit, own: Float[np.ndarray, " terms"], reference: Reference
) -> list[Difference]:
    dt = 1 / float(before.rate_hz)
    frequency = np.asarray(before.design.frequency) / dt
    density = np.asarray(before.estimate.statistics.density, float) * dt
    ordinates = np.asarray(before.design.ordinates)
    unit = np.asarray(before.design.density) * dt / np.asarray(unit_scale(dt), float)[:4] ** 2
    model = unit @ terms_of(before)[0][:4] ** 2
    begins = range(0, frequency.size, _BINS_A_BAND)
    found = []
    for begin in begins:
        part = slice(begin, begin + _BINS_A_BAND)
        end = frequency[begin + _BINS_A_BAND] if begin + _BINS_A_BAND < frequency.size else np.inf
        weight = ordinates[part]
        # As parts of the model, so that steep densities are not those of a band's edge. Sums over
        # a band, not ratios of single bins: those of few ordinates have no mean.
        shape = np.average(unit[part] / model[part, None], axis=0, weights=weight)
        ours, theirs = (shape * each[:4] ** 2 for each in (own, reference.coefficients))
        seen = float(np.average(density[part] / model[part], weights=weight))
        if reference.density is None:
            drawn, count = float(theirs.sum()), _EXACT
        else:
            drawn, count = _simulated(reference, frequency, model, part, end)
        if count == 0:
            continue
        chance = _two_sided(seen / drawn, weight.sum(), count, len(begins))
        if chance < SIGNIFICANT:
            beyond = seen - float(ours.sum()), drawn - float(theirs.sum())
            low, high = (float(frequency[part][end]) for end in (0, -1))
            place, ratio = (low, high), seen / drawn
            explained = float(ours.sum() / max(theirs.sum(), 1e-300))
            rest = _two_sided(ratio / explained, weight.sum(), count, len(begins))
            found.append(Difference(*place, ratio, place, chance, ours - theirs, beyond, rest))
    return found


def _simulated(
    reference: Reference,
    frequency: Float[np.ndarray, " bins"],
    model: Float[np.ndarray, " bins"],
    part: slice,
    end: float,
) -> tuple[float, float]:
    """Mean density of a simulated recording over the recording's model, and its ordinates."""
    assert reference.frequency is not None
    assert reference.density is not None
    assert reference.ordinates is not None
    inside = (reference.frequency >= 0.999 * frequency[part][0]) & (reference.frequency < end)
    weight, at = reference.ordinates[inside], reference.frequency[inside]
    if not weight.size:
        return 0.0, 0.0
    there = np.exp(np.interp(np.log(at), np.log(frequency), np.log(model)))
    return float(weight @ (reference.density[inside] / there) / weight.sum()), float(weight.sum())


def _two_sided(ratio: float, ordinates: float, others: float, tests: int) -> float:
    above = float(fisher.sf(ratio, ordinates, others))
    below = float(fisher.cdf(ratio, ordinates, others))
    return min(1.0, 2 * tests * min(above, below))
