"""Whether a wandering bias dwells at two levels: its switches pass for steps, knocks and spikes."""

import numpy as np
from jaxtyping import Bool, Float

from .._state import Investigation
from ..spectrum import _model
from ..spectrum._density import gain_at, noise_at
from ..spectrum._structure import EACH, shape_of
from ..spectrum._whiten import level, whitened
from ..values._clipped import rails
from ..values._contamination import Contamination, contamination
from . import _course
from ._one_by_one import FEWEST, seen_one_by_one
from ._passing import half_and_rise, passing
from ._shapes import draw_courses
from ._telegraph import SURE, Levels, one_way, two_levels
from ._visits import Visits, visits

# A step is a switch if its height is that between the levels, within so much of it and so many of
# its standard deviations, which so many draws give.
_ALIKE, _DEVIATIONS, _DRAWS = 0.35, 2.0, 400
# Without its switches a time is as quiet as others if it is no louder, in power, by this.
_LOUD = 1.5
# Spikes and steps are of switches if without these no more of their variance is left.
_LEFT = 0.2


def levels_of(state: Investigation, begin: int, constant: float, seed: int) -> Levels:
    """Two levels in the Gauss-Markov process whose parameters begin at `begin`.

    `constant` is its time constant in samples.
    """
    start, stop = state.longest
    if rails(state) is not None:
        # What stands at a rail dwells there, whatever it is.
        return Levels(0.0, 1.0, 0.5, np.zeros(stop - start, bool))
    levels = two_levels(*_process(state, begin, constant), seed)
    if levels.chance < state.alarm or len(state.pieces) > 1:
        return levels
    # Beside a strong walk switches are seen one by one alone.
    seen = seen_one_by_one(state)
    worth = -np.inf if seen is None else seen.worth(state)
    if seen is None or not seen.alike or worth < -np.log(levels.chance):
        return levels
    shape, high = seen.course.shape, seen.course.draw()[start:stop, 0] > 0
    chance = float(np.exp(-min(worth, SURE)))
    return Levels(2 * worth / high.size, chance, shape["upper"], high)


def jumps_one_way(state: Investigation, begin: int, constant: float) -> float:
    """Log of the chance that a process jumps one way, and comes back, as much.

    Arguments as of `levels_of`.
    """
    if rails(state) is not None:
        return 0.0
    return one_way(*_process(state, begin, constant))


def visits_of(
    state: Investigation, place: int, constant: float, seed: int
) -> tuple[bool, Visits | None]:
    """Whether a process seems to have two levels, and its visits to the rarer one, if enough.

    `place` is that of the process among what the model adds; other arguments as of `levels_of`.
    """
    kinds = state.model.kinds
    levels = levels_of(state, kinds.first_slot + EACH * place, constant, seed)
    if levels.chance > state.alarm:
        return False, None
    values = state.calm[slice(*state.longest)]
    path = _levels_in_time(values, levels.high, max(round(constant), 1))
    bare = _model.without(state.model, place + (kinds.shaping is not None))
    expected = _course.ordinate_variance(state.left, bare, state.data)
    modes = np.linspace(0.0, 0.5, values.size)
    # An ordinate is 2 c^2.
    density = np.interp(modes, state.left.frequency, expected / 2)
    through = passing(state)
    settles = 0 if through is None else half_and_rise(through.least)[1]
    return True, visits(values, path, density, settles)


def _process(
    state: Investigation, begin: int, constant: float
) -> tuple[
    Float[np.ndarray, " modes"], Float[np.ndarray, " modes"], Float[np.ndarray, " modes"], int
]:
    """The amplitudes, what is expected of the process and of all, and the mode at its corner."""
    three, (start, stop) = state.model.theta[begin : begin + EACH], state.longest
    # Of one stretch: the ordinates of several are no series.
    spectrum = state.ordinates_of(state.calm[start:stop])
    total = _course.ordinate_variance(spectrum, state.model, state.data)
    frequency = np.clip(spectrum.frequency, 1e-12, 0.5)
    thinned = np.geomspace(frequency[0], frequency[-1], 600)
    found = noise_at("gauss_markov", three, thinned, state.data)
    found = found * gain_at(
        state.model.theta, "gauss_markov", state.model.kinds, thinned, state.data
    )
    signal = np.minimum(np.interp(frequency, thinned, found), total)
    corner = int(np.searchsorted(frequency, 1 / (2 * np.pi * constant)))
    return spectrum.amplitude, signal, total, max(corner, 1)


