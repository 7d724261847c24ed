"""Courses with the shape that fits best: when, how fast, how late."""

from itertools import combinations, pairwise
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

from .._refit import evidence, moved_by, resize, summed, with_course
from .._state import Investigation
from ..strength._lasting import loudness, move_loud_times
from ..strength._modulation import Modulation
from . import _course
from ._arrival import settled
from ._course import Course
from ._edges import sharpened
from ._sums import Summing

# Periods in the record from one place of the scan for slow oscillations to the next.
_BETWEEN = 0.1
# Windows in which loudness is told by which chance may move an edge of loud times.
_WINDOWS = 4
# Several warm-ups are fitted together from the best of so many constants, the shortest such a part
# of the record, with steps of such a logarithm and so many tries.
_CONSTANTS, _SHORTEST, _SIMPLEX, _TRIES = 7, 200.0, 0.3, 120


def refined(state: Investigation, course: Course, drivers: dict[str, Any]) -> Course:
    """The course at its best place in time."""
    start, stop = state.longest
    length, samples = stop - start, state.values.size

    def gain(tried: Course) -> float:
        return -with_course(state, tried).cost

    if course.name == "step":
        if state.model.kinds.filtering:
            # It is placed already, by the samples about it.
            return course
        course = _course.polish(
            course,
            lambda at: _course.step(round(at), samples),
            course.shape["time"],
            length / 2000,
            gain,
        )
        return settled(state, course)
    if course.name == "warm_up":
        constant = course.shape["time_constant"]
        return _course.polish(
            course, lambda c: _course.warm_up(c, samples), constant, constant / 5, gain
        )
    if course.name == "sinusoid":
        return _slow_line(state, course)
    if course.name == "temperature" and course.shape["lag"]:
        felt, lag = drivers["temperature"][:, 0], abs(course.shape["lag"])
        sign = np.sign(course.shape["lag"])
        return _course.polish(course, lambda c: _course.late(felt, sign * c), lag, lag / 2, gain)
    if course.name == "vibration_rectification":
        course, moved = at_its_edges(state, course)
        move_loud_times(state, moved)
    return course


def _slow_line(state: Investigation, course: Course) -> Course:
    """A slow oscillation at its best frequency, with the standard deviation of that."""
    first, span = state.longest[0], state.pieces[-1][1] - state.pieces[0][0]
    time = np.arange(state.values.size) - float(first)
    when = np.concatenate([time[slice(*piece)] for piece in state.pieces])
    moment = when.size * np.var(when)
    # As far as the next place of the scan, and then as far as noise moves it.
    spread = _BETWEEN / span
    for _ in range(2):
        course = _course.polish(
            course,
            lambda frequency: _course.oscillation(frequency, time),
            course.shape["frequency"],
            spread,
            lambda tried: -with_course(state, tried).cost,
        )
        sized = with_course(state, course)
        variance = _course.ordinate_variance(state.spectrum, sized.model, sized.data)
        density = np.interp(course.shape["frequency"], state.spectrum.frequency, variance)
        amplitude = float(np.hypot(*sized.sizes[-2:]))
        spread = float(np.sqrt(density / (amplitude**2 * moment)) / (2 * np.pi))
    course.shape["deviation"] = spread
    return course


def at_its_edges(state: Investigation, course: Course) -> tuple[Course, Modulation]:
    """A shift that begins and ends where mean and strength say, and loud times that do so, then."""
    changing = state.modulation
    assert changing is not None
    if changing.strength is not None:
        return course, changing
    sized = with_course(state, course)
    variance = _course.ordinate_variance(state.spectrum, sized.model, sized.data)
    before, odds = state.flags(changing.loud), np.zeros(state.values.size)
    loud = before.copy()
    if changing.odds is not None:
        odds[state.looked_at] = changing.odds
    for piece in state.long_pieces:
        inside = slice(*piece)
        loud[inside] = sharpened(
            loud[inside],
            _WINDOWS * changing.window,
            state.values[inside],
            state.spectrum,
            variance,
            odds[inside],
        )
    moved = changing._replace(loud=loud[state.looked_at])
    shape = loudness(state, moved)
    better = course._replace(draw=lambda: shape)
    told = 2 * float(odds[loud].sum() - odds[before].sum())
    if evidence(state, better)[0] + told < evidence(state, course)[0]:
        return course, changing
    return better, moved


