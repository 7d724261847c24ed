"""The switches of a telegraph with the phase that the sensor's filter gives them.

They are found with none but a delay. What the filter's own phase makes of each is local, and is
compared by the inverse covariance of the noise that is left.
"""

import numpy as np
from jaxtyping import Float
from scipy.fft import rfft

from .._state import Investigation
from ..spectrum._whiten import HEARD, KERNEL, kernel_density, level, precision, shaped
from ._course import risen
from ._one_by_one import Edges, Seen, seen_as
from ._passing import half_and_rise, passed, passing

# Delays beside that to half of a step [samples].
_DELAYS = (-1.0, -0.5, 0.0, 0.5, 1.0)
# Samples that a switch is moved by, how often, and those about it that differ.
_NEARBY, _ROUNDS, _AROUND = 3, 3, 512


def with_phase(state: Investigation, seen: Seen) -> Seen:
    """The course that came last with the phase of the model's filter, if it has one.

    None, or the least that it can have, at some delay; and each switch at the sample at which it is
    likeliest then.
    """
    through = passing(state)
    if through is None:
        return seen
    assert state.sized is not None
    height, path = float(state.sized.sizes[-1]), seen.course.draw()[:, 0]
    expected = level(state.left, state.variance)
    weights = [
        precision(each.stop - each.start, state.left, expected, HEARD) for each in seen.edges
    ]
    half, _ = half_and_rise(through.least)
    ways = [(through.none, 0.0), *((through.least, each - half) for each in _DELAYS)]
    gains = np.zeros(len(ways))
    for each, own in zip(seen.edges, weights, strict=True):
        inside = slice(each.start, each.stop)
        told = shaped(state.calm[inside], own)
        for i, way in enumerate(ways):
            other = height * (passed(each.level, *way) - path[inside])
            gains[i] += other @ told - other @ shaped(other, own) / 2
    edge, late = ways[int(np.argmax(gains))]

    near, moves = np.arange(-_AROUND, _AROUND + 1), np.arange(-_NEARBY, _NEARBY + 1)
    moved = np.array([risen(near - move - late, edge) - risen(near - late, edge) for move in moves])
    density = kernel_density(state.left, expected)
    power = np.abs(np.asarray(rfft(moved, KERNEL))) ** 2
    power /= np.maximum(density, np.quantile(density, 1 - HEARD))
    # Of a real kernel, all but the first and the last stand for two frequencies.
    energy = (2 * power.sum(axis=1) - power[:, 0] - power[:, -1]) / KERNEL

    edges = []
    for each, own in zip(seen.edges, weights, strict=True):
        inside = slice(each.start, each.stop)
        whole = state.calm[inside] + height * path[inside]
        for _ in range(_ROUNDS):
            told = shaped(whole - height * passed(each.level, edge, late), own)
            each = _at_best(each, told, height * moved, height**2 * energy, moves)
        edges.append(each)
    found = seen_as(state, edges, edge, late) or seen
    found.course.shape["unseen"] = seen.course.shape["unseen"]
    return found


def _at_best(
    edges: Edges,
    told: Float[np.ndarray, " samples"],
    moved: Float[np.ndarray, "moves near"],
    energy: Float[np.ndarray, " moves"],
    moves: np.ndarray,
) -> Edges:
    """Each switch at the likeliest of a few samples about it, the others as they are.

    `told` is what is left, by the inverse covariance, and `moved` what each move changes about an
    upward switch, with its `energy` by the same.
    """
    around, at = np.pad(told, _AROUND), edges.at - edges.start
    # Also of a stretch without any.
    near = around[at[:, None] + np.arange(moved.shape[1])]
    gain = near @ moved.T * edges.turns[:, None] - energy / 2
    best = at + moves[np.argmax(gain, axis=1)]
    # What would change places stays.
    stays = np.diff(best, prepend=0, append=told.size) <= 0
    best = np.where(stays[1:] | stays[:-1], at, best)
    return edges._replace(at=best + edges.start)