def without_switches(
    state: Investigation, whole: Investigation, seed: int
) -> Float[np.ndarray, " samples"] | None:
    """The longest stretch of the `whole` without the switches of a telegraph, and made white.

    None where steps and disturbed times of `state` are no such switches. The `whole` has the
    structure of `state` with a Gauss-Markov process, and no course or interval taken out.
    """
    kinds = whole.model.kinds
    begin = kinds.first_slot + EACH * kinds.added.index("gauss_markov")
    three = whole.model.theta[begin : begin + EACH]
    constant = float(shape_of("gauss_markov", three, whole.data.samples)[0])
    levels = levels_of(whole, begin, constant, seed)
    if levels.chance > whole.alarm or np.count_nonzero(np.diff(levels.high)) < FEWEST:
        return None
    spread = levels.upper * (1 - levels.upper)
    height = float(np.exp(three[0] / 2)) / np.sqrt(spread)
    if any(
        abs(abs(each) - height) > _ALIKE * height + _DEVIATIONS * deviation
        for each, deviation in _step_heights(state, seed)
    ):
        return None
    steps = [course.draw()[:, 0] for course in state.courses if course.name == "step"]
    white, stay = _less_levels(whole, levels, height, constant, steps)
    return white if not stay and quiet(whole, white, state.knocks) else None


def of_switches(spikes: Contamination, white: Float[np.ndarray, " samples"], seed: int) -> bool:
    """Whether spikes are gone from a record, made `white`, that lacks the switches."""
    left = contamination(white, seed, spikes.boxes)
    return _power(left) < _LEFT * _power(spikes)


def _power(spikes: Contamination) -> float:
    """Over that of the noise without them."""
    return spikes.fraction * (spikes.amplitude / spikes.sigma) ** 2


def _less_levels(
    whole: Investigation,
    levels: Levels,
    height: float,
    constant: float,
    steps: list[Float[np.ndarray, " samples"]],
) -> tuple[Float[np.ndarray, " samples"], bool]:
    """The longest stretch less its two levels, made white; and whether a step stays in it."""
    values = whole.values[slice(*whole.longest)]
    path = _levels_in_time(values, levels.high, round(constant))
    names = whole.model.kinds.names
    bare = _model.without(whole.model, names.index("gauss_markov"))
    spectrum = whole.ordinates_of(values - height * path)
    expected = level(spectrum, _course.ordinate_variance(spectrum, bare, whole.data))
    white = whitened(values, spectrum, expected)
    switches = whitened(path, spectrum, expected)
    # The switches themselves know their height better than the process does.
    left = white - (white @ switches) / (switches @ switches) * switches
    shapes = [whitened(each[slice(*whole.longest)], spectrum, expected) for each in steps]
    return left, any((left @ each) ** 2 > _LEFT * (white @ each) ** 2 for each in shapes)


def quiet(
    whole: Investigation,
    white: Float[np.ndarray, " samples"],
    knocks: list[tuple[int, int]],
) -> bool:
    """Whether nothing is loud in some times of what was made `white`, if there are any."""
    if not knocks:
        return True
    start, _ = whole.longest
    loud = np.zeros(white.size, bool)
    for low, high in knocks:
        loud[max(low - start, 0) : max(high - start, 0)] = True
    if not loud.any() or loud.all():
        return False
    return bool(np.mean(white[loud] ** 2) < _LOUD * np.mean(white[~loud] ** 2))


def _levels_in_time(
    values: Float[np.ndarray, " samples"], high: Bool[np.ndarray, " moments"], near: int
) -> Float[np.ndarray, " samples"]:
    """1 on the upper level and 0 on the lower, from moments of the switches, rough if few.

    Each switch is where the sum of what lies above the middle turns, within `near` samples.
    """
    count = values.size
    if high.size == count:
        return high.astype(float)
    rough = np.round((np.flatnonzero(np.diff(high.astype(int))) + 1) * count / high.size)
    edges = np.concatenate([[0], rough, [count]]).astype(int)
    path, up, last = np.zeros(count), bool(high[0]), 0
    for before, middle, after in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        low = max((before + middle) // 2, middle - near, last)
        end = max(min((middle + after + 1) // 2, middle + near), low + 2)
        part = values[low:end]
        at = max(min(middle - low, part.size - 1), 1)
        centre = (part[:at].mean() + part[at:].mean()) / 2
        turn = np.cumsum(part - centre) * (1 if up else -1)
        place = low + 1 + int(np.argmax(turn))
        path[last:place] = up
        last, up = place, not up
    path[last:] = up
    return path


def _step_heights(state: Investigation, seed: int) -> list[tuple[float, float]]:
    """The height of each step, with its standard deviation."""
    if state.sized is None:
        return []
    columns, _ = draw_courses(state, np.random.default_rng(seed), _DRAWS)
    return [
        (float(np.mean(sizes)), float(np.std(sizes)))
        for course, sizes in zip(state.courses, columns, strict=True)
        if course.name == "step"
    ]
