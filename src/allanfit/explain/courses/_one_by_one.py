"""Switches of a telegraph that are seen one by one, whatever walk they ride on.

Each is a step of its own, up and down in turn, and all are of one height. A matched filter shows
them where the noise is known, and the chain of steps in turn that stands out most is a course with
one size. So is the likeliest path between two levels, which needs a guess to begin with. Either has
to gain more than it costs to tell when each switch was.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.ndimage import uniform_filter1d

from .._refit import evidence
from .._state import Investigation
from ..spectrum._model import Model
from ..values._discrete import CROSSED
from ._course import Course, Edge, ordinate_variance
from ._decoded import decoded
from ._passing import passed, passing
from ._step_scores import StepScores, step_scores

# Samples over which levels are guessed, or within which a walk rises above white noise, and the
# logarithm of no power.
_MEMORIES, _NO_FLICKER = (30.0, 120.0, 480.0, 1920.0, 7680.0), -100.0
# Moments of a stretch, unless such a time has fewer.
_MOMENTS, _A_MEMORY = 2**14, 8
#: Standard deviations of a step that may be a switch.
LEAST = 4.0
#: Fewer steps in turn are steps.
FEWEST = 8
# In standard deviations: of lower switches too many are missed to tell how long levels last.
_CLEAR = 6.5
# A switch is about as likely in so many places, times the square of white noise over its height.
_PLACES = 2.2
# Their heights differ by less, as a part, with up to so many times what noise makes of them.
_ALIKE, _SCATTER = 0.1, 1.3


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
        """Whether nearly all switches were seen."""
        return self.course.shape["clear"] >= _CLEAR

    @property
    def alike(self) -> bool:
        """Whether all are of one height, as far as noise tells."""
        clear, spread = self.course.shape["clear"], self.course.shape["spread"]
        return spread < float(np.hypot(_ALIKE, _SCATTER / clear))

    def worth(self, state: Investigation) -> float:
        """By how much the record is likelier with the course than as the model has it [nats]."""
        return evidence(state, self.course)[0] / 2 - self.cost


def seen_one_by_one(state: Investigation) -> Seen | None:
    """The switches of a telegraph in what the model leaves, if there are steps in turn.

    In a model without them slow noise stands for them, beside which they are hard to see. So they
    are sought as the likeliest path between two levels too, or, behind a filter, beside other
    walks. How they were found does not matter to what they are worth.
    """
    longest = max(stop - start for start, stop in state.long_pieces)
    memories = [each for each in _MEMORIES if each < longest / FEWEST]
    found, models = [], [state.model]
    if passing(state) is None:
        found = _decoded(state, memories)
    else:
        models += [_walking(state.model, each) for each in memories]
    for model in models:
        pieces = _scores(state, model)
        seen = seen_as(state, [_in_turn(piece, piece.scores) for piece in pieces])
        if seen is not None:
            found.append(seen)
    return max(found, key=lambda seen: seen.worth(state), default=None)


def seen_along(
    state: Investigation,
    values: Float[np.ndarray, " samples"],
    level: Float[np.ndarray, " samples"],
) -> Seen | None:
    """The switches of a path of zeros and ones, of `values` that are calm but for them."""
    white = float(np.exp(state.model.theta[1]))
    stretches = [slice(*piece) for piece in state.long_pieces]
    return seen_as(state, [_between(values[at], level[at], at.start, white) for at in stretches])


def _decoded(state: Investigation, memories: list[float]) -> list[Seen]:
    """Likeliest paths between two levels, from what a mean over so many samples says."""
    white, calm = float(np.exp(state.model.theta[1])), state.calm
    found = []
    for memory in memories:
        level = np.zeros(calm.size)
        for start, stop in state.long_pieces:
            values = calm[start:stop]
            # Moments enough for dwells of that length; where each ends is found later.
            size = min(max(values.size // _MOMENTS, 1), int(memory / _A_MEMORY))
            moments = values[: values.size // size * size].reshape(-1, size).mean(axis=1)
            mean = uniform_filter1d(moments, max(round(memory / size), 1))
            path = decoded(moments, (mean > np.median(mean)).astype(float), white / size)
            level[start:stop] = np.pad(np.repeat(path, size), (0, values.size % size), mode="edge")
        seen = seen_along(state, calm, level)
        if seen is not None and seen.alike:
            found.append(seen)
    return found


def _between(
    values: Float[np.ndarray, " samples"],
    level: Float[np.ndarray, " samples"],
    start: int,
    white: float,
) -> Edges:
    """The switches of a path, as tall as means before and after each say."""
    at = np.flatnonzero(np.diff(level)) + 1
    turns = np.sign(level[at] - level[at - 1])
    counts = np.diff(np.concatenate([[0], at, [values.size]]))
    means = np.add.reduceat(values, np.concatenate([[0], at])) / counts
    heights = turns * np.diff(means)
    known = 1 / np.sqrt(white * (1 / counts[1:] + 1 / counts[:-1]))
    return Edges(start, start + values.size, at + start, turns, heights * known, heights)


def likely_one_by_one(state: Investigation) -> Seen | None:
    """The same, if they are likelier than what the model has in their place."""
    seen = seen_one_by_one(state)
    return seen if seen is not None and seen.worth(state) >= -np.log(state.alarm) else None


def seen_again(state: Investigation, seen: Seen) -> list[Seen]:
    """As `seen` beside all others, whose course came last: in the noise that they leave.

    By steps in turn, and by the likeliest path beside a baseline that is smooth.
    """
    assert state.sized is not None
    height, edges = float(state.sized.sizes[-1]), []
    for piece, before in zip(_scores(state, state.model), seen.edges, strict=True):
        scores, places = piece.scores.copy(), np.searchsorted(piece.at, before.at)
        places = np.minimum(places, scores.size - 1)
        scores[places] += before.turns * height * piece.known[places]
        edges.append(_in_turn(piece, scores))
    found = [seen_as(state, edges)]
    if passing(state) is None:
        white, edges = float(np.exp(state.model.theta[1])), []
        # Stretches as steps have them may end some samples early.
        for before in seen.edges:
            values = state.calm[before.start : before.stop] + height * before.level
            level = decoded(values, before.level, white)
            edges.append(_between(values, level, before.start, white))
        found.append(seen_as(state, edges))
    return [each for each in found if each is not None]


def _walking(model: Model, memory: float) -> Model:
    """White noise and a walk that is as strong within so many samples, in place of all else."""
    kinds, theta = model.kinds._replace(added=()), model.theta[: model.kinds.first_slot].copy()
    theta[2], theta[3] = _NO_FLICKER, theta[1] - 2 * np.log(memory)
    return model._replace(kinds=kinds, theta=theta)


def _scores(state: Investigation, model: Model) -> list[StepScores]:
    """How steps stand out of the noise of a model."""
    variance = ordinate_variance(state.spectrum, model, state.data)
    return step_scores(state.calm, state.long_pieces, state.left, variance, passing(state))


def _in_turn(piece: StepScores, scores: Float[np.ndarray, " places"]) -> Edges:
    """Steps up and down in turn that stand out most together, of which each stands out."""
    inner = np.abs(scores[1:-1])
    highest = (inner >= np.abs(scores[:-2])) & (inner > np.abs(scores[2:])) & (inner > LEAST)
    # The best chain that ends with a step down, and with one up: what it gains, and its last link.
    best: dict[bool, tuple[float, Any]] = {False: (0.0, None), True: (0.0, None)}
    for place in np.flatnonzero(highest) + 1:
        up = bool(scores[place] > 0)
        before, chain = best[not up]
        gain = before + float(scores[place]) ** 2 - LEAST**2
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


def seen_as(
    state: Investigation, edges: list[Edges], edge: Edge | None = None, late: float = 0.0
) -> Seen | None:
    """The course of such switches, if they are enough.

    Behind a filter each with that `edge`, so many samples `late`, or with one of no phase.
    """
    tall = np.concatenate([each.tall for each in edges])
    if tall.size < FEWEST:
        return None
    heights = np.concatenate([each.height for each in edges])
    middle = np.median(heights)
    if not state.format.normal and middle < CROSSED * state.format.width:
        # What is rounded dwells on a code, and on the next one.
        return None
    path, through = np.zeros(state.values.size), passing(state)
    if edge is None and through is not None:
        edge = through.none
    for each in edges:
        path[each.start : each.stop] = (
            each.level if edge is None else passed(each.level, edge, late)
        )
    told = [each for each in edges if each.at.size]
    samples = sum(each.stop - each.start for each in told)
    clear = float(np.median(tall))
    shape = {
        "switches": float(tall.size),
        "samples": float(samples),
        "upper": sum(float(each.level.sum()) for each in told) / samples,
        "clear": clear,
        "spread": float(1.4826 * np.median(np.abs(heights - middle)) / middle),
    }
    course = Course("random_telegraph", lambda: path[:, None], 1, shape)
    apart = np.log(samples / tall.size)
    alike = 0.0
    if through is None:
        alike = np.log1p(_PLACES * np.exp(state.model.theta[1]) / middle**2)
    cost = tall.size * (1 + apart - min(alike, apart)) + np.log(samples) / 2
    return Seen(course, edges, float(cost))
