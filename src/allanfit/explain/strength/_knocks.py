"""Brief times in which a sensor was disturbed: knocks, steps that look like them, wrong ends."""

import numpy as np
from jaxtyping import Float

from .._intervals import runs, widened
from .._options import take_filter
from .._refit import add_course, evidence, go_back, remembered, with_course
from .._state import Finding, Investigation, whitened_pieces
from ..courses import _course
from ..courses._arrival import settled
from ..values._held_out import of_times
from ._bursts import Burst
from ._modulation import Modulation

# A knock is cut out with so many windows on either side.
_MARGIN = 2
# Brief disturbances that fill more than this are no brief ones, but noise that changes.
BRIEF_SHARE = 0.05
# More jumps than this are no steps.
_MOST_STEPS = 8
# As far as a scan for a step in white noise goes.
_STEP_PATH = 100.0
# A sample at either end is compared with so many neighbours, as are others at so many places; up to
# so many samples are wrong if they are several times as far from them as nearly all others are.
_NEIGHBOURS, _END_PLACES, _MOST_WRONG = 32, 2000, 4
_NEARLY_ALL, _FAR_OUT = 0.99, 5.0


def knock(
    state: Investigation, changing: Modulation, white: Float[np.ndarray, " looked_at"]
) -> None:
    """The loud times are a disturbance, to be cut out with a margin, beside those that are."""
    # With their margins some may be one.
    wide = widened(state.flags(changing.loud), changing.window * _MARGIN)
    for start, stop in state.knocks:
        wide[start:stop] = True
    state.knocks = runs(wide)
    log_p, gain = float(np.log(max(changing.p_value, 1e-300))), of_times(white, changing.loud)
    before = state.finding("disturbance")
    if before is not None:
        log_p, gain = min(log_p, before.log_p), max(gain, state.gains["disturbance"])
    state.name_once(Finding("disturbance", log_p, 0.0, {}, changing))
    state.gains["disturbance"] = gain


def moved_while_loud(state: Investigation) -> bool:
    """Whether the mean is another one in the brief times that are loud.

    The sensor was moved then, however little louder it is. If so these times have to be cut out.
    """
    changing = state.modulation
    if changing is None or state.knocks or changing.loud.mean() > BRIEF_SHARE:
        return False
    near = np.append(widened(state.flags(changing.loud), changing.window), False)
    steps = [round(course.shape["time"]) for course in state.courses if course.name == "step"]
    rectified = any(course.name == "vibration_rectification" for course in state.courses)
    if not rectified and not near[steps].any():
        return False
    knock(state, changing, whitened_pieces(state))
    return True


def wrong_ends(values: Float[np.ndarray, " samples"]) -> Modulation | None:
    """The first or the last samples, if they are far from all that follows or precedes.

    Where a logger begins or stops in the middle of a message. What is made white has no such
    sample: its record is mirrored at the ends.
    """
    if values.size < 4 * _NEIGHBOURS:
        return None
    loud, heights = np.zeros(values.size, bool), []
    for x, mine in ((values, loud), (values[::-1], loud[::-1])):
        near = np.lib.stride_tricks.sliding_window_view(x, 1 + _NEIGHBOURS)
        near = near[:: max(len(near) // _END_PLACES, 1)]
        apart = np.abs(near[:, 0] - np.median(near[:, 1:], axis=1))
        usual = float(np.quantile(apart[1:], _NEARLY_ALL))
        if usual == 0:
            return None
        # A few samples at most, each of which is far from what comes after them all.
        far = np.abs(x[:_MOST_WRONG] - np.median(x[_MOST_WRONG:_NEIGHBOURS])) > _FAR_OUT * usual
        mine[: int(np.argmin(np.append(far, False)))] = True
        heights.append(apart[0] / usual)
    if not loud.any():
        return None
    ratio = float(max(heights))
    return Modulation(ratio, np.full(1, ratio), loud, 1, 1e-300)


def as_modulation(white: Float[np.ndarray, " samples"], brief: Burst) -> Modulation:
    """Brief loud times in the words of lasting ones."""
    loud, quiet = white[brief.loud].std(), white[~brief.loud].std()
    ratio = float(loud / quiet)
    draws = np.full(1, ratio)
    return Modulation(
        ratio, draws, brief.loud, max(brief.window // 4, 1), float(np.exp(brief.log_p))
    )


def steps_instead(state: Investigation, changing: Modulation) -> bool:
    """Whether the mean jumps where it is loud: whitening makes a pulse of a step.

    Takes the steps if so; else leaves everything as it was.
    """
    found = runs(state.flags(changing.loud))
    if len(found) > _MOST_STEPS or any(course.name == "step" for course in state.courses):
        return False
    before = remembered(state)
    take_filter(state)
    for a, b in found:
        middle, half = (a + b) / 2, max((b - a) / 2, changing.window)
        course = _course.polish(
            _course.step(round(middle), state.values.size)._replace(length=_STEP_PATH),
            lambda at: _course.step(round(at), state.values.size),
            middle,
            half / 2,
            lambda tried: -with_course(state, tried).cost,
        )
        course = settled(state, course)
        gain, log_p = evidence(state, course)
        if log_p > 2 * np.log(state.alarm):
            break
        add_course(state, course, Finding("step", log_p, gain))
    else:
        return True
    go_back(state, before)
    return False
