"""What a round may choose: effects of the spectrum and courses in time, each with its chance."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ._chance import course_score, log_chance, score
from ._refit import add_course, evidence
from ._state import Finding, Investigation, Searched
from .courses._course import Course
from .courses._scan import propose
from .courses._shapes import at_its_edges, refined, together
from .spectrum import _search
from .spectrum._leakage import leave_leakage
from .spectrum._model import rarity
from .spectrum._search import Candidate
from .spectrum._structure import NARROW

#: Another shape of a filter that is known.
DROOP = "droop"
# That the course of a measured cause fits by coincidence is 20 times less likely than that it is
# the cause, as twice a logarithm.
_MEASURED = 6.0


class Option(NamedTuple):
    """Something that a round may choose."""

    name: str
    log_p: float
    gain: float
    score: float
    #: Takes it, given the scores of its rivals by name.
    take: Callable[[dict[str, float]], None]


def smooth_options(state: Investigation) -> list[Option]:
    """Each effect of the spectrum, where it gains most beside what the model holds."""
    pairs = tuple((peak.frequency, peak.half_width) for peak in state.peaks)
    candidates = _search.candidates(state.model, state.data, pairs)
    state.searched = Searched((state.model.kinds, len(state.peaks)), candidates)
    return [smooth_option(state, candidate) for candidate in candidates]


def smooth_option(state: Investigation, candidate: Candidate) -> Option:
    """Such an effect, to be taken as it was found."""
    chance = log_chance(candidate.name, candidate.gain)

    def take(rivals: dict[str, float]) -> None:
        state.model = candidate.model
        if state.model.kinds.angle_filtered:
            leave_leakage(state)
        # Another shape of a filter is no effect of its own, but of what is found already.
        if candidate.name != DROOP:
            finding = Finding(candidate.name, chance, candidate.gain, rivals)
            state.findings.append(finding)

    worth = score(candidate.name, candidate.gain)
    if candidate.name in (*NARROW, "gauss_markov"):
        worth += rarity(candidate.model, state.data)
    return Option(candidate.name, chance, candidate.gain, worth, take)


def course_options(state: Investigation, drivers: dict[str, Any]) -> list[Option]:
    """The courses in time that look most promising."""
    proposals = propose(
        state.values.size, state.pieces, state.calm, state.left, state.model, state.data, drivers
    )
    options: list[Option] = []
    for course in proposals:
        if any(course.name == old.name and course.shape == old.shape for old in state.courses):
            continue
        if state.switching and course.name == "step":
            continue
        gain, log_p = evidence(state, course)
        if course.name == "vibration_rectification" and log_p < np.log(state.alarm):
            # Steps compete that are at their places already.
            course, _ = at_its_edges(state, course)
            gain = max(gain, evidence(state, course)[0])

        def take(
            rivals: dict[str, float],
            course: Course = course,
            log_p: float = log_p,
            gain: float = gain,
        ) -> None:
            best = refined(state, course, drivers)
            add_course(state, best, Finding(course.name, log_p, gain, rivals))
            together(state)

        worth = course_score(gain, course.sizes, course.places, course.length)
        if course.name in drivers:
            worth += _MEASURED
        options.append(Option(course.name, log_p, gain, worth, take))
    return options
