"""One more effect at a time: lines, smooth effects and courses compete, and one is taken."""

from typing import Any

import numpy as np
from scipy.special import factorial, gammaln
from scipy.stats import poisson

from ._bumps import of_a_peak
from ._chance import log_chance
from ._options import OF_FILTERS, Option, smooth_option, smooth_options
from ._refit import go_back, remembered
from ._state import Finding, Investigation
from .courses._options import course_options
from .lines._taken import BAND, LINE, line_options
from .spectrum import _search
from .spectrum._leakage import take_bump
from .spectrum._model import is_narrow_notch, ripples
from .spectrum._narrow import narrow_groups
from .spectrum._structure import ECHO, NARROW

# Broad noises, of which one is as good a witness as another that something is left out; with so
# many times the chance that an alarm has.
_STAND_INS = ("gauss_markov", "power_law")
LEEWAY = 3.0
# Courses that hide together with broad noise behind one random walk, if their chance is so small.
_SLOW, _HINT = ("warm_up", "temperature"), float(np.log(0.1))
# Steps that are no chance together: so many, each with such a chance.
_MOST_STEPS, _STEP_HINT = 4, float(np.log(0.3))
# What has no name and gains so many times as much as all else is no part of something else.
_FAR_AHEAD = 2.0


def take_one(state: Investigation, drivers: dict[str, Any]) -> bool:
    """One more effect, if any is needed; says whether one was."""
    lines, courses = line_options(state), course_options(state, drivers)
    if lines and lines[0].name == LINE and _is_first(state, lines, courses):
        lines[0].take({})
        return True
    found = _finite(lines + smooth_options(state) + courses)
    state.nearest = min([state.nearest, *(option.log_p for option in found)])
    if _take_unnamed(state, found):
        return True
    alarms = _alarms(state, found)
    if not alarms:
        return _take_together(state, found) or _take_steps(state, found)
    # Lines first: nothing smooth explains one, and one distorts what is smooth.
    chosen, among = _choice(state, alarms)
    if among is None and chosen.name in (*_STAND_INS, *_SLOW):
        # That something is left out is told by one, and what it is by the likeliest.
        alike, close = _STAND_INS, np.log(LEEWAY * state.alarm)
        if chosen.name in _SLOW:
            alike, close = _SLOW, _HINT
        near = [each for each in found if each.log_p < close and each.name in alike]
        chosen = max(near, key=lambda option: option.score)
    rivals: dict[str, float] = {}
    for option in found:
        # What a line explains nothing smooth does, and has its own turn: it is no rival.
        if option.name not in (LINE, BAND, *OF_FILTERS) and (among is None or option.name in among):
            rivals[option.name] = max(option.score, rivals.get(option.name, -np.inf))
    chosen.take(rivals)
    return True


def _take_unnamed(state: Investigation, found: list[Option]) -> bool:
    """A notch or an echo, if nothing that has a name comes near it; says whether one was taken.

    Filters and noises would be made of what lies to either side, or of ripples.
    """
    most = max((option.gain for option in found), default=0.0)
    first = _search.notch(state.model, state.data, most / _FAR_AHEAD)
    for unnamed in first + _search.echo(state.model, state.data, most):
        log_p = log_chance("bump", unnamed.gain)
        if unnamed.gain < _FAR_AHEAD * most or log_p > np.log(state.alarm):
            continue
        if not (is_narrow_notch(unnamed.model, state.data) or ripples(unnamed.model, state.data)):
            continue
        if of_a_peak(state, unnamed):
            continue
        # The same echo may gain a hair more from another start.
        shape = unnamed.model.kinds.shaping
        others = [
            other
            for other in _search.bumps(state.model, state.data)
            if not shape == other.model.kinds.shaping == ECHO
        ]
        if any(other.gain > unnamed.gain for other in others):
            # A lack toward zero frequency is none.
            continue
        state.nearest = min(state.nearest, log_p)
        state.findings.append(Finding("bump", log_p, unnamed.gain))
        take_bump(state, unnamed)
        return True
    return False