def together(state: Investigation) -> None:
    """Several warm-ups beside one another: each was found where it stood for those to come."""
    mine = [i for i, course in enumerate(state.courses) if course.name == "warm_up"]
    if len(mine) < 2:
        return
    before = np.log([state.courses[i].shape["time_constant"] for i in mine])

    def warm(logs: Float[np.ndarray, " constants"]) -> list[Course]:
        return [_course.warm_up(float(constant), state.values.size) for constant in np.exp(logs)]

    sums = summed(state).sums
    others = [moved for i, moved in enumerate(state.moved) if i not in mine]
    of_others = sums.of(others)

    def cost(logs: Float[np.ndarray, " constants"]) -> float:
        products = sums.beside(of_others, others, *(moved_by(state, each) for each in warm(logs)))
        return _course.size_up(products, sums, state.model, state.data).cost

    # What was found one by one may lie in a valley of its own.
    length = state.longest[1] - state.longest[0]
    grid = np.log(np.geomspace(length / _SHORTEST, length / 2, _CONSTANTS))
    start = min([before, *map(np.array, combinations(grid, len(mine)))], key=cost)
    simplex = np.vstack([start, start + _SIMPLEX * np.eye(len(mine))])
    options = {"initial_simplex": simplex, "maxfev": _TRIES, "xatol": 1e-3, "fatol": 1e-2}
    best = minimize(cost, start, method="Nelder-Mead", options=options).x
    for i, course in zip(mine, warm(best), strict=True):
        old = state.courses[i]
        state.courses[i] = course._replace(places=old.places, length=old.length).kept()
        state.moved[i] = moved_by(state, state.courses[i])
    resize(state)


def draw_courses(
    state: Investigation, rng: np.random.Generator, draws: int
) -> tuple[list[Float[np.ndarray, "draws columns"]], list[Float[np.ndarray, " draws"]]]:
    """Sizes of each course, and the logarithm of its constant less the best, as the noise allows.

    A warm-up's size and constant are known together only: to first order a constant moves the mean
    as its derivative does, which is one more column of the generalised least squares. And the noise
    that a course stands in is known from few ordinates only, which makes normal draws Student's.
    """
    assert state.sized is not None
    sizes, every = state.sized.sizes, list(state.moved)
    ends = np.cumsum([0, *(course.sizes for course in state.courses)])
    mine = [i for i, course in enumerate(state.courses) if course.name == "warm_up"]
    for i in mine:
        course = state.courses[i]
        late = np.arange(state.values.size)[:, None] / course.shape["time_constant"]
        slope = sizes[ends[i]] * late * course.draw()
        every.append(moved_by(state, course._replace(draw=lambda slope=slope: slope)))
    # With the noise in its bins as it was found in the end.
    products = Summing(state.spectrum, state.edges, state.variance).of(every)
    covariance = _course.covariance_of(products, state.model, state.data)
    apart = rng.multivariate_normal(np.zeros(len(covariance)), covariance, draws, method="svd")
    known = [
        _course.knowledge(products, slice(*between), state.model, state.data)
        for between in pairwise(ends)
    ]
    owner = [*np.repeat(np.arange(len(known)), np.diff(ends)), *mine]
    wider = [np.sqrt(each / rng.chisquare(each, draws)) for each in known]
    apart *= np.column_stack([wider[i] for i in owner])
    found, logs = sizes + apart[:, : sizes.size], apart[:, sizes.size :]
    of_course = [np.zeros(draws) for _ in state.courses]
    for i, log in zip(mine, logs.T, strict=True):
        of_course[i] = log
    return np.split(found, ends[1:-1], axis=1), of_course
