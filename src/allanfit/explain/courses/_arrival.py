"""Steps with the edge and at the moment that the samples about them show.

Behind a filter noise is weak at high frequency, and there a step drawn too steep, or a sample too
early, stands out of the whitened record by more than itself.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.fft import rfft

from .._refit import moved_by, resize
from .._state import Investigation
from ..spectrum._whiten import HEARD, KERNEL, level, mode_frequency, precision, shaped
from ._course import Course, Edge, risen, step
from ._passing import FINE, half_and_rise, passing

# A step is moved by so many samples, and by twice as many as it takes to be there.
_REACH = 8
# What another place or edge has to gain, in twice the log-likelihood.
_BETTER, _ALIKE = 6.0, 2.0


class _Place(NamedTuple):
    """Where a step is, by which edge, and what it gains there, in twice the log-likelihood."""

    gain: float
    time: float
    edge: Edge | None


def settle(state: Investigation) -> None:
    """Each step with the edge and at the moment that the samples about it show."""
    begin = 0
    for i, course in enumerate(state.courses):
        begin += course.sizes
        if course.name != "step":
            continue
        assert state.sized is not None
        better = settled(state, course, float(state.sized.sizes[begin - 1]))
        if better is not course:
            state.courses[i] = better.kept()
            state.moved[i] = moved_by(state, state.courses[i])
            resize(state)


def settled(state: Investigation, course: Course, height: float = 0.0) -> Course:
    """A step, which is among the courses with this height if any, as the samples show it."""
    time, through = course.shape["time"], passing(state)
    piece = next((each for each in state.pieces if each[0] < time < each[1]), None)
    if piece is None:
        return course
    edges = [None] if through is None else [through.least, through.none, None]
    found = _likeliest(state, course, height, piece, edges)
    if found is None:
        return course
    better = step(found.time, state.values.size, found.edge)
    return better._replace(places=course.places, length=course.length)


def _likeliest(
    state: Investigation,
    course: Course,
    height: float,
    piece: tuple[int, int],
    edges: Sequence[Edge | None],
) -> _Place | None:
    """The edge and the moment of a step, if they are better than those that it has."""
    time = course.shape["time"]
    start, stop = piece
    drawn, expected = course.draw()[:, 0], level(state.left, state.variance)
    bare = (state.calm + height * drawn)[start:stop]
    weights = precision(bare.size, state.left, expected, HEARD)
    told = shaped(bare, weights)
    # What differs about the step is near it.
    first = max(start, round(time) - KERNEL // 4)
    inside = np.arange(first, min(stop, first + KERNEL // 2))
    beyond, told = told[inside[-1] + 1 - start :].sum(), told[inside - start]
    # The cosine coefficients of a step anywhere are on average as those of white noise, summed up.
    frequency = mode_frequency(bare.size)[1:]
    squares = weights[1:] / (4 * bare.size * np.sin(np.pi * frequency) ** 2)
    steep = np.bincount(np.rint(frequency * KERNEL).astype(int), squares, KERNEL // 2 + 1)

    def place(heights: Float[np.ndarray, " inside"], at: float, edge: Edge | None) -> _Place:
        rise = np.abs(np.asarray(rfft(np.diff(heights, prepend=0.0), KERNEL)))
        return _Place(float(heights @ told + beyond) ** 2 / float(steep @ rise**2), at, edge)

    def best_of(edge: Edge | None) -> _Place:
        half, rise = (0, 0) if edge is None else half_and_rise(edge)
        reach = _REACH + 2 * rise
        moments = np.arange(shown - half - reach, shown - half + reach + 1)
        # With half of it within the stretch.
        moments = moments[(moments > start) & (moments + half < stop)]
        found = max((at_moment(float(at), edge) for at in moments), key=lambda one: one.gain)
        if edge is None:
            return found
        parts = np.arange(1 - FINE, FINE) / FINE
        return max((at_moment(found.time + part, edge) for part in parts), key=lambda o: o.gain)

    def at_moment(at: float, edge: Edge | None) -> _Place:
        return place(risen(inside - at, edge), at, edge)

    shown = int(inside[np.argmax(drawn[inside] >= 0.5)])
    # Of two that are alike the first.
    _, found = max(
        ((best.gain - _ALIKE * i, best) for i, best in enumerate(map(best_of, edges))),
        key=lambda each: each[0],
    )
    return found if found.gain > place(drawn[inside], time, None).gain + _BETTER else None
