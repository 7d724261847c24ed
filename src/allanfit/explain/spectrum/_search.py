"""Which effects a spectrum asks for: what each would gain, and whether chance would as well."""

from typing import NamedTuple

import numpy as np

from .._chance import PRICE
from ._density import effects_density, parts
from ._holding import held_rows
from ._model import (
    Model,
    best,
    mean_density,
    rescaled,
    rise_without,
    shaping_shape,
    swings,
    without,
)
from ._starts import (
    Peaks,
    Start,
    added_starts,
    bump_starts,
    droop_starts,
    echo_starts,
    filter_starts,
    filtered_last,
    floored_or_not,
    floored_starts,
    highest,
    notch_starts,
    other_windows,
    rippled_starts,
    two_pole_starts,
    windowed_starts,
)
from ._structure import (
    ADDED,
    ECHO,
    FREE_FILTERS,
    MEANS,
    OF_POLES,
    OVERSAMPLED,
    SHAPE,
    TWO_POLES,
    WHITE,
    Data,
    Kinds,
    bounds,
    floor_of,
)

_MOST_ADDED, _MOST_NOTCHES = 3, 3
# Of many starts of a kind so many go on after so many steps: of 75 recordings none lost what it
# asked for. A bump begins at more places than any other effect.
_KEPT, _TRIAL = 4, 9
_KEPT_BUMPS = 8
# What leaves so many times as much by then, while another of its name is ahead, never leads.
_HOPELESS = 10.0
# Quantization noise over white noise at the Nyquist frequency that is worth a word.
_MUCH = 0.05
# What is more of the density than this is most of it.
_MOST = 0.5
# Deviance a bin from which on a comb of means is none.
_GROSS = 3.0
# A filter begins over a floor of such a level at most [dB].
_LOUDEST = -15.0
# And holds such a part of all white noise at most.
_MOST_OF_ALL = 0.25
# Deviance that takes an echo's part of the chance of an alarm to a fifth of what it would be.
_OF_ECHOES = 3.2
# A corner within such a factor of the lowest that is looked for is none.
_LOWEST = 1.05


class Candidate(NamedTuple):
    """One more effect, and by how much the deviance falls."""

    name: str
    model: Model
    gain: float


def candidates(model: Model, data: Data, peaks: Peaks = ()) -> list[Candidate]:
    """What each effect would gain beside those that the model holds; `peaks` stand out already."""
    starts: list[Start] = []
    if len(model.kinds.added) < _MOST_ADDED:
        everywhere = (*peaks, *highest(model, data))
        for name in ADDED:
            starts += added_starts(name, everywhere, model, data)
    if model.kinds.shaping is None:
        starts += filter_starts(model, data)
    if model.kinds.shaping in (*FREE_FILTERS, *TWO_POLES):
        starts += droop_starts(model, data)
    if model.kinds.filtering:
        starts += [("floor", *start) for start in floored_starts(model, data)]
    starts += filtered_last(starts)
    found = _compare(_promising(starts, data, _KEPT), model, data)
    strongest = max((each.gain for each in found), default=0.0)
    return [
        _sharper(each, model, data) if each.name == "low_pass" and each.gain == strongest else each
        for each in found
    ]


def again(found: Candidate, model: Model, data: Data) -> Candidate:
    """A candidate on data that are little different from those that it was found on."""
    reached = best([(found.model.kinds, found.model.theta)], data)[0]
    return found._replace(model=reached, gain=_gain(found.name, reached, model))


def window_again(model: Model, data: Data) -> Model:
    """A window at its best after other ordinates are left out, where there may be better ones."""
    found = best([(model.kinds, model.theta), *other_windows(model, data)], data)
    return min(found, key=lambda each: each.deviance)


def ripple_again(model: Model, data: Data) -> Model:
    """Of a filter that is a poor one after ordinates are left out, one with ripple of any order.

    Or a window: what its ends leaked had floors like those between lobes.
    """
    rippled = rippled_starts(model, data)
    windows = other_windows(model, data) if rippled else []
    others = _ahead_floored_or_not([*rippled, *windows], model, data)
    found = best([(model.kinds, model.theta), *others], data)
    return min(found, key=lambda each: each.deviance)


def bumps(model: Model, data: Data) -> list[Candidate]:
    """A bump, smooth or flat, or a lack toward low frequency, where nothing named helps.

    Beside a filter of poles a notch only; of others it would be a zero.
    """
    if model.kinds.shaping is not None:
        return notch(model, data)
    starts = bump_starts(model, data)
    return _compare(_promising(starts, data, _KEPT_BUMPS), model, data)


