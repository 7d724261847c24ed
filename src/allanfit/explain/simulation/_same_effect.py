"""Effects that recording and simulation both have: which are one, and are they of one size?"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import chi2

from .._effect import Effect
from .._mismatch import CHANCE_FLOOR, Located, meet

# Exact parameters differ by more than this part.
_EXACT = 0.01
# Exact ones of these values say what kind an effect is.
_FLAGS = (0.0, 1.0)
# Names of one peak, which are told apart by little.
_PEAKS = ("sinusoid", "drifting_line", "resonance")


class Off(NamedTuple):
    """A parameter of an effect that recording and simulation have of different sizes."""

    parameter: str
    #: In SI units and seconds.
    own: float
    theirs: float
    #: The recording's 95 % interval.
    interval: tuple[float, float]
    #: That estimates of one value differ as much, for all parameters of the effect.
    chance: float


class Pair(NamedTuple):
    """An effect of the recording, and what it is in the simulation."""

    own: Located
    theirs: Located
    #: What differs most, if anything does.
    off: Off | None


def pairs(found: Sequence[Located], simulated: Sequence[Located], chance: float) -> list[Pair]:
    """Effects that both have, each once; sizes differ where chance does so more rarely."""
    left, both = list(simulated), []
    for own in found:
        alike = [each for each in left if _alike(own, each)]
        if alike:
            # Of one name first.
            theirs = max(alike, key=lambda each: each.effect.name == own.effect.name)
            left = [each for each in left if each is not theirs]
            off = _off(own.effect, theirs.effect)
            both.append(Pair(own, theirs, off if off and off.chance < chance else None))
    return both


def _alike(one: Located, other: Located) -> bool:
    """Whether two effects are one kind of thing, and if that has a band, of one band."""
    names = one.effect.name, other.effect.name
    if one.entry["domain"] == other.entry["domain"] == "time":
        return names[0] == names[1]
    if names[0] == names[1] and names[0] not in _PEAKS:
        return True
    return meet(one.entry, other.entry)


def _off(own: Effect, theirs: Effect) -> Off | None:
    """The parameter that differs most, and the chance that all estimate the same.

    Normal, and sizes in the logarithm: then the distance is a chi-square by both covariances.
    """
    if own.name != theirs.name:
        return None
    names, ours, others, exact = [], [], [], []
    for name in sorted(own.parameters.keys() & theirs.parameters.keys()):
        one, other = (np.asarray(each.parameters[name], float) for each in (own, theirs))
        if np.ptp(one) == 0 and np.ptp(other) == 0:
            exact += [name] if _unequal(float(one[0]), float(other[0])) else []
            continue
        if min(one.min(), other.min()) > 0:
            one, other = np.log(one), np.log(other)
        names.append(name)
        ours.append(one)
        others.append(other)
    if exact:
        return _as_off(own, theirs, exact[0], CHANCE_FLOOR)
    if not names:
        return None
    # Together, since the parameters of a filter may each be known badly and both well.
    distance = np.array([np.median(a) - np.median(b) for a, b in zip(ours, others, strict=True)])
    covariance = sum(_covariance(each) for each in (ours, others))
    square = float(distance @ np.linalg.pinv(covariance, hermitian=True) @ distance)
    farthest = np.argmax(np.abs(distance) / np.sqrt(np.diag(covariance)))
    chance = max(float(chi2.sf(square, len(names))), CHANCE_FLOOR)
    return _as_off(own, theirs, names[int(farthest)], chance)


def _covariance(draws: list[Float[np.ndarray, " draws"]]) -> Float[np.ndarray, "names names"]:
    """Of parameters drawn together; what is exact has none."""
    if len({each.size for each in draws}) > 1:
        return np.diag([np.var(each) for each in draws])
    return np.atleast_2d(np.cov(np.stack(draws)))


def _unequal(one: float, other: float) -> bool:
    """Whether two exact numbers differ, flags aside."""
    flags = one in _FLAGS and other in _FLAGS
    return not flags and abs(one - other) > _EXACT * max(abs(one), abs(other))


def _as_off(own: Effect, theirs: Effect, name: str, chance: float) -> Off:
    low, high = np.quantile(np.asarray(own.parameters[name], float), [0.025, 0.975])
    return Off(name, own.value(name), theirs.value(name), (float(low), float(high)), chance)
