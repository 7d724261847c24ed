"""What a round may choose, with the chance of it: effects of the spectrum."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ._chance import log_chance, score
from ._state import Finding, Investigation, Searched
from .courses._arrival import settle
from .spectrum import _search
from .spectrum._leakage import leave_leakage
from .spectrum._model import rarity
from .spectrum._search import Candidate
from .spectrum._structure import MEANS, NARROW, RIPPLED, WINDOWED

#: Another shape of a filter that is known, and white noise behind it.
OF_FILTERS = "droop", "floor"


class Option(NamedTuple):
    """Something that a round may choose."""

    name: str
    log_p: float
    gain: float
    score: float
    #: Takes it, given the scores of its rivals by name.
    take: Callable[[dict[str, float]], None]


def smooth_options(state: Investigation) -> list[Option]:
    """Each effect of the spectrum, where it gains most beside what the model holds.

    None where noise hides within a code.
    """
    if state.in_codes:
        return []
    pairs = tuple((peak.frequency, peak.half_width) for peak in state.peaks)
    candidates = _search.candidates(state.model, state.data, pairs)
    state.searched = Searched((state.model.kinds, len(state.peaks)), candidates)
    return [smooth_option(state, candidate) for candidate in candidates]


def smooth_option(state: Investigation, candidate: Candidate) -> Option:
    """Such an effect, to be taken as it was found."""
    chance = log_chance(candidate.name, candidate.gain)

    def take(rivals: dict[str, float]) -> None:
        state.model = candidate.model
        whole = state.spectrum
        if state.model.kinds.angle_filtered:
            leave_leakage(state)
        if state.model.kinds.shaping in (*RIPPLED, *MEANS) and not state.courses:
            better = _search.ripple_again(state.model, state.data)
            if better.kinds != state.model.kinds:
                # What was left out was about the zeros of another.
                state.spectrum, state.model = whole, better
                leave_leakage(state)
        if state.model.kinds.shaping == WINDOWED and not state.courses:
            state.model = _search.window_again(state.model, state.data)
        if candidate.name == "low_pass":
            settle(state)
        # Another shape of a filter is no effect of its own, but of what is found already.
        if candidate.name not in OF_FILTERS:
            finding = Finding(candidate.name, chance, candidate.gain, rivals)
            state.findings.append(finding)

    worth = score(candidate.name, candidate.gain)
    if candidate.name in (*NARROW, "gauss_markov"):
        worth += rarity(candidate.model, state.data)
    return Option(candidate.name, chance, candidate.gain, worth, take)


def take_filter(state: Investigation) -> None:
    """Take a filter, if there is one: behind it noise looks like a walk that hides steps."""
    if state.model.kinds.filtering:
        return
    found = smooth_options(state)
    best = max(found, key=lambda option: option.score, default=None)
    if best is not None and best.name == "low_pass" and best.log_p < np.log(state.alarm):
        best.take({each.name: each.score for each in found})
