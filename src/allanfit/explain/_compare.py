"""A recording against a simulation: where they differ, and whether a coefficient is to blame."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import f as fisher
from scipy.stats import norm

from ..curves import unit_scale
from ..identify import Fit
from ..physics import EFFECTS, SYMBOLS
from ._mismatch import span
from ._references import Reference, terms_of

_SIGNIFICANT = 0.005
# Compared in bands of about an octave.
_BINS_A_BAND = 5
# Standard deviations beyond which two coefficients are not one.
_APART = 2.0
# Ordinates of a density that is known.
_EXACT = 1e9
_RAMP = SYMBOLS.index("R")

Mismatch = dict[str, Any]


class _Cause(NamedTuple):
    """What is wrong with the simulation."""

    why: str
    #: The coefficient or effect whose size is wrong; None for physics that one of the two lacks.
    coefficient: str | None = None
    absent_from: str | None = None

    @property
    def fields(self) -> Mismatch:
        """As a mismatch tells it."""
        return {
            "cause": "coefficient" if self.absent_from is None else "physics",
            "coefficient": self.coefficient,
            "absent_from": self.absent_from,
        }


class _Difference(NamedTuple):
    """Frequencies [Hz] at which the two differ by more than chance."""

    low: float
    high: float
    #: The recording's power over that of the simulation.
    ratio: float
    chance: float
    #: By how much Q, N, B and K differ in power, recording less simulation.
    off: Float[np.ndarray, " noise"]
    #: What is none of the five terms in the recording and in the simulation.
    beyond: tuple[float, float]

    @property
    def band(self) -> Mismatch:
        """Its place, as that of a mismatch."""
        return {"domain": "frequency", "low": self.low, "high": self.high, "unit": "Hz"}


def compared(
    before: Fit,
    after: Fit,
    reference: Reference,
    found: Sequence[Mismatch],
    simulated: Sequence[Mismatch],
    seconds: float,
) -> list[Mismatch]:
    """Where recording and simulation differ, strongest first.

    The recording takes so many `seconds`; `before` is its five-term fit, and `after` has its
    coefficients beside what it was found to have beyond them. `found` is where the recording
    differs from five terms, and `simulated` where the simulation does, with the names of effects.

    In each band the difference of the two is the sum of what their coefficients differ by, and of
    what is none of the five terms in either: whichever is the larger is the cause.
    """
    own, error = terms_of(after)
    # Coefficients that the record does not allow to be alike.
    apart = np.abs(own - reference.coefficients) > _APART * np.hypot(error, reference.deviations)
    bands = []
    for each in _differences(before, own, reference):
        which = _coefficient_to_blame(each, apart, bool(found or simulated))
        if which is None:
            bands.append((each, _of_physics(each, found, simulated)))
        else:
            bands.append((each, _of_size(which, own, error, reference)))
    entries = [_entry(*band) for band in _joined(bands)]
    entries += _ramp(own, error, reference, seconds)
    for ours, theirs, lacking in (
        (found, simulated, "simulation"),
        (simulated, found, "recording"),
    ):
        entries += [
            _unseen(each, lacking)
            for each in ours
            if not any(_alike(each, other) for other in theirs)
            and not any(e["absent_from"] == lacking and _meet(e, each) for e in entries)
        ]
    return sorted(entries, key=lambda entry: entry["p_value"])


def _differences(
    before: Fit, own: Float[np.ndarray, " terms"], reference: Reference
) -> list[_Difference]:
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
        if chance < _SIGNIFICANT:
            beyond = seen - float(ours.sum()), drawn - float(theirs.sum())
            low, high = (float(frequency[part][end]) for end in (0, -1))
            found.append(_Difference(low, high, seen / drawn, chance, ours - theirs, beyond))
    return found


def _coefficient_to_blame(
    one: _Difference, apart: Bool[np.ndarray, " terms"], more_is_known: bool
) -> int | None:
    """Which coefficient makes two differ in a band; None where it is physics.

    `more_is_known` where either has physics beyond the five terms; else all is their coefficients.
    """
    way = 1 if one.ratio > 1 else -1
    off = way * one.off
    clear = apart[:4] & (off > 0)
    which = int(np.argmax(np.where(clear, off, -np.inf) if np.any(clear) else off))
    if not more_is_known:
        return which if off[which] > 0 else None
    larger = off.sum() > way * (one.beyond[0] - one.beyond[1])
    return which if larger and clear[which] else None


def _ramp(
    terms: Float[np.ndarray, " terms"],
    deviations: Float[np.ndarray, " terms"],
    reference: Reference,
    seconds: float,
) -> list[Mismatch]:
    """How the two drift throughout, if they differ in it."""
    own, theirs = float(terms[_RAMP]), float(reference.coefficients[_RAMP])
    error = np.hypot(deviations[_RAMP], reference.deviations[_RAMP])
    chance = 2 * float(norm.sf(abs(own - theirs), scale=error))
    if chance > _SIGNIFICANT:
        return []
    ratio = own / theirs if theirs > 0 else None
    cause = _of_size(_RAMP, terms, deviations, reference)
    size = "more than" if ratio is None else f"{ratio:.3g} times as fast as"
    return [
        {
            "domain": "time",
            "low": 0.0,
            "high": seconds,
            "unit": "s",
            "ratio": ratio,
            "p_value": chance,
            "sentence": f"Throughout, the recording drifts {size} the simulation: {cause.why}.",
            **cause.fields,
        }
    ]


def _of_size(
    which: int,
    terms: Float[np.ndarray, " terms"],
    deviations: Float[np.ndarray, " terms"],
    reference: Reference,
) -> _Cause:
    """Of a coefficient, by its size in the recording and in the simulation."""
    symbol, own, theirs = SYMBOLS[which], terms[which], reference.coefficients[which]
    if theirs == 0:
        return _Cause(f"it has no {symbol}", symbol)
    way = "small" if own > theirs else "large"
    # A term that the recording does not show has no size to compare with.
    shown = own > _APART * deviations[which]
    factor = f", {theirs / own:.3g} times the recording's" if shown else ""
    return _Cause(f"its {symbol} is too {way}{factor}", symbol)


def _of_physics(
    one: _Difference, found: Sequence[Mismatch], simulated: Sequence[Mismatch]
) -> _Cause:
    """What is beyond the five terms in a band: in the recording, in the simulation, or both."""
    ours, theirs = ([e for e in each if _meet(e, one.band)] for each in (found, simulated))
    if ours or theirs:
        is_ours = _is_more(one) if ours and theirs else bool(ours)
    else:
        is_ours = _is_more(one)
        # What changes in time has no band of its own.
        ours, theirs = ([e for e in each if e["domain"] == "time"] for each in (found, simulated))
    both = [each["effect"] for each in ours if each["effect"] in {e["effect"] for e in theirs}]
    if both:
        way = "small" if one.ratio > 1 else "large"
        return _Cause(f"its {both[0].replace('_', ' ')} is too {way}", both[0])
    what = " and ".join({EFFECTS[e["effect"]].what: 0 for e in (ours if is_ours else theirs)})
    if is_ours:
        said = "physics is absent from it" + (f" ({what})" if what else "")
        return _Cause(said, None, "simulation")
    return _Cause(f"it has {what or 'physics'}, which the recording has not", None, "recording")


def _is_more(one: _Difference) -> bool:
    """Whether the recording has more beyond the five terms, or less, than the simulation has."""
    return abs(one.beyond[0]) > abs(one.beyond[1])


def _unseen(entry: Mismatch, lacking: str) -> Mismatch:
    """What only one of the two has, and no band shows as a difference."""
    what = EFFECTS[entry["effect"]].what
    if lacking == "recording":
        said = f"The simulation has {what}, which the recording has not."
    else:
        said = f"{entry['sentence'].removesuffix('.')}: the simulation lacks {what}."
    return {**entry, "sentence": said, **_Cause(said, None, lacking).fields}


def _meet(one: Mismatch, other: Mismatch) -> bool:
    return (
        one["domain"] == other["domain"]
        and one["low"] <= other["high"]
        and other["low"] <= one["high"]
    )


def _alike(one: Mismatch, other: Mismatch) -> bool:
    """Whether two effects are one kind of thing: of one name, and of one band if it has a band."""
    if one["domain"] == other["domain"] == "time":
        return one["effect"] == other["effect"]
    return _meet(one, other)


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


def _joined(bands: list[tuple[_Difference, _Cause]]) -> list[tuple[_Difference, _Cause]]:
    """Bands with one cause as one, where no other cause lies between them."""
    kept: list[tuple[_Difference, _Cause]] = []
    for one, cause in bands:
        last, before = kept[-1] if kept else (one, None)
        if before is None or before[1:] != cause[1:] or (last.ratio > 1) != (one.ratio > 1):
            kept.append((one, cause))
            continue
        strongest = before if last.chance < one.chance else cause
        extreme = max(last, one, key=lambda each: abs(np.log(each.ratio)))
        chance = min(last.chance, one.chance)
        kept[-1] = extreme._replace(low=last.low, high=one.high, chance=chance), strongest
    return kept


def _entry(one: _Difference, cause: _Cause) -> Mismatch:
    return {
        **one.band,
        "ratio": one.ratio,
        "p_value": one.chance,
        "sentence": f"{span(one.low, one.high)} the recording has {one.ratio:.3g} times "
        f"the power of the simulation: {cause.why}.",
        **cause.fields,
    }
