"""The noise and the courses of a channel fitted again, after what is known of it has changed."""

from collections.abc import Sequence
from copy import copy
from itertools import compress
from operator import is_not
from typing import Any

import numpy as np

from ._chance import course_log_chance
from ._state import Finding, Investigation, Summed
from .courses import _course
from .courses._course import Course, Sized
from .courses._sums import Moved, Products, Summing
from .spectrum import _model
from .spectrum._ordinates import bin_edges, binned
from .spectrum._structure import MEANS, SHAPE, sieve

# Width of bins about a zero, as a part of its frequency.
_NEAR_ZERO = 0.002
# Half the degrees of freedom of a bin whose density is known to a tenth.
_MANY = 100.0
# Of the lowest of them, so many standard deviations are below what is expected.
_SURE = 2.5
# So many times as much as is there at all frequencies is not there.
_HIDDEN = 1.2
# What changes when a course, or the filter that it passes, is taken, and taken back.
_OF_COURSES = (
    "courses",
    "moved",
    "sized",
    "left_over",
    "findings",
    "model",
    "data",
    "spectrum",
    "edges",
)


def refit(state: Investigation) -> None:
    """The present structure again, with what is known of white noise that is not N."""
    # Of all white noise something has to be left for N, if not at all frequencies: behind a filter
    # nothing but rounding may be left of the fastest.
    white = 2 * float(np.exp(state.first.theta[1]))
    bins = state.data.bins
    shape = np.asarray(bins.shape)
    many = bins.used & (shape > _MANY)
    density, scatter = bins.density[many], _SURE / np.sqrt(shape[many])
    lowest, highest = (
        float(np.min(each, initial=np.inf)) for each in (density, density * (1 + scatter))
    )
    # Held samples hold their rounding too, as they do N: it is taken off N at the end.
    held = state.format.repeat is not None
    rounded = 0.0 if held else max(state.rounding.added, 0.0)
    known = 2 * (state.foreign + rounded)
    if known > _HIDDEN * highest:
        # Coarse codes hide noise, and are not the white noise that they are taken for.
        highest = 0.9 * lowest
    most = max(0.999 * white, highest if many.any() else 0.0)
    state.data = state.data._replace(foreign=min(known, most))
    theta = np.array(state.model.theta)
    starts = [(state.model.kinds, theta), (state.model.kinds, theta - np.eye(theta.size)[1])]
    state.model = min(_model.best(starts, state.data), key=lambda model: model.deviance)


def rebin(state: Investigation) -> None:
    """The present structure again, after the ordinates or the edges of the bins have changed."""
    if state.sized is not None:
        resize(state)
    else:
        _fit_what_is_left(state)


def finer_edges(state: Investigation) -> None:
    """Bins that are fine about peaks and notches, and about the zeros of a filter."""
    pairs = [(peak.frequency, peak.half_width) for peak in state.peaks]
    if state.model.kinds.shaping in MEANS:
        four = state.model.theta[SHAPE]
        taps = float(sieve(state.model.kinds.shaping, four, state.data.samples).taps(1.0))
        for zero in np.arange(1, taps / 2 + 0.1) / taps:
            pairs.append((zero, min(zero * _NEAR_ZERO, _NEAR_ZERO * 10 / taps)))
    pairs += [
        (middle, middle * width / 2) for middle, width in _model.notches(state.model, state.data)
    ]
    state.edges = bin_edges(state.spectrum.longest, tuple(pairs))
    rebin(state)


def summed(state: Investigation) -> Summed:
    """Sums over the bins of what the courses do, made anew when what they depend on is another.

    Where the noise is within its bins is a matter of its structure; its powers change it little.
    """
    old = state.last_summed
    if (
        old is None
        or old.kinds != state.model.kinds
        or old.edges is not state.edges
        or old.spectrum is not state.spectrum
    ):
        sums = Summing(state.spectrum, state.edges, state.variance)
        old = Summed(state.model.kinds, state.edges, state.spectrum, sums, (), sums.alone)
    known, products = old.moved, old.products
    if len(known) > len(state.moved) or any(map(is_not, known, state.moved)):
        known, products = (), old.sums.alone
    products = old.sums.beside(products, known, *state.moved[len(known) :])
    state.last_summed = old._replace(moved=tuple(state.moved), products=products)
    return state.last_summed


