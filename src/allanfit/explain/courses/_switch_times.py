"""When a telegraph switched, to the sample, and its dwells too brief for two steps to show.

Levels are compared by the inverse covariance of the noise that is left: a switch is moved by what
the samples that it passes say, and a brief dwell is a pulse of the height that is known.
"""

import numpy as np
from jaxtyping import Float, Int
from scipy.fft import irfft
from scipy.optimize import brentq

from .._state import Investigation
from ..spectrum._whiten import KERNEL, kernel_density, level, mode_frequency, precision, shaped
from ._decoded import shortest
from ._one_by_one import LEAST, Edges, Seen, seen_as
from ._passing import passed, passing

# Samples that a switch is moved by at once, and how often.
_REACH, _MOVES = 16, 3
# Dwells that are looked for as such have up to so many samples, beyond the first ones by steps of
# a tenth.
_EACH, _BRIEF, _LONGER = 64, KERNEL // 2, 1.1


def placed(state: Investigation, seen: Seen) -> Seen:
    """The switches of the course that came last, each at its likeliest sample, and brief dwells."""
    assert state.sized is not None
    height, edges = float(state.sized.sizes[-1]), seen.edges
    expected, through = level(state.left, state.variance), passing(state)
    density = kernel_density(state.left, expected)
    if through is not None:
        # As if noise and switches were in front of it.
        density = density / through.gain_at(np.arange(KERNEL // 2 + 1) / KERNEL) ** 2
    response = np.asarray(irfft(1 / density, KERNEL))
    # Of pulses of so many samples and of one unit, by the inverse covariance.
    longer = _EACH * _LONGER ** np.arange(np.log(_BRIEF / _EACH) / np.log(_LONGER))
    lengths = np.append(np.arange(1, _EACH), longer.astype(int))
    pulses = np.array(
        [n * response[0] + 2 * np.arange(n - 1, 0, -1) @ response[1:n] for n in lengths]
    )
    calm = state.calm + height * seen.course.draw()[:, 0]

    def told(each: Edges) -> Float[np.ndarray, " ends"]:
        """Sums of what is left of a stretch, by the inverse covariance."""
        level_there = each.level if through is None else passed(each.level, through.none)
        rest = calm[each.start : each.stop] - height * level_there
        weights = precision(rest.size, state.left, expected)
        if through is not None:
            weights *= through.gain_at(mode_frequency(rest.size))
        return np.concatenate([[0.0], np.cumsum(shaped(rest, weights))])

    for _ in range(_MOVES):
        edges = [_moved(each, told(each), height, pulses[:_REACH]) for each in edges]
    # As much as telling of two more switches costs.
    least = 2 * (1 + np.log(seen.course.shape["samples"] / seen.course.shape["switches"]))
    unseen = _shortest_seen(state, seen.course.shape["clear"])
    brief = lengths <= 2 * unseen + 1
    edges = [
        _with_brief(each, told(each), height, lengths[brief], pulses[brief], least)
        for each in edges
    ]
    found = seen_as(state, edges) or seen
    shown = lengths[height**2 / 2 * pulses > least]
    # Needed of the last course alone: how long levels last depends on it.
    unseen = min([unseen, *(shown[:1] - 0.5)])
    if through is None:
        dwell = seen.course.shape["samples"] / seen.course.shape["switches"]
        unseen = min(unseen, shortest(dwell, np.exp(state.model.theta[1]) / height**2))
    found.course.shape["unseen"] = unseen
    return found


def _moved(
    edges: Edges,
    told: Float[np.ndarray, " ends"],
    height: float,
    pulses: Float[np.ndarray, " lengths"],
) -> Edges:
    """Each switch where the record is likeliest, within reach and beside the others."""
    moves, at = np.arange(-pulses.size, pulses.size + 1), edges.at - edges.start
    ends = np.clip(at[:, None] + moves, 1, told.size - 2)
    # Samples that are passed are on the other level: for an upward switch later, on the lower.
    passed = (told[ends] - told[at][:, None]) * edges.turns[:, None]
    gain = -height * passed - height**2 / 2 * np.concatenate([pulses[::-1], [0.0], pulses])
    best = np.take_along_axis(ends, np.argmax(gain, axis=1)[:, None], axis=1)[:, 0]
    # What would change places stays.
    stays = np.diff(best, prepend=-1, append=told.size) <= 0
    best = np.where(stays[1:] | stays[:-1], at, best)
    return edges._replace(at=np.maximum.accumulate(best) + edges.start)


def _with_brief(
    edges: Edges,
    told: Float[np.ndarray, " ends"],
    height: float,
    lengths: Int[np.ndarray, " lengths"],
    pulses: Float[np.ndarray, " lengths"],
    least: float,
) -> Edges:
    """With dwells that are too brief for two steps to show, where these gain more than `least`."""
    if edges.at.size == 0:
        return edges
    samples = told.size - 1
    past = np.searchsorted(edges.at - edges.start, np.arange(samples), side="right")
    other = 1 - 2 * edges.level
    best, length = np.full(samples, least), np.zeros(samples, int)
    for n, energy in zip(lengths.tolist(), pulses, strict=True):
        first, stop = 1, samples - n
        along = other[first:stop] * (told[first + n : stop + n] - told[first:stop])
        gain = height * along - height**2 / 2 * energy
        # Between two switches, and apart from both; what stands out more is no dwell but a spike.
        better = (gain > best[first:stop]) & (past[: stop - 1] == past[first + n :])
        better &= along < height * energy + LEAST * np.sqrt(energy)
        best[first:stop][better] = gain[better]
        length[first:stop][better] = n
    at, turns, tall, heights = map(list, edges[2:])
    taken = np.zeros(samples, bool)
    found = np.flatnonzero(length)
    for place in found[np.argsort(-best[found])]:
        near = slice(place - 1, place + length[place] + 1)
        if not taken[near].any():
            taken[near] = True
            at += [edges.start + place, edges.start + place + length[place]]
            turns += [other[place], -other[place]]
            tall += [float(np.sqrt(2 * best[place]))] * 2
            heights += [height] * 2
    order = np.argsort(at)
    sorted_ones = (np.array(each)[order] for each in (at, turns, tall, heights))
    return Edges(edges.start, edges.stop, *sorted_ones)


def _shortest_seen(state: Investigation, clear: float) -> float:
    """Samples between two switches that are both seen: nearer ones cancel in the filter."""
    frequency = state.left.frequency
    energy, through = 1 / (np.sin(np.pi * frequency) ** 2 * state.variance), passing(state)
    if through is not None:
        energy *= through.gain_at(frequency) ** 2
    energy /= energy.sum()

    def alike(samples: float) -> float:
        return float(energy @ np.cos(2 * np.pi * frequency * samples)) - (1 - LEAST / clear)

    longest = 1.0
    while alike(longest) > 0 and longest < state.left.longest:
        longest *= 2
    return float(np.asarray(brentq(alike, 0.0, longest))) if alike(longest) < 0 else longest
