"""Effects that recording and simulation both have: which are one, and are they of one size?"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import norm

from ._effect import Effect
from ._mismatch import Located, meet

# Exact parameters differ by more than this part.
_EXACT = 0.01
# What is exact has no chance to differ by.
_CHANCE_FLOOR = 1e-300
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
    """The parameter that differs most."""
    if own.name != theirs.name:
        return None
    found = []
    common = own.parameters.keys() & theirs.parameters.keys()
    for name in sorted(common):
        ours, others = (np.asarray(each.parameters[name], float) for each in (own, theirs))
        chance = min(1.0, len(common) * _chance(ours, others))
        low, high = np.quantile(ours, [0.025, 0.975])
        found.append(Off(name, own.value(name), theirs.value(name), (low, high), chance))
    return min(found, key=lambda each: each.chance, default=None)


def _chance(ours: Float[np.ndarray, " draws"], theirs: Float[np.ndarray, " other"]) -> float:
    """That the two estimate one number, both normal, or their logarithms if they are sizes."""
    if np.ptp(ours) == 0 and np.ptp(theirs) == 0:
        one, other = float(ours[0]), float(theirs[0])
        alike = abs(one - other) <= _EXACT * max(abs(one), abs(other))
        return 1.0 if alike or (one in _FLAGS and other in _FLAGS) else _CHANCE_FLOOR
    if min(ours.min(), theirs.min()) > 0:
        ours, theirs = np.log(ours), np.log(theirs)
    deviation = np.hypot(np.std(ours), np.std(theirs))
    distance = abs(float(np.median(ours) - np.median(theirs)))
    return max(2 * float(norm.sf(distance, scale=deviation)), _CHANCE_FLOOR)