def moved_by(state: Investigation, course: Course) -> Moved:
    """The amplitudes of the ordinates of each column of a course."""
    return _course.moved_by(course, state.pieces, summed(state).sums.slow_top)


def with_course(state: Investigation, course: Course) -> Sized:
    """The courses and one more, with the noise fitted again beside them."""
    return _beside(state, course)[0]


def _beside(state: Investigation, course: Course) -> tuple[Sized, Products]:
    before = summed(state)
    products = before.sums.beside(before.products, state.moved, moved_by(state, course))
    return _course.size_up(products, before.sums, state.model, state.data), products


def evidence(state: Investigation, course: Course) -> tuple[float, float]:
    """What one more course gains, and the log of the chance that noise alone gains as much."""
    sized, products = _beside(state, course)
    gain = max(state.cost - sized.cost, 0.0)
    mine = slice(-course.sizes, None)
    known = _course.knowledge(products, mine, state.model, state.data)
    return gain, course_log_chance(gain, course.sizes, known, course.places, course.length)


def add_course(state: Investigation, course: Course, finding: Finding) -> None:
    """Take a course for real."""
    state.courses.append(course.kept())
    state.moved.append(moved_by(state, state.courses[-1]))
    state.findings.append(finding)
    resize(state)


def exchange_course(state: Investigation, course: Course) -> None:
    """Put a course in place of the one that came last."""
    state.courses[-1] = course.kept()
    state.moved[-1] = moved_by(state, state.courses[-1])
    resize(state)


def remembered(state: Investigation) -> dict[str, Any]:
    """What changes when courses or a filter are taken or taken back, for `go_back`."""
    values = {name: getattr(state, name) for name in _OF_COURSES}
    # Lists are added to in place; what else there is is made anew.
    return {
        name: copy(value) if isinstance(value, list) else value for name, value in values.items()
    }


def go_back(state: Investigation, kept: dict[str, Any]) -> None:
    """The state as it was `remembered`."""
    for name, value in kept.items():
        setattr(state, name, value)


def drop_courses(state: Investigation, gone: list[Course]) -> None:
    """Take back courses that were none, with their findings."""
    kept = [not _is_one_of(course, gone) for course in state.courses]
    named = state.findings_of([course.name for course in state.courses])
    bare = [finding for finding, stays in zip(named, kept, strict=True) if not stays]
    state.findings = [each for each in state.findings if not _is_one_of(each, bare)]
    state.courses = list(compress(state.courses, kept))
    state.moved = list(compress(state.moved, kept))
    if not state.courses:
        state.sized = state.left_over = None
    rebin(state)


def _is_one_of(one: object, many: Sequence[object]) -> bool:
    """By identity: what holds arrays cannot be compared."""
    return any(one is each for each in many)


def resize(state: Investigation) -> None:
    """The courses beside the structure as it is now."""
    found = summed(state)
    state.sized = _course.size_up(found.products, found.sums, state.model, state.data)
    amplitude, end = state.spectrum.amplitude.copy(), 0
    for moved in state.moved:
        begin, end = end, end + moved.shape[1]
        amplitude[: len(moved)] -= moved @ state.sized.sizes[begin:end]
    state.left_over = state.spectrum._replace(amplitude=amplitude)
    state.model = state.sized.model
    _fit_what_is_left(state)


def _fit_what_is_left(state: Investigation) -> None:
    state.data = state.data._replace(bins=binned(state.left, state.edges))
    state.model = _model.best([(state.model.kinds, state.model.theta)], state.data)[0]
