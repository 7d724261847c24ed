"""How a step reaches the samples: at once, or through the filter that the noise passes.

A filter makes noise weak at high frequency, and there a step drawn too steep, or a sample too
early, stands out of the whitened record by more than itself. What the filter makes of a step
follows from |H|^2, which the noise tells, and from a phase, which it does not: the least that
such a filter can have, as those of feedback have, or none but a delay, as symmetric ones have.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.fft import irfft, rfft

from .._refit import moved_by, resize
from .._state import Investigation
from ..spectrum._structure import EACH, TERMS, sieve
from ..spectrum._whiten import (
    KERNEL,
    level,
    mode_frequency,
    precision,
    shaped,
)
from ._course import Course, Edge, risen, step

# Points a sample of the response of a filter in front of the converter; those of one response.
_FINE, _LENGTH = 8, 2**14
# Below such a part of the power there is nothing to tell a response by.
_STOPPED = 1e-12
# A step is moved by so many samples, and by twice as many as it takes to be as near to its end.
_REACH, _NEAR = 8, 0.02
# Above such a part of the modes, where a filter may leave nothing, they weigh no more than there.
_HEARD = 0.9
# What another place or edge has to gain, in twice the log-likelihood.
_BETTER, _ALIKE = 6.0, 2.0


class _Place(NamedTuple):
    """Where a step is, by which edge, and what it gains there, in twice the log-likelihood."""

    gain: float
    time: float
    edge: Edge | None


def settle(state: Investigation) -> None:
    """Each step with the edge and at the moment that the samples about it show."""
    edges = _edges(state)
    for i, course in enumerate(state.courses):
        found = _likeliest(state, i, edges) if course.name == "step" else None
        if found is not None:
            better = step(found.time, state.values.size, found.edge)
            state.courses[i] = better._replace(places=course.places, length=course.length).kept()
            state.moved[i] = moved_by(state, state.courses[i])
            resize(state)


def _likeliest(state: Investigation, which: int, edges: list[Edge | None]) -> _Place | None:
    """The edge and the moment of a step, if they are better than those that it has."""
    assert state.sized is not None
    course, time = state.courses[which], state.courses[which].shape["time"]
    height = state.sized.sizes[sum(each.sizes for each in state.courses[:which])]
    piece = next((each for each in state.pieces if each[0] < time < each[1]), None)
    if piece is None:
        return None
    start, stop = piece
    drawn, expected = course.draw()[:, 0], level(state.left, state.variance)
    bare = (state.calm + height * drawn)[start:stop]
    weights = precision(bare.size, state.left, expected)
    weights = np.minimum(weights, np.quantile(weights, _HEARD))
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
        half, rise = (0, 0) if edge is None else _half_and_rise(edge)
        reach = _REACH + 2 * rise
        moments = np.arange(shown - half - reach, shown - half + reach + 1)
        found = max((at_moment(float(at), edge) for at in moments), key=lambda one: one.gain)
        if edge is None:
            return found
        parts = np.arange(1 - _FINE, _FINE) / _FINE
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


def _half_and_rise(edge: Edge) -> tuple[int, int]:
    """Samples until half of the height is there, and from nearly none of it to nearly all."""
    begun = np.flatnonzero(np.abs(edge.height) > _NEAR)[0]
    done = np.flatnonzero(np.abs(edge.height - 1) > _NEAR)[-1]
    half = np.argmax(edge.height >= 0.5)
    return round(float(edge.lag[half])), round(float(edge.lag[done] - edge.lag[begun]))


def _edges(state: Investigation) -> list[Edge | None]:
    """At once, and what the model's filter makes of a step, if it has one."""
    kinds = state.model.kinds
    if not kinds.filtering:
        return [None]
    three = jnp.asarray(state.model.theta[TERMS : TERMS + EACH])
    found = sieve(kinds.shaping or "", three, state.data.samples)
    fine = 1 if found.after_converter else _FINE
    frequency = jnp.arange(_LENGTH // 2 + 1) * (fine / _LENGTH)
    gain = np.sqrt(np.maximum(np.asarray(found.passed(frequency, 1.0)), _STOPPED))
    # Samples that are averages are those of what passes the filter.
    averaged = (state.data.averaging or found.averaged) and not found.after_converter
    over = fine if averaged else 1
    least, none = _least_phase(gain), np.roll(np.asarray(irfft(gain)), _LENGTH // 2)
    return [_response(least, 0, fine, over), _response(none, _LENGTH // 2, fine, over), None]


def _least_phase(gain: Float[np.ndarray, " frequencies"]) -> Float[np.ndarray, " points"]:
    """The impulse response with such a gain that is soonest over.

    Its cepstrum is zero before time zero: Oppenheim and Schafer, Discrete-Time Signal Processing.
    """
    cepstrum = np.asarray(irfft(np.log(gain)))
    cepstrum[1 : _LENGTH // 2] *= 2
    cepstrum[_LENGTH // 2 + 1 :] = 0.0
    return np.asarray(irfft(np.exp(np.asarray(rfft(cepstrum)))))


def _response(impulse: Float[np.ndarray, " points"], zero: int, fine: int, over: int) -> Edge:
    """The step response, from an impulse response with time zero at a point, `fine` a sample.

    Each value is the mean of the last `over` points.
    """
    impulse = np.convolve(impulse, np.full(over, 1 / over))[:_LENGTH] / impulse.sum()
    lag = (np.arange(-1, _LENGTH) - zero) / fine
    return Edge(lag, np.concatenate([[0.0], np.cumsum(impulse)]))
