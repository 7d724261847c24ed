"""Taking the switches of a telegraph: what goes with them, and what is told again beside them."""

import numpy as np

from .._options import smooth_options, take_filter
from .._refit import add_course, drop_courses, exchange_course, go_back, refit, remembered
from .._state import Finding, Investigation, whitened_piece
from ..lines._taken import take_strong_lines
from ..spectrum import _model
from ..spectrum._structure import TERMS
from ..strength._lasting import about_spread
from ..values._alone import read_again
from ..values._held_out import Gain
from ._one_by_one import Seen, likely_one_by_one, seen_again, seen_along
from ._passing import passing
from ._phase import with_phase
from ._switch_times import placed
from ._switches import quiet

# A step as tall as the levels are apart differs by such a part.
_ALIKE = 0.35
# The noise that switches leave is looked at so many times.
_MOST_LOOKS = 4


def take_switches(
    state: Investigation, made: Investigation, knocks: list[tuple[int, int]], seed: int
) -> bool:
    """Take switches that are seen one by one, if they are; says whether they were.

    Nothing of `knocks` may be left without them. Spikes are told again beside them.
    """
    take_strong_lines(state)
    kept = remembered(state)
    if state.model.kinds.filtering:
        _take_filter_again(state)
    else:
        take_filter(state)
    seen = _switch_by_switch(state)
    if seen is not None and quiet(state, whitened_piece(state, state.longest), knocks):
        state.gains[seen.course.name] = Gain(-seen.cost, 0.0)
        found = state.findings[-1]
        state.witness(
            "two levels",
            seen.count,
            float(np.exp(found.log_p)),
            "Switches between two levels seen one by one, against a process that wanders.",
        )
        without_spikes(state, made)
        _place(state, seen)
        about_spread(state, seed, may_cut=False)
        return True
    go_back(state, kept)
    return False


def _place(state: Investigation, seen: Seen) -> None:
    """Each switch of the course that came last at its sample, and as a filter passes it."""
    seen = placed(state, seen)
    exchange_course(state, seen.course)
    if not state.model.kinds.filtering:
        return
    _take_filter_again(state)
    no_phase, cost = remembered(state), state.cost
    exchange_course(state, with_phase(state, seen).course)
    _take_filter_again(state)
    if state.cost > cost:
        go_back(state, no_phase)


def steps_are_switches(state: Investigation) -> bool:
    """Whether a step is a switch that was missed, which leaves two levels; it is taken as one.

    The first level may be taken for the other where the mean is another one too, as in a warm-up.
    """
    found = state.finding("random_telegraph")
    names = [course.name for course in state.courses]
    if found is None or "random_telegraph" not in names or passing(state) is not None:
        return False
    assert state.sized is not None
    ends = np.cumsum([course.sizes for course in state.courses])
    sizes = dict(zip(map(id, state.courses), state.sized.sizes[ends - 1], strict=True))
    telegraph = state.courses[names.index("random_telegraph")]
    path, height = telegraph.draw()[:, 0], sizes[id(telegraph)]
    for step in (course for course in state.courses if course.name == "step"):
        times = sizes[id(step)] / height
        level = path + np.sign(times) * step.draw()[:, 0]
        if abs(abs(times) - 1) > _ALIKE or np.ptp(level) > 1:
            continue
        values = state.calm + height * path + sizes[id(step)] * step.draw()[:, 0]
        seen = seen_along(state, values, level - level.min())
        if seen is not None:
            drop_courses(state, [telegraph, step])
            add_course(state, seen.course, found)
            _place(state, seen)
            return True
    return False


def _switch_by_switch(state: Investigation) -> Seen | None:
    """Take switches that are likelier than a process that wanders; says which, if there are."""
    seen = likely_one_by_one(state)
    if seen is None:
        return None
    names = state.model.kinds.names
    if "gauss_markov" not in names and take_process(state):
        names = state.model.kinds.names
    before = state.cost
    if "gauss_markov" in names:
        state.findings = [each for each in state.findings if each.name != "gauss_markov"]
        state.model = _model.without(state.model, names.index("gauss_markov"))
    found = Finding(seen.course.name, 0.0, 0.0)
    add_course(state, seen.course, found)
    _take_filter_again(state)
    for _ in range(_MOST_LOOKS):
        looks = seen_again(state, seen)
        if not looks:
            return None
        again = min(looks, key=lambda look: _cost_with(state, look))
        exchange_course(state, again.course)
        # Each that is seen leaves less noise to the others.
        if again.count <= seen.count:
            break
        seen = again
    found.gain = before - state.cost
    found.log_p = again.cost - found.gain / 2
    certain = again.clear and again.alike and found.log_p < np.log(state.alarm)
    return again if certain else None


def _cost_with(state: Investigation, seen: Seen) -> float:
    """What the record costs with these switches in place of those that came last [nats]."""
    exchange_course(state, seen.course)
    return state.cost / 2 + seen.cost


def _take_filter_again(state: Investigation) -> None:
    """The filter, after switches were taken out of the spectrum as they are known now.

    What they left in it before made another filter likely, and N hard to see.
    """
    if state.model.kinds.filtering and not state.model.kinds.added:
        kept, deviance = remembered(state), state.model.deviance
        state.findings = [each for each in state.findings if each.name != "low_pass"]
        state.model = _model.five_terms(np.exp(state.first.theta[:TERMS]), state.data)
        take_filter(state)
        if state.model.deviance > deviance:
            go_back(state, kept)


def take_process(state: Investigation) -> bool:
    """Take a Gauss-Markov process, if there is one; says whether there was."""
    found = [each for each in smooth_options(state) if each.name == "gauss_markov"]
    best = min(found, key=lambda option: option.log_p, default=None)
    if best is None or best.log_p >= np.log(state.alarm):
        return False
    best.take({each.name: each.score for each in found})
    return True


def without_spikes(state: Investigation, made: Investigation) -> None:
    """Spikes that were none are among the values again, as these were `made`."""
    state.values, state.contamination = made.values, None
    state.foreign, state.unseen = made.foreign, made.unseen
    state.findings = [each for each in state.findings if each.name != "outliers"]
    state.gains.pop("outliers", None)
    read_again(state)
    refit(state)
