"""Whether steps there and back are one shift of the mean while the noise is loud."""

import numpy as np
from jaxtyping import Float

from .._chance import course_score
from .._refit import add_course, drop_courses, evidence, go_back, remembered
from .._state import Finding, Investigation
from ..strength._lasting import count_out, loudness, move_loud_times
from ._course import Course
from ._shapes import at_its_edges

_NAME = "vibration_rectification"


def steps_while_loud(state: Investigation) -> bool:
    """Put one shift in the place of all steps, if that is likelier; says whether it was.

    Where loud times are hardly louder, what their noise tells of their edges is vague, and a shift
    that has the wrong ones gains less than a step at each, or leaves some. The steps are edges too.
    """
    changing, mine = state.modulation, [c for c in state.courses if c.name in (_NAME, "step")]
    steps = [course for course in mine if course.name == "step"]
    if changing is None or changing.odds is None or changing.strength is not None:
        return False
    if len(steps) < 2:
        return False
    odds = np.zeros(state.values.size)
    odds[state.looked_at] = changing.odds
    before = float(odds[state.flags(changing.loud)].sum())
    path = _drawn(state, mine)
    high = path > (path.min() + path.max()) / 2
    loud = max(high, ~high, key=lambda flags: float(odds[flags].sum()))
    rivals = sum(course_score(0.0, each.sizes, each.places, each.length) for each in mine)

    kept, cost = remembered(state), state.cost
    drop_courses(state, mine)
    state.modulation = changing.at_times(loud[state.looked_at])
    shape = loudness(state, state.modulation)
    course, moved = at_its_edges(state, Course(_NAME, lambda: shape, 1, {}))
    gain, log_p = evidence(state, course)
    told = 2 * (float(odds[state.flags(moved.loud)].sum()) - before)
    own = cost - (state.cost - gain) + told + course_score(0.0, 1)
    if own < rivals:
        go_back(state, kept)
        state.modulation = changing
        return False
    add_course(state, course, Finding(_NAME, log_p, gain, {_NAME: own, "step": rivals}))
    move_loud_times(state, moved)
    count_out(state, moved)
    return True


def _drawn(state: Investigation, courses: list[Course]) -> Float[np.ndarray, " samples"]:
    """What some of the courses add to each sample [u]."""
    assert state.sized is not None
    path, end = np.zeros(state.values.size), 0
    for course in state.courses:
        begin, end = end, end + course.sizes
        if any(course is each for each in courses):
            path += course.draw() @ state.sized.sizes[begin:end]
    return path
