"""What a round may choose, with the chance of it: courses in time."""

from typing import Any

import numpy as np

from .._chance import course_score
from .._options import Option
from .._refit import add_course, evidence, with_course
from .._state import Finding, Investigation
from ..values._discrete import CROSSED, LASTING, codes_over_noise
from ._arrival import settled
from ._course import Course
from ._scan import propose
from ._shapes import at_its_edges, refined, together

# That the course of a measured cause fits by coincidence is 20 times less likely than that it is
# the cause, as twice a logarithm.
_MEASURED = 6.0
# So many samples on either side tell from where to where a step goes.
_BESIDE = 256


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
        if course.name == "step" and state.model.kinds.filtering:
            # Noise behind a filter contradicts a sharp one.
            course = settled(state, course)
        if course.name == "step" and _crosses_codes(state, course):
            continue
        gain, log_p = evidence(state, course)
        if course.name == "vibration_rectification" and log_p < np.log(state.alarm):
            # Steps compete that are at their places already.
            gain = max(gain, evidence(state, at_its_edges(state, course)[0])[0])

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


def _crosses_codes(state: Investigation, course: Course) -> bool:
    """Whether a step may be a slow change that goes from one code to the next.

    Where codes are much wider than the noise, that is what it looks like.
    """
    if state.format.normal or codes_over_noise(state) < LASTING:
        return False
    width, at = state.format.width, round(course.shape["time"])
    if abs(float(with_course(state, course).sizes[-1])) > CROSSED * width:
        return False
    if state.in_codes:
        return True
    either = state.values[max(at - _BESIDE, 0) : at], state.values[at : at + _BESIDE]
    before, after = (each[np.isfinite(each)] for each in either)
    if not (before.size and after.size):
        return False
    code = np.nanmedian(state.values)
    return bool(np.ptp(np.rint([np.mean(each - code) / width for each in (before, after)])))
