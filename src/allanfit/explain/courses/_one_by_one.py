"""Switches of a telegraph that are seen one by one, whatever walk they ride on.

Each is a step of its own, up and down in turn, and all are of one height. A matched filter shows
them where the noise is known, and the chain of steps in turn that stands out most is a course with
one size. It has to gain more than it costs to tell when each switch was.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.fft import irfft
from scipy.optimize import brentq

from .._refit import evidence
from .._state import Investigation
from ..spectrum._whiten import KERNEL, kernel_density, level, precision, shaped
from ._course import Course
from ._scan import StepScores, step_scores

# Standard deviations of a step that may be a switch.
_LEAST = 4.0
# Fewer steps in turn are steps.
_FEWEST = 5
# In standard deviations: of lower switches too many are missed to tell how long levels last.
_CLEAR = 6.5
# Their heights differ by less, as a part, with up to so many times what noise makes of them.
_ALIKE, _SCATTER = 0.1, 1.3
# Samples that a switch is moved by at once, and how often.
_REACH, _MOVES = 16, 3
# Samples of the longest dwell that is looked for as such.
_BRIEF = 64
# Levels are held for different times if their shares differ by so many standard deviations.
_UNEVEN = 3.0
# How far off the shortest dwell that is seen may be, as a standard deviation of its logarithm.
_ROUGH = 0.3
# And the longest that is believed, as a part of how long the briefer level seems to last.
_HIDDEN = 0.15
_ITERATIONS = 40


class Edges(NamedTuple):
    """The switches of one stretch, in turn."""

    start: int
    stop: int
    #: The first sample on the other level, whether that is 1 up or -1 down, and how tall it stands
    #: in standard deviations and by itself [u].
    at: Int[np.ndarray, " switches"]
    turns: Float[np.ndarray, " switches"]
    tall: Float[np.ndarray, " switches"]
    height: Float[np.ndarray, " switches"]

    @property
    def level(self) -> Float[np.ndarray, " samples"]:
        """0 on the lower level and 1 on the upper."""
        if self.at.size == 0:
            return np.zeros(self.stop - self.start)
        past = np.searchsorted(self.at, np.arange(self.start, self.stop), side="right")
        return (past + (self.turns[0] < 0)) % 2.0


class Seen(NamedTuple):
    """Switches that were seen, as a course of one size."""

    course: Course
    edges: list[Edges]
    #: What telling when a Poisson process had its events costs, and how high they are [nats].
    cost: float

    @property
    def count(self) -> float:
        """How many there are."""
        return self.course.shape["switches"]

    @property
    def clear(self) -> bool:
        """Whether nearly all switches were seen, all of one height as far as noise tells."""
        clear, spread = self.course.shape["clear"], self.course.shape["spread"]
        return clear >= _CLEAR and spread < float(np.hypot(_ALIKE, _SCATTER / clear))

    def worth(self, state: Investigation) -> float:
        """By how much the record is likelier with the course than as the model has it [nats]."""
        return evidence(state, self.course)[0] / 2 - self.cost


def seen_one_by_one(state: Investigation) -> Seen | None:
    """The switches of a telegraph in what the model leaves, if there are steps in turn."""
    pieces = step_scores(state.calm, state.long_pieces, state.left, state.variance)
    return _seen(state, [_in_turn(piece, piece.scores) for piece in pieces])


def seen_again(state: Investigation, seen: Seen) -> Seen | None:
    """As `seen` beside all others, whose course came last: in the noise that they leave."""
    assert state.sized is not None
    height, edges = float(state.sized.sizes[-1]), []
    pieces = step_scores(state.calm, state.long_pieces, state.left, state.variance)
    for piece, before in zip(pieces, seen.edges, strict=True):
        scores, places = piece.scores.copy(), np.searchsorted(piece.at, before.at)
        scores[places] += before.turns * height * piece.known[places]
        edges.append(_in_turn(piece, scores))
    return _seen(state, edges)


def placed(state: Investigation, seen: Seen) -> Seen:
    """The switches of the course that came last, each at its likeliest sample, and brief dwells."""
    assert state.sized is not None
    height, edges = float(state.sized.sizes[-1]), seen.edges
    expected = level(state.left, state.variance)
    response = np.asarray(irfft(1 / kernel_density(state.left, expected), KERNEL))
    # Of pulses of so many samples and of one unit, by the inverse covariance.
    pulses = np.array(
        [n * response[0] + 2 * np.arange(n - 1, 0, -1) @ response[1:n] for n in range(1, _BRIEF)]
    )
    calm = state.calm + height * seen.course.draw()[:, 0]

    def told(each: Edges) -> Float[np.ndarray, " ends"]:
        """Sums of what is left of a stretch, by the inverse covariance."""
        rest = calm[each.start : each.stop] - height * each.level
        weights = precision(rest.size, state.left, expected)
        return np.concatenate([[0.0], np.cumsum(shaped(rest, weights))])

    for _ in range(_MOVES):
        edges = [_moved(each, told(each), height, pulses[:_REACH]) for each in edges]
    # As much as telling of two more switches costs.
    least = 2 * (1 + np.log(seen.course.shape["samples"] / seen.course.shape["switches"]))
    edges = [_with_brief(each, told(each), height, pulses, least) for each in edges]
    found = _seen(state, edges) or seen
    shown = np.flatnonzero(height**2 / 2 * pulses > least)
    if shown.size:
        unseen = min(found.course.shape["unseen"], float(shown[0]) + 0.5)
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
    for n, energy in enumerate(pulses, start=1):
        first, stop = 1, samples - n
        along = other[first:stop] * (told[first + n : stop + n] - told[first:stop])
        gain = height * along - height**2 / 2 * energy
        # Between two switches, and apart from both; what stands out more is no dwell but a spike.
        better = (gain > best[first:stop]) & (past[: stop - 1] == past[first + n :])
        better &= along < height * energy + _LEAST * np.sqrt(energy)
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


def _in_turn(piece: StepScores, scores: Float[np.ndarray, " places"]) -> Edges:
    """Steps up and down in turn that stand out most together, of which each stands out."""
    inner = np.abs(scores[1:-1])
    highest = (inner >= np.abs(scores[:-2])) & (inner > np.abs(scores[2:])) & (inner > _LEAST)
    # The best chain that ends with a step down, and with one up: what it gains, and its last link.
    best: dict[bool, tuple[float, Any]] = {False: (0.0, None), True: (0.0, None)}
    for place in np.flatnonzero(highest) + 1:
        up = bool(scores[place] > 0)
        before, chain = best[not up]
        gain = before + float(scores[place]) ** 2 - _LEAST**2
        if gain > best[up][0]:
            best[up] = gain, (place, chain)
    link, places = max(best.values(), key=lambda chain: chain[0])[1], []
    while link is not None:
        place, link = link
        places.append(place)
    found = np.array(places[::-1], int)
    at = np.round(piece.at[found]).astype(int)
    tall = np.abs(scores[found])
    turns = np.sign(scores[found])
    return Edges(piece.start, piece.stop, at, turns, tall, tall / piece.known[found])


def _seen(state: Investigation, edges: list[Edges]) -> Seen | None:
    tall = np.concatenate([each.tall for each in edges])
    if tall.size < _FEWEST:
        return None
    path = np.zeros(state.values.size)
    for each in edges:
        path[each.start : each.stop] = each.level
    told = [each for each in edges if each.at.size]
    samples = sum(each.stop - each.start for each in told)
    clear = float(np.median(tall))
    heights = np.concatenate([each.height for each in edges])
    middle = np.median(heights)
    shape = {
        "switches": float(tall.size),
        "samples": float(samples),
        "upper": sum(float(each.level.sum()) for each in told) / samples,
        "clear": clear,
        "spread": float(1.4826 * np.median(np.abs(heights - middle)) / middle),
        "unseen": _shortest_seen(state, clear),
    }
    course = Course("random_telegraph", lambda: path[:, None], 1, shape)
    cost = tall.size * (1 + np.log(samples / tall.size)) + np.log(samples) / 2
    return Seen(course, edges, float(cost))


def _shortest_seen(state: Investigation, clear: float) -> float:
    """Samples between two switches that are both seen: nearer ones cancel in the filter."""
    frequency = state.left.frequency
    energy = 1 / (np.sin(np.pi * frequency) ** 2 * state.variance)
    energy /= energy.sum()

    def alike(samples: float) -> float:
        return float(energy @ np.cos(2 * np.pi * frequency * samples)) - (1 - _LEAST / clear)

    longest = 1.0
    while alike(longest) > 0 and longest < state.left.longest:
        longest *= 2
    return float(np.asarray(brentq(alike, 0.0, longest))) if alike(longest) < 0 else longest


def dwells(
    course: Course, rng: np.random.Generator, draws: int
) -> tuple[Float[np.ndarray, " draws"], Float[np.ndarray, " draws"], bool]:
    """Draws of the mean dwell [samples] and of the upper level's share, and whether that is uneven.

    Dwells too short to be seen join their neighbours: a level that is left at the rate a, and the
    other at b, seems to last for (exp(b d) - 1)/b + exp(b d)/a, if none shorter than d is seen
    (Colquhoun and Sigworth 1983, in Single-Channel Recording, for two states).
    """
    shape = course.shape
    upper, samples, switches = shape["upper"], shape["samples"], shape["switches"]
    seems = samples / rng.gamma(switches, 1.0, draws)
    # Of the time on one level, by turns of exponential length.
    deviation = 2 * upper * (1 - upper) / np.sqrt(switches)
    share = np.clip(upper + deviation * rng.normal(size=draws), 0.01, 0.99)
    uneven = bool(abs(upper - 0.5) > _UNEVEN * deviation)
    part = share if uneven else np.full(draws, 0.5)
    unseen = shape["unseen"] * np.exp(_ROUGH * rng.normal(size=draws))
    # Beyond, what seems to last tells nothing any more of what does.
    unseen = np.minimum(unseen, _HIDDEN * seems * 2 * np.minimum(part, 1 - part))
    dwell = seems.copy()
    for _ in range(_ITERATIONS):
        high, low = 2 * part * dwell, 2 * (1 - part) * dwell
        past_high, past_low = np.exp(unseen / high), np.exp(unseen / low)
        both = (past_low - 1) * low + past_low * high
        both += (past_high - 1) * high + past_high * low
        dwell *= 2 * seems / both
    return dwell, share, uneven