def notch(model: Model, data: Data, least: float = 0.0) -> list[Candidate]:
    """A notch, if the lack of power in one place alone has such a deviance."""
    if model.kinds.notches == _MOST_NOTCHES or model.kinds.shaping not in (None, *OF_POLES):
        return []
    return _compare(notch_starts(model, data, least), model, data)


def echo(model: Model, data: Data, least: float = 0.0) -> list[Candidate]:
    """An echo, if the largest ripple gains such a deviance."""
    return _compare(echo_starts(model, data, least), model, data)


def instead(model: Model, place: int, name: str, data: Data) -> Model | None:
    """The structure with another noise in place of one of `kinds.added`; it comes last of them."""
    bare = rescaled(without(model, place + (model.kinds.shaping is not None)), data)
    return beside(bare, name, data)


def beside(model: Model, name: str, data: Data) -> Model | None:
    """The structure with one noise more, if the spectrum has any of it."""
    found = _compare(added_starts(name, (), model, data), model, data)
    return found[0].model if found else None


def _compare(starts: list[Start], model: Model, data: Data) -> list[Candidate]:
    found = best([(kinds, theta) for _, kinds, theta in starts], data, rough=True)
    leading: dict[tuple[str, bool], Model] = {}
    hump = np.inf
    for (name, kinds, _), reached in zip(starts, found, strict=True):
        own = name, _looked_up(kinds)
        if _is_hump(name, reached, data):
            hump = min(hump, _cost(reached, data))
            continue
        if own not in leading or _cost(reached, data) < _cost(leading[own], data):
            leading[own] = reached
    bins = np.count_nonzero(data.bins.used)
    # Of many starts one matters, and it goes the rest of its way alone.
    whole: dict[str, Model] = {}
    for (name, _), rough in leading.items():
        (reached,) = best([(rough.kinds, rough.theta)], data)
        if _is_hump(name, reached, data):
            hump = min(hump, _cost(reached, data))
            continue
        if rough.kinds.shaping == OVERSAMPLED and reached.deviance > _GROSS * bins:
            # It has no number to climb by, and by chance is less wrong than what can.
            continue
        if name not in whole or _cost(reached, data) < _cost(whole[name], data):
            whole[name] = reached
    if "low_pass" in whole and _cost(whole["low_pass"], data) > hump + PRICE:
        # Another noise would be named for the white one.
        del whole["low_pass"]
    if "resonance" in whole and _is_filter(whole["resonance"], data):
        del whole["resonance"]
    if {"gauss_markov", "low_pass"} <= whole.keys() and _is_one_pole(whole["gauss_markov"], data):
        del whole["gauss_markov"]
    return [
        Candidate(name, reached, _gain(name, reached, model)) for name, reached in whole.items()
    ]


def _is_filter(model: Model, data: Data) -> bool:
    """Whether what hardly swings is all noise there is, and so what a filter of it all passes."""
    bare = model.kinds.shaping is None and not swings(model, data)
    return bare and rise_without(WHITE, model, data) < PRICE


def _is_one_pole(model: Model, data: Data) -> bool:
    """Whether correlated noise is most of all up to the Nyquist frequency, and no white is seen.

    No sensor is without white noise, and behind one pole it is just such noise.
    """
    last = np.flatnonzero(data.bins.used)[-1]
    noise = effects_density(model.theta, model.kinds, data)[-1, last]
    part = float(noise / mean_density(model, data)[last])
    return part > _MOST and rise_without(WHITE, model, data) < PRICE


def _is_hump(name: str, model: Model, data: Data) -> bool:
    """Whether a filter's floor is so loud that what passes is correlated noise beside the white.

    Nobody reads a sensor so often that most of what he reads came in behind its filter. Filters
    that are found without a floor may have a louder one.
    """
    if name != "low_pass" or not model.kinds.floored:
        return False
    level = float(floor_of(model.theta[SHAPE]))
    if level > _LOUDEST:
        return True
    held = held_rows(data)
    white = parts(model.theta[None], model.kinds, data, held)[0][0, 1] / held[1]
    whole = np.average(white, weights=np.asarray(data.bins.shape))
    return 10 ** (level / 10) > _MOST_OF_ALL * float(whole)


def _gain(name: str, reached: Model, model: Model) -> float:
    """By how much the deviance falls, less the price of a floor that comes with another effect.

    And that of an echo, which is looked for at as many places as all other bumps together.
    """
    besides = name != "floor" and reached.kinds.floored and not model.kinds.floored
    price = PRICE * besides + _OF_ECHOES * (reached.kinds.shaping == ECHO)
    return max(model.deviance - reached.deviance - price, 0.0)


