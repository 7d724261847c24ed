"""In which bands a recording and a simulation differ by more than chance, and by what."""

from typing import Any, NamedTuple

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


class _Spectra(NamedTuple):
    """The recording's spectrum, a simulation beside it, and what the five terms put in each bin."""

    frequency: Float[np.ndarray, " bins"]
    density: Float[np.ndarray, " bins"]
    ordinates: Float[np.ndarray, " bins"]
    #: Densities of Q, N, B and K of one.
    unit: Float[np.ndarray, "bins noise"]
    #: The recording's five terms alone.
    model: Float[np.ndarray, " bins"]
    reference: Reference

    @classmethod
    def of(cls, before: Fit, reference: Reference) -> "_Spectra":
        dt = 1 / float(before.rate_hz)
        unit = np.asarray(before.design.density) * dt / np.asarray(unit_scale(dt), float)[:4] ** 2
        return cls(
            np.asarray(before.design.frequency) / dt,
            np.asarray(before.estimate.statistics.density, float) * dt,
            np.asarray(before.design.ordinates),
            unit,
            unit @ terms_of(before)[0][:4] ** 2,
            reference,
        )

    def mean(self, values: Float[np.ndarray, " bins *_"], part: slice) -> Any:
        """Over the model, so that steep densities are not those of a band's edge.

        Of a band, not ratios of single bins: those of few ordinates have no mean.
        """
        relative = values[part] / self.model[part].reshape(-1, *(1,) * (values.ndim - 1))
        return np.average(relative, axis=0, weights=self.ordinates[part])

    def beside(self, part: slice) -> tuple[float, float, float]:
        """The mean densities of both over the model, and the ordinates of the simulation."""
        seen, one = float(self.mean(self.density, part)), self.reference
        if one.density is None:
            theirs = self.mean(self.unit, part) @ one.coefficients[:4] ** 2
            return seen, float(theirs), _EXACT
        end = float(np.append(self.frequency, np.inf)[part.stop])
        return seen, *_simulated(one, self.frequency, self.model, part, end)

    def chance(self, ratio: float, part: slice, others: float, tests: int) -> float:
        return _two_sided(ratio, float(self.ordinates[part].sum()), others, tests)


def differences(
    before: Fit, own: Float[np.ndarray, " terms"], reference: Reference
) -> list[Difference]:
    spectra = _Spectra.of(before, reference)
    size = spectra.frequency.size
    begins = range(0, size, _BINS_A_BAND)
    found = []
    for begin in begins:
        part = slice(begin, min(begin + _BINS_A_BAND, size))
        shape = spectra.mean(spectra.unit, part)
        ours, theirs = (shape * each[:4] ** 2 for each in (own, reference.coefficients))
        seen, drawn, count = spectra.beside(part)
        if count == 0:
            continue
        ratio = seen / drawn
        chance = spectra.chance(ratio, part, count, len(begins))
        if chance < SIGNIFICANT:
            beyond = seen - float(ours.sum()), drawn - float(theirs.sum())
            low, high = (float(spectra.frequency[part][end]) for end in (0, -1))
            place = low, high
            explained = float(ours.sum() / max(theirs.sum(), 1e-300))
            rest = spectra.chance(ratio / explained, part, count, len(begins))
            found.append(Difference(*place, ratio, place, chance, ours - theirs, beyond, rest))
    return found


class Together(NamedTuple):
    """All frequencies [Hz] at which a term shows, and how the two differ there."""

    low: float
    high: float
    #: The recording's power over that of the simulation.
    ratio: float
    chance: float


def where_it_shows(
    before: Fit, own: Float[np.ndarray, " terms"], reference: Reference, which: int
) -> Together:
    """Where a term has at least half of the largest share that it has in either."""
    spectra = _Spectra.of(before, reference)
    density = spectra.unit * np.stack([own[:4], reference.coefficients[:4]])[:, None] ** 2
    share = (density[..., which] / np.maximum(density.sum(axis=2), 1e-300)).max(axis=0)
    shown = np.flatnonzero(share >= share.max() / 2)
    part = slice(int(shown[0]), int(shown[-1]) + 1)
    low, high = (float(spectra.frequency[part][end]) for end in (0, -1))
    seen, drawn, count = spectra.beside(part)
    if count == 0:
        return Together(low, high, 1.0, 1.0)
    return Together(low, high, seen / drawn, spectra.chance(seen / drawn, part, count, 1))


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
