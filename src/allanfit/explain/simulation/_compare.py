"""A recording against a simulation: is a coefficient to blame where they differ, or physics?"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import norm

from ...identify import Fit
from ...physics import EFFECTS, SYMBOLS, AbstractFilter
from .._effect import Effect
from .._mismatch import Located, Mismatch, meet, span
from ..spectrum._structure import NARROW
from ._differences import SIGNIFICANT, Difference, differences, where_it_shows
from ._mistaken import as_if
from ._references import Reference
from ._same_effect import Pair, pairs

# Standard deviations beyond which two coefficients are not one.
_APART = 2.0
_RAMP = SYMBOLS.index("R")
# What the simulation alone seems to have, and no band shows, has to be as unlikely as this: the
# recording may have it too, and not have shown it quite.
_CLEAR = 1e-6
# A coefficient of which no band tells enough alone is off if it is so by such a chance, beside that
# of all bands; and the power where it shows is off as well, by such a chance.
_UNSEEN, _SEEN = SIGNIFICANT / 5, 0.05
# A coefficient beside effects that are in doubt is off if it is by such a part.
_DOUBTFUL_PART = 0.1
# What has no band of its own, or is broad.
_BROAD = ("gauss_markov", "power_law", "random_telegraph")
# What happens at times of its own.
_AT_TIMES = ("step", "disturbance")

#: The unit that a parameter of an effect is told in, and one such unit in SI and seconds.
UnitOf = Callable[[Effect, str], tuple[str, float]]


class _Cause(NamedTuple):
    """What is wrong with the simulation."""

    why: str
    #: The coefficient or effect whose size is wrong; None for physics that one of the two lacks.
    coefficient: str | None = None
    absent_from: str | None = None
    #: Effects that it names.
    named: tuple[Effect, ...] = ()

    @property
    def fields(self) -> Mismatch:
        """As a mismatch tells it."""
        return {
            "cause": "coefficient" if self.absent_from is None else "physics",
            "coefficient": self.coefficient,
            "absent_from": self.absent_from,
        }


class _Effects(NamedTuple):
    """What recording and simulation have beyond the five terms, but for what they share."""

    #: What only one of the two has.
    only_ours: list[Located]
    only_theirs: list[Located]
    #: What both have, of different sizes.
    off: list[Pair]
    unit_of: UnitOf


def compared(
    before: Fit,
    own: tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]],
    reference: Reference,
    found: Sequence[Located],
    simulated: Sequence[Located],
    seconds: float,
    unit_of: UnitOf,
    *,
    resolved: Bool[np.ndarray, " terms"] | None = None,
    doubtful: bool = False,
) -> list[Mismatch]:
    """Where recording and simulation differ, strongest first.

    The recording takes so many `seconds`; `before` is its five-term fit, and `own` are its
    coefficients beside what it was found to have beyond them, and their deviations. `found` is
    where the recording differs from five terms, and `simulated` where the simulation does, each
    with its effect. Terms that are not `resolved` may be none, as they are in a simulation without
    them. The coefficients are `doubtful` where all that does not describe the recording.

    In each band the difference of the two is the sum of what their coefficients differ by, and of
    what is none of the five terms in either: whichever is the larger is the cause. Effects that
    both have are compared by their parameters.
    """
    values, error = own
    # Coefficients that the record does not allow to be alike.
    distance = np.abs(values - reference.coefficients)
    apart = distance > _APART * np.hypot(error, reference.deviations)
    if resolved is not None:
        apart &= resolved | (reference.coefficients > 0)
    if doubtful:
        apart &= distance > _DOUBTFUL_PART * np.maximum(values, reference.coefficients)
        # And a term that it has not may stand for what is left out still.
        apart &= reference.coefficients > 0
    both = pairs(found, simulated, SIGNIFICANT)
    shared = {id(each.effect) for pair in both for each in (pair.own, pair.theirs)}
    effects = _Effects(
        [each for each in found if id(each.effect) not in shared],
        [each for each in simulated if id(each.effect) not in shared],
        [pair for pair in both if pair.off],
        unit_of,
    )
    bands = []
    for each in differences(before, values, reference):
        which = _coefficient_to_blame(each, apart, bool(found or simulated))
        if which is None:
            cause = _of_physics(each, effects)
            # A file that names what cannot be drawn does not lack it.
            if not cause.named or any(e.name not in reference.undrawn for e in cause.named):
                bands.append((each, cause))
        else:
            bands.append((each, _of_size(which, before, own, reference)))
    joined = _joined(bands)
    named = [id(effect) for _, cause in joined for effect in cause.named]
    entries = [_entry(*band) for band in joined]
    entries += _ramp(before, own, reference, seconds)
    blamed = {cause.coefficient for _, cause in bands}
    for which, chance in enumerate(_chances(values, error, reference)):
        if apart[which] and chance < _UNSEEN and SYMBOLS[which] not in blamed:
            entries += _unseen_term(which, before, own, reference, float(chance))
    entries += [_sized(pair, unit_of) for pair in effects.off if id(pair.own.effect) not in named]
    # A band of an octave does not say where a line is.
    entries += [
        _unseen(each, "simulation")
        for each in effects.only_ours
        if each.effect.name not in reference.undrawn
        if each.effect.name in ("sinusoid", *NARROW) or id(each.effect) not in named
    ]
    entries += [
        _unseen(each, "recording")
        for each in effects.only_theirs
        if id(each.effect) not in named and each.entry["p_value"] < _CLEAR
    ]
    return sorted(entries, key=lambda entry: entry["p_value"])


def _coefficient_to_blame(
    one: Difference, apart: Bool[np.ndarray, " terms"], more_is_known: bool
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
    larger = off.sum() > way * (one.beyond[0] - one.beyond[1]) or one.rest > SIGNIFICANT
    return which if larger and clear[which] else None


def _ramp(
    before: Fit,
    terms: tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]],
    reference: Reference,
    seconds: float,
) -> list[Mismatch]:
    """How the two drift throughout, if they differ in it."""
    own, theirs = float(terms[0][_RAMP]), float(reference.coefficients[_RAMP])
    error = np.hypot(terms[1][_RAMP], reference.deviations[_RAMP])
    chance = 2 * float(norm.sf(abs(own - theirs), scale=error))
    if chance > SIGNIFICANT:
        return []
    ratio = own / theirs if theirs > 0 else None
    cause = _of_size(_RAMP, before, terms, reference)
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


def _chances(
    terms: Float[np.ndarray, " terms"],
    deviations: Float[np.ndarray, " terms"],
    reference: Reference,
) -> Float[np.ndarray, " noise"]:
    """That any of Q, N, B and K is as far from that of the simulation by chance.

    Of one that either does not show, its deviation does not say how large it may be.
    """
    error = np.hypot(deviations, reference.deviations)[:4]
    distance = np.abs(terms - reference.coefficients)[:4]
    chances = np.minimum(2 * error.size * norm.sf(distance / np.maximum(error, 1e-300)), 1.0)
    shown = terms > _APART * deviations
    shown &= reference.coefficients > _APART * reference.deviations
    return np.where(shown[:4], chances, 1.0)


def _unseen_term(
    which: int,
    before: Fit,
    own: tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]],
    reference: Reference,
    chance: float,
) -> list[Mismatch]:
    """A coefficient that is off, of which no band tells enough alone.

    Unless all of them together deny it: other physics may be in its place.
    """
    there = where_it_shows(before, own[0], reference, which)
    larger = own[0][which] > reference.coefficients[which]
    if there.chance > _SEEN or (there.ratio > 1) != larger:
        return []
    cause = _of_size(which, before, own, reference)
    where = span(there.low, there.high)
    return [
        {
            "domain": "frequency",
            "low": there.low,
            "high": there.high,
            "unit": "Hz",
            "ratio": there.ratio,
            "p_value": chance,
            "sentence": f"{where} the two differ, as all frequencies together show: {cause.why}.",
            **cause.fields,
        }
    ]


def _of_size(
    which: int,
    before: Fit,
    terms: tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]],
    reference: Reference,
) -> _Cause:
    """Of a coefficient, by its size in the recording and in the simulation."""
    symbol, own, theirs = SYMBOLS[which], float(terms[0][which]), reference.coefficients[which]
    if theirs == 0:
        return _Cause(f"it has no {symbol}", symbol)
    way = "small" if own > theirs else "large"
    # A term that the recording does not show has no size to compare with.
    if own <= _APART * terms[1][which]:
        return _Cause(f"its {symbol} is too {way}", symbol)
    factor, rate_hz = float(theirs) / own, float(before.rate_hz)
    mistake = as_if(symbol, reference.kind, factor, rate_hz, reference.rate_hz or rate_hz)
    return _Cause(f"its {symbol} is too {way}, {factor:.3g} times the recording's{mistake}", symbol)


def _of_physics(one: Difference, effects: _Effects) -> _Cause:
    """What is beyond the five terms in a band: in the recording, in the simulation, or both."""
    sized = [pair for pair in effects.off if any(meet(e.entry, one.band) for e in pair[:2])]
    more = one.ratio > 1
    ours, theirs = (
        [each for each in some if _could(each, is_more)]
        for some, is_more in ((effects.only_ours, more), (effects.only_theirs, not more))
    )
    here = tuple([e for e in some if meet(e.entry, one.band)] for some in (ours, theirs))
    if not any(here):
        # What changes in time has no band of its own, and what is broad shows beyond its own.
        sized = sized or [pair for pair in effects.off if _is_broad(pair.own)]
        if not any(_is_broad(e) for some in (ours, theirs) for e in some):
            sized = sized or effects.off
        here = tuple([e for e in some if _is_broad(e)] for some in (ours, theirs))
    if sized:
        both = sized[0].own.effect, sized[0].theirs.effect
        return _Cause(_size_of(sized[0], effects.unit_of), both[0].name, None, both)
    is_ours = bool(here[0]) if not all(here) and any(here) else _is_more(one)
    chosen = here[0] if is_ours else here[1]
    what = ", ".join({_what(each): 0 for each in chosen})
    named = tuple(each.effect for each in chosen)
    if is_ours:
        said = "physics is absent from it" + (f" ({what})" if what else "")
        return _Cause(said, None, "simulation", named)
    return _Cause(
        f"it has {what or 'physics'}, which the recording has not", None, "recording", named
    )


def _what(one: Located) -> str:
    """The effect in words, and when, which no band of frequencies tells."""
    what = EFFECTS[one.effect.name].what
    if one.effect.name not in _AT_TIMES:
        return what
    low, high = (f"{one.entry[end]:.5g}" for end in ("low", "high"))
    return f"{what}, at {low} s" if low == high else f"{what}, from {low} to {high} s"


def _could(one: Located, more: bool) -> bool:
    """Whether an effect can make more power, or less: filters alone take some away."""
    return more or _takes(one.effect.name)


def _takes(name: str) -> bool:
    return issubclass(EFFECTS[name], AbstractFilter)


def _is_broad(one: Located) -> bool:
    name = one.effect.name
    return one.entry["domain"] == "time" or name in _BROAD or _takes(name)


def _is_more(one: Difference) -> bool:
    """Whether the recording has more beyond the five terms, or less, than the simulation has."""
    return abs(one.beyond[0]) > abs(one.beyond[1])


def _size_of(pair: Pair, unit_of: UnitOf) -> str:
    """What an effect has in the simulation and in the recording, in words."""
    assert pair.off is not None
    off, (unit, factor) = pair.off, unit_of(pair.own.effect, pair.off.parameter)
    own, theirs, low, high = (
        f"{value / factor:.4g}" for value in (off.own, off.theirs, *off.interval)
    )
    spread = "" if low == high else f" [{low}, {high}]"
    what = f"{EFFECTS[pair.own.effect.name].what} whose {off.parameter.replace('_', ' ')}"
    return f"it has {what} is {theirs} {unit}".rstrip() + f", the recording's {own}{spread}"


def _sized(pair: Pair, unit_of: UnitOf) -> Mismatch:
    """What both have, in different sizes that no band shows."""
    assert pair.off is not None
    cause = _Cause(_size_of(pair, unit_of), pair.own.effect.name)
    return {
        **pair.own.entry,
        "ratio": pair.off.own / pair.off.theirs if pair.off.theirs else None,
        "p_value": pair.off.chance,
        "sentence": f"The simulation has{cause.why.removeprefix('it has')}.",
        **cause.fields,
    }


def _unseen(one: Located, lacking: str) -> Mismatch:
    """What only one of the two has, and no band tells alone."""
    entry = one.entry
    if lacking == "recording":
        said = f"The simulation has {_what(one)}, which the recording has not."
    else:
        # Its sentence tells when.
        what = EFFECTS[one.effect.name].what
        said = f"{entry['sentence'].removesuffix('.')}: the simulation lacks {what}."
    return {**entry, "sentence": said, **_Cause(said, None, lacking).fields}


def _joined(bands: list[tuple[Difference, _Cause]]) -> list[tuple[Difference, _Cause]]:
    """Bands with one cause as one, where no other cause lies between them."""
    kept: list[tuple[Difference, _Cause]] = []
    for one, cause in bands:
        last, before = kept[-1] if kept else (one, None)
        if before is None or not _one_cause(before, cause) or (last.ratio > 1) != (one.ratio > 1):
            kept.append((one, cause))
            continue
        strongest = before if last.chance < one.chance else cause
        extreme = max(last, one, key=lambda each: abs(np.log(each.ratio)))
        chance = min(last.chance, one.chance)
        kept[-1] = extreme._replace(low=last.low, high=one.high, chance=chance), strongest
    return kept


def _one_cause(one: _Cause, other: _Cause) -> bool:
    # Effects are told apart by identity: their draws are arrays.
    named = ([id(effect) for effect in each.named] for each in (one, other))
    return one.fields == other.fields and next(named) == next(named)


def _entry(one: Difference, cause: _Cause) -> Mismatch:
    power = f"{one.ratio:.3g} times the power of the simulation"
    if one.at != (one.low, one.high):
        far = "up to" if one.ratio > 1 else "as little as"
        place = span(*one.at)
        power = f"{far} {power} ({place[0].lower()}{place[1:]})"
    return {
        **one.band,
        "ratio": one.ratio,
        "p_value": one.chance,
        "sentence": f"{span(one.low, one.high)} the recording has {power}: {cause.why}.",
        **cause.fields,
    }