def _looked_up(kinds: Kinds) -> bool:
    """Whether its shape is, which says nothing of how far those that climb have to go."""
    return kinds.shaping in MEANS


def _promising(starts: list[Start], data: Data, kept: int) -> list[Start]:
    """Those of each name and kind that are ahead after a few steps, where these have led."""
    found = best([(kinds, theta) for _, kinds, theta in starts], data, _TRIAL, rough=True)
    costs = [_cost(each, data) for each in found]
    least: dict[tuple[str, bool], float] = {}
    for (name, kinds, _), cost in zip(starts, costs, strict=True):
        own = name, _looked_up(kinds)
        least[own] = min(cost, least.get(own, np.inf))
    bins = np.count_nonzero(data.bins.used)
    alike: dict[tuple[str, Kinds], list[tuple[float, Model]]] = {}
    for (name, kinds, _), reached, cost in zip(starts, found, costs, strict=True):
        ahead = least[name, _looked_up(kinds)]
        if cost - bins <= _HOPELESS * max(ahead - bins, bins):
            alike.setdefault((name, kinds), []).append((cost, reached))
    return [
        (name, kinds, reached.theta)
        for (name, kinds), every in alike.items()
        for _, reached in sorted(every, key=lambda one: one[0])[:kept]
    ]


def _cost(model: Model, data: Data) -> float:
    """The deviance, a price of a floor, and one if a filter takes quantization for what it passes.

    A corner at the lowest frequency of all is none: quantization noise that is made flat beyond it
    takes the place of white noise.
    """
    if not model.kinds.filtering:
        return model.deviance
    lowest = bounds(model.kinds.shaping or "", data.samples)[0][0]
    if shaping_shape(model, data)[0] < _LOWEST * lowest:
        return np.inf
    quantization, white = np.asarray(data.bins.expected)[data.bins.used][-1, :2]
    power = np.exp(model.theta[:2])
    needed = power[0] * quantization > _MUCH * power[1] * white
    # Of truth values NumPy makes a sum that is one at most.
    return model.deviance + PRICE * (int(needed) + int(model.kinds.floored))


def _sharper(found: Candidate, model: Model, data: Data) -> Candidate:
    """A filter, or at once what it stands for: two poles, or an edge that is steeper."""
    found = _likelier(found, two_pole_starts(found.model, data), model, data, part=1.0)
    found = _likelier(found, floored_starts(found.model, data), model, data, part=0.5)
    # Lines would be made of what a wrong edge leaves. What a resonance leaves is no matter of
    # edges, and has its turn; but no window comes near the zeros of a running mean.
    part = 0.9 if found.model.kinds.shaping in MEANS else 0.5
    for starts in (windowed_starts, rippled_starts):
        either = _ahead_floored_or_not(starts(found.model, data), found.model, data)
        found = _likelier(found, either, model, data, part)
    return found


def _ahead(starts: list[tuple[Kinds, np.ndarray]], data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """Of each kind the one that leads after a few steps, of those kinds that do after some more.

    One in front of the converter, of which what it passes folds back, needs more of them.
    """
    for kept, steps in (2 * _KEPT, _TRIAL), (_KEPT, 2 * _TRIAL):
        found = sorted(best(starts, data, steps, rough=True), key=lambda each: _cost(each, data))
        leading: dict[Kinds, np.ndarray] = {}
        for each in found:
            leading.setdefault(each.kinds, each.theta)
        starts = [*leading.items()][:kept]
        if len(starts) <= _KEPT:
            break
    return starts


def _ahead_floored_or_not(
    starts: list[tuple[Kinds, np.ndarray]], model: Model, data: Data
) -> list[tuple[Kinds, np.ndarray]]:
    """Those that lead, beside the terms of a model, each over a floor and over none."""
    return floored_or_not(_ahead(starts, data), model, data)


def _likelier(
    found: Candidate,
    starts: list[tuple[Kinds, np.ndarray]],
    model: Model,
    data: Data,
    part: float,
) -> Candidate:
    """The best of others if it leaves no more than such a part of what this one leaves."""
    bins = np.count_nonzero(data.bins.used)
    other = min(best(starts, data), key=lambda each: _cost(each, data), default=None)
    if other is None:
        return found
    cost, before = _cost(other, data), _cost(found.model, data)
    if cost > before or cost - bins > part * (before - bins):
        return found
    return Candidate(found.name, other, _gain(found.name, other, model))