def _take_together(state: Investigation, found: list[Option]) -> bool:
    """A slow course and correlated noise, if both together are no chance; says whether they were.

    Each alone leaves a random walk that stands for the other, beside which it gains little.
    """
    slow = [each for each in found if each.name in _SLOW and each.log_p < _HINT]
    if not slow:
        return False
    course = min(slow, key=lambda option: option.log_p)
    kept = remembered(state)
    course.take({})
    noise = min(
        (each for each in smooth_options(state) if each.name in _STAND_INS),
        key=lambda option: option.log_p,
        default=None,
    )
    if noise is not None:
        together = _of_product(course.log_p + noise.log_p + np.log(len(_SLOW)), 2)
        state.nearest = min(state.nearest, together)
        if together < np.log(state.alarm):
            state.findings[-1].log_p = together
            noise.take({})
            return True
    go_back(state, kept)
    return False


def _take_steps(state: Investigation, found: list[Option]) -> bool:
    """Several steps of which each may be chance, but hardly all; says whether they were taken.

    A bias that goes elsewhere for a while and comes back has two. Where it climbs, a random walk
    stands for all of them, and lets none stand out before the others are taken.
    """
    kept, chances = remembered(state), []
    while len(chances) < _MOST_STEPS:
        step = _strongest_step(found if not chances else course_options(state, {}))
        if step is None:
            break
        chances.append(step.log_p)
        step.take({})
        together = _together(chances)
        state.nearest = min(state.nearest, together)
        if together < np.log(state.alarm):
            for finding in state.findings[-len(chances) :]:
                finding.log_p, finding.detail = together, len(chances)
            return True
    go_back(state, kept)
    return False


def _together(chances: list[float]) -> float:
    """Log of the chance of as many steps, each as unlikely; one alone had its turn.

    Where there is none, chances are points of a Poisson process of rate one. Two of them are as
    small as the larger one as often as this says. Of more it is their product that tells: subsets
    of so many are 1/k! as many as ordered ones, whose product is by Fisher's law.
    """
    count = len(chances)
    if count == 2:
        return float(poisson.logsf(1, np.exp(max(chances))) + np.log(2))
    if count < 2:
        return 0.0
    return float(min(0.0, _of_product(sum(chances), count) - gammaln(count + 1) + np.log(2)))


def _of_product(log_product: float, count: int) -> float:
    """Log of the chance of such a product of so many probabilities, by Fisher's law."""
    powers = np.arange(count)
    return float(log_product + np.log(np.sum((-log_product) ** powers / factorial(powers))))


def _strongest_step(found: list[Option]) -> Option | None:
    steps = [option for option in found if option.name == "step" and option.log_p < _STEP_HINT]
    return min(steps, key=lambda option: option.log_p, default=None)


def _is_first(state: Investigation, lines: list[Option], courses: list[Option]) -> bool:
    """Whether a line is the first to take, known without a search for smooth effects.

    That takes most of a round, and of a record with many lines as many. A line that was taken left
    the rest as it was, so that what each effect gains is near the place where it was found before.
    """
    found = state.searched
    if found is None or found.of != (state.model.kinds, len(state.peaks)):
        return False
    near = [_search.again(each, state.model, state.data) for each in found.candidates]
    every = _finite(lines + [smooth_option(state, each) for each in near] + courses)
    alarms = _alarms(state, every)
    return lines[0] in alarms and _choice(state, alarms)[0] is lines[0]


def _alarms(state: Investigation, found: list[Option]) -> list[Option]:
    return [option for option in found if option.log_p < np.log(state.alarm)]


def _finite(found: list[Option]) -> list[Option]:
    return [option for option in found if np.isfinite(option.log_p)]


def _choice(state: Investigation, alarms: list[Option]) -> tuple[Option, tuple[str, ...] | None]:
    """What to take first, and among which rivals; None for all.

    A line comes first, since nothing smooth explains one; but not while the level on which it
    stands is grossly wrong. Then a filter, which bends that level; then what is narrow.
    """
    lines = [option for option in alarms if option.name in (LINE, BAND)]
    others = [option for option in alarms if option not in lines]
    best = max(others, key=lambda option: option.score, default=None)
    narrow = [option for option in lines if option.name == LINE]
    if narrow and (best is None or narrow[0].log_p < best.log_p):
        return narrow[0], ()
    if best is not None and best.name == "low_pass":
        return best, None
    if lines and (best is None or best.name in NARROW):
        return lines[0], ()
    if len(state.peaks) > sum(map(len, narrow_groups(state))):
        sharp = [option for option in others if option.name in NARROW]
        if sharp:
            return max(sharp, key=lambda option: option.score), NARROW
    if best is None:
        return lines[0], ()
    return best, None
