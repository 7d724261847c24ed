"""Which effects a spectrum asks for: what each would gain, and whether chance would as well."""

import itertools
from typing import NamedTuple

import numpy as np

from .._chance import PRICE
from ._climb import (
    LEAST_GAIN,
    MOST_STEPS,
    ON_TRIAL,
    TOGETHER,
    climb,
    expected_density,
    noise_density,
    rescale,
)
from ._running_mean import running_means
from ._structure import (
    ADDED,
    DROOPING,
    EACH,
    FLAT,
    FREE_FILTERS,
    HIGH_PASS,
    RUNNING_MEAN,
    TERMS,
    WINDOWED,
    Data,
    Kinds,
    bounds,
    free,
    free_filter,
    shape_of,
)

_MOST_ADDED = 3
# Less than this in a step, and another start of the same name is ahead or soon will be; so it is
# with such a part of what a poor model leaves beyond one a bin.
_ROUGH_GAIN, _ROUGH_SHARE = 0.02, 1e-3
# Of many starts of a kind so many go on after so many steps: of 75 recordings none lost what it
# asked for. A bump begins at more places than any other effect.
_KEPT, _TRIAL = 4, 9
_KEPT_BUMPS = 8
# What leaves so many times as much by then, while another of its name is ahead, never leads.
_HOPELESS = 10.0
# Part of the density that a weak effect has where it is strongest.
_WEAK = 0.3
# Quantization noise over white noise at the Nyquist frequency that is worth a word.
_MUCH = 0.05
# A corner within such a factor of the lowest that is looked for is none.
_LOWEST = 1.05
# Part of the spectrum that a term is given to start with.
_FAINT = 1e-4
# Quality and relative width up to which they are usual, and the power with which they become rare.
_USUAL = {"resonance": 150.0, "drifting_line": 0.01}
_RARER = 1.5
# And the correlation time in samples from which on it is usual.
_SHORTEST = 2.0
# A filter with a window is looked for where another is of a higher order, or leaves so much
# deviance a bin; its orders to begin with.
_STEEP, _POOR = 3.0, 1.25
_WINDOWS = (12.0, 36.0, 108.0)


class Model(NamedTuple):
    """A structure at its best parameters."""

    kinds: Kinds
    theta: np.ndarray
    #: Sum of squared deviance residuals.
    deviance: float


class Candidate(NamedTuple):
    """One more effect, and by how much the deviance falls."""

    name: str
    model: Model
    gain: float


Start = tuple[str, Kinds, np.ndarray]


def five_terms(power: np.ndarray, data: Data) -> Model:
    """The five-term model at its best, from squared coefficients for a sampling interval of one."""
    with np.errstate(divide="ignore"):
        return best([(Kinds(), np.log(power))], data)[0]


def best(
    starts: list[tuple[Kinds, np.ndarray]],
    data: Data,
    steps: int = MOST_STEPS,
    *,
    rough: bool = False,
) -> list[Model]:
    """Where each start leads in so many steps; those of one kind climb together.

    Two of them all the way, since more wait for the last, and more on the first few steps; `rough`
    is near enough to say which start leads furthest.
    """
    together = TOGETHER if steps == MOST_STEPS else ON_TRIAL
    # A term at zero may still be wanted by finer bins or beside other effects, but a power whose
    # logarithm runs away never returns: it starts where it hardly shows.
    level = np.median(data.bins.density[data.bins.used])
    least = np.log(_FAINT * level / np.asarray(data.bins.expected)[data.bins.used].max(axis=0))
    enough = (_ROUGH_GAIN, _ROUGH_SHARE) if rough else (LEAST_GAIN, 0.0)
    alike: dict[Kinds, list[int]] = {}
    for place, (kinds, _) in enumerate(starts):
        alike.setdefault(kinds, []).append(place)
    found: dict[int, Model] = {}
    for kinds, places in alike.items():
        for begin in range(0, len(places), together):
            group = places[begin : begin + together]
            thetas = np.stack([starts[place][1] for place in group])
            thetas[:, :TERMS] = np.maximum(thetas[:, :TERMS], least)
            reached = climb(thetas, kinds, data, enough, steps)
            for place, theta, deviance in zip(group, *reached, strict=True):
                value = float(deviance) if np.isfinite(deviance) else np.inf
                found[place] = Model(kinds, theta, value)
    return [found[place] for place in range(len(starts))]


def rescaled(model: Model, data: Data) -> Model:
    """The model with the powers that fit `data` best, its shapes held."""
    theta, deviance = rescale(model.theta, model.kinds, data)
    return Model(model.kinds, theta, deviance)


def mean_density(model: Model, data: Data) -> np.ndarray:
    """The expected density of each bin."""
    return expected_density(model.theta, model.kinds, data)


def candidates(
    model: Model, data: Data, peaks: tuple[tuple[float, float], ...] = ()
) -> list[Candidate]:
    """What each effect would gain beside those that the model holds.

    `peaks` are narrow bands that stand out, as (frequency, half width) in cycles per sample.
    """
    starts: list[Start] = []
    if len(model.kinds.added) < _MOST_ADDED:
        for name in ADDED:
            shapes = _shapes(name, data, (*peaks, *_highest(model, data)))
            starts += _added(name, shapes, model, data)
    if model.kinds.shaping is None:
        starts += _filtered(model, data)
    if model.kinds.shaping in FREE_FILTERS:
        starts += _drooping(model, data)
    starts += _filtered_last(starts)
    found = _compare(_promising(starts, data, _KEPT), model, data)
    strongest = max((each.gain for each in found), default=0.0)
    return [
        _sharper(each, model, data) if each.name == "low_pass" and each.gain == strongest else each
        for each in found
    ]


def again(found: Candidate, model: Model, data: Data) -> Candidate:
    """A candidate on data that are little different from those that it was found on."""
    reached = best([(found.model.kinds, found.model.theta)], data)[0]
    return found._replace(model=reached, gain=max(model.deviance - reached.deviance, 0.0))


def bumps(model: Model, data: Data) -> list[Candidate]:
    """A bump, smooth or flat, or a lack toward low frequency, where nothing named helps."""
    if model.kinds.shaping is not None:
        return []
    starts = []
    mean, density, shape = mean_density(model, data), data.bins.density, data.bins.shape
    frequency = data.bins.frequency
    low, high = frequency[data.bins.used].min(), frequency[data.bins.used].max()
    for centre in np.geomspace(2 * low, high * 0.9, 12):
        for shaping, width in itertools.product(("bump", FLAT), (0.15, 0.5)):
            weight = shape * np.exp(-((np.log(frequency / centre) / width) ** 2) / 2)
            if weight.sum() < 1:
                continue
            height = np.log(np.sum(weight * density / mean) / weight.sum())
            three = [6 * np.arctanh(np.clip(height, -5, 5) / 6)]
            limits = bounds(shaping, data.samples)
            three += [free(centre, *limits[0]), free(width, *limits[1])]
            starts.append(("bump", *_shaping_start(shaping, three, model)[1:]))
    limits = bounds(HIGH_PASS, data.samples)
    for centre, width in itertools.product(np.geomspace(2 * low, high / 4, 8), (0.25, 0.5)):
        three = [0.0, free(centre, *limits[0]), free(width, *limits[1])]
        starts.append(("bump", *_shaping_start(HIGH_PASS, three, model)[1:]))
    return _compare(_promising(starts, data, _KEPT_BUMPS), model, data)


def _compare(starts: list[Start], model: Model, data: Data) -> list[Candidate]:
    found = best([(kinds, theta) for _, kinds, theta in starts], data, rough=True)
    leading: dict[str, Model] = {}
    for (name, _, _), reached in zip(starts, found, strict=True):
        if name not in leading or _cost(reached, data) < _cost(leading[name], data):
            leading[name] = reached
    # Of many starts one matters, and it goes the rest of its way alone.
    whole = [best([(rough.kinds, rough.theta)], data)[0] for rough in leading.values()]
    return [
        Candidate(name, reached, max(model.deviance - reached.deviance, 0.0))
        for name, reached in zip(leading, whole, strict=True)
    ]


def _promising(starts: list[Start], data: Data, kept: int) -> list[Start]:
    """Those of each name and kind that are ahead after a few steps, where these have led."""
    found = best([(kinds, theta) for _, kinds, theta in starts], data, _TRIAL, rough=True)
    costs = [_cost(each, data) for each in found]
    least = {}
    for (name, _, _), cost in zip(starts, costs, strict=True):
        least[name] = min(cost, least.get(name, np.inf))
    bins = np.count_nonzero(data.bins.used)
    alike: dict[tuple[str, Kinds], list[tuple[float, Model]]] = {}
    for (name, kinds, _), reached, cost in zip(starts, found, costs, strict=True):
        if cost - bins <= _HOPELESS * max(least[name] - bins, bins):
            alike.setdefault((name, kinds), []).append((cost, reached))
    return [
        (name, kinds, reached.theta)
        for (name, kinds), every in alike.items()
        for _, reached in sorted(every, key=lambda one: one[0])[:kept]
    ]


def _cost(model: Model, data: Data) -> float:
    """The deviance, and a price if a filter takes quantization noise for what it passes.

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
    return model.deviance + (PRICE if needed else 0.0)


def _highest(model: Model, data: Data) -> list[tuple[float, float]]:
    """Where the spectrum stands highest above the model, as (frequency, half width)."""
    ratio = np.where(data.bins.used, data.bins.density / mean_density(model, data), 1.0)
    shape = np.asarray(data.bins.shape)
    # Deviance of three neighbours together, where they are above.
    kernel = np.ones(3)
    weight = np.convolve(shape, kernel, "same")
    mean = np.convolve(shape * ratio, kernel, "same") / np.maximum(weight, 1e-9)
    excess = np.where(mean > 1, weight * (mean - 1 - np.log(np.maximum(mean, 1e-9))), 0.0)
    at = int(np.argmax(excess))
    frequency = float(data.bins.frequency[at])
    return [(frequency, 0.03 * frequency), (frequency, 0.15 * frequency)]


def _shapes(name: str, data: Data, peaks) -> list[tuple[float, float]]:
    samples = float(data.samples)
    if name == "gauss_markov":
        return [(t, 1.0) for t in np.geomspace(0.6, samples / 12, 8)]
    if name == "power_law":
        return [(exponent, 1.0) for exponent in (0.6, 1.5, 2.5)]
    if name == "resonance":
        broad = [(f, 2.0) for f in np.geomspace(8 / samples, 0.4, 8)]
        return broad + [(f, f / (2 * w)) for f, w in peaks]
    return [(f, w / f) for f, w in peaks]


def _added(name: str, shapes, model: Model, data: Data) -> list[Start]:
    limits = bounds(name, float(data.samples))
    mean, used = mean_density(model, data), data.bins.used
    kinds = model.kinds._replace(added=(*model.kinds.added, name))
    starts: list[Start] = []
    for first, second in shapes:
        three = np.array([0.0, free(first, *limits[0]), free(second, *limits[1])])
        unit = noise_density(name, three[None], data)[0]
        strongest = int(np.argmax(np.where(used, unit / mean, 0.0)))
        # As much as the data have there above the model, but no less than a weak effect has.
        seen = float(data.bins.density[strongest] / mean[strongest] - 1)
        much = max(seen, _WEAK)
        for part in sorted({much, _WEAK}) if name == "gauss_markov" else [much]:
            three[0] = np.log(part * mean[strongest] / unit[strongest])
            starts.append((name, kinds, np.concatenate([model.theta, three])))
    if model.kinds.shaping in (*FREE_FILTERS, *DROOPING) and starts:
        # What the filter had to bend for before may now be straight.
        best_start = starts[-1][2]
        alike = DROOPING if model.kinds.shaping in DROOPING else FREE_FILTERS
        for kind, cutoff in itertools.product(alike, (0.15, 0.3, 0.45)):
            kinds = kinds._replace(shaping=kind)
            again = best_start.copy()
            three = free_filter(kind, cutoff, 1.2, float(data.samples), again[TERMS])
            again[TERMS : TERMS + EACH] = three
            starts.append((name, kinds, again))
    return starts


def _filtered_last(starts: list[Start]) -> list[Start]:
    """The same with added noises in front of the filter too, where it is behind the converter."""
    return [
        (name, kinds._replace(last=True), theta)
        for name, kinds, theta in starts
        if kinds.angle_filtered and kinds.added and not kinds.last
    ]


def _filtered(model: Model, data: Data) -> list[Start]:
    density, used, frequency = data.bins.density, data.bins.used, data.bins.frequency
    starts = []
    for kind, cutoff in itertools.product(FREE_FILTERS, (0.02, 0.08, 0.25, 0.48)):
        for order in (1.0, 2.5):
            three = free_filter(kind, cutoff, order, float(data.samples))
            _, kinds, theta = _shaping_start(kind, three, model)
            # White noise as it is below the cut-off, and little of what rises beyond it.
            below = used & (frequency > cutoff / 8) & (frequency < cutoff / 2)
            if below.any():
                theta[1] = np.log(np.median(density[below]) / 2)
            theta[0] = min(theta[0], np.log(np.median(density[used][-8:]) / 80))
            starts.append(("low_pass", kinds, theta))
    for cutoff, order in running_means(data):
        three = free_filter(RUNNING_MEAN, cutoff, order, float(data.samples))
        starts.append(("low_pass", *_shaping_start(RUNNING_MEAN, three, model)[1:]))
    return starts


def _drooping(model: Model, data: Data) -> list[Start]:
    """The filter that the model has, of another shape."""
    starts = []
    cutoff, order = shaping_shape(model, data)
    for kind, droop in itertools.product(DROOPING, (-1.0, 1.5)):
        theta = model.theta.copy()
        theta[TERMS : TERMS + EACH] = free_filter(kind, cutoff, order, data.samples, droop)
        starts.append(("droop", model.kinds._replace(shaping=kind), theta))
    return starts + [("droop", *start) for start in _windowed(model, data)]


def _windowed(model: Model, data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """The filter that the model has, with an edge as steep as it asks for."""
    cutoff, order = shaping_shape(model, data)
    poor = model.deviance > _POOR * np.count_nonzero(data.bins.used)
    starts = []
    for taps in _WINDOWS if (order > _STEEP or poor) and cutoff < 0.5 else ():
        theta = model.theta.copy()
        theta[TERMS : TERMS + EACH] = free_filter(WINDOWED, cutoff, taps, data.samples)
        starts.append((model.kinds._replace(shaping=WINDOWED), theta))
    return starts


def shaping_shape(model: Model, data: Data) -> tuple[float, float]:
    """The two shape parameters of what shapes the model: a filter's cut-off and order, say."""
    three = model.theta[TERMS : TERMS + EACH]
    cutoff, order = shape_of(model.kinds.shaping or "", three, data.samples)
    return float(cutoff), float(order)


def _sharper(found: Candidate, model: Model, data: Data) -> Candidate:
    """A filter, or at once the steeper one that it stands for: lines would be made of the rest."""
    starts = _windowed(found.model, data) if found.model.kinds.filtering else []
    steeper = min(best(starts, data), key=lambda each: each.deviance, default=None)
    # What a resonance leaves is no matter of edges, and has its turn.
    bins = np.count_nonzero(data.bins.used)
    if steeper is None or steeper.deviance - bins > (found.model.deviance - bins) / 2:
        return found
    return Candidate(found.name, steeper, max(model.deviance - steeper.deviance, 0.0))


def _shaping_start(name: str, three: list[float], model: Model) -> Start:
    theta = np.concatenate([model.theta[:TERMS], three, model.theta[TERMS:]])
    return name, model.kinds._replace(shaping=name), theta


def rarity(model: Model, data: Data, place: int = -1) -> float:
    """Twice the log of how usual an added noise is: where spectra do not tell, engineers do.

    A resonance that rings for hundreds of periods is rare in a sensor, and a line that wanders by
    more than a hundredth is hardly a line; nor is a bias that is forgotten within two samples one,
    but white noise behind a filter. `place` is among the noises added, the last by default.
    """
    name = model.kinds.added[place] if model.kinds.added else ""
    if name not in (*_USUAL, "gauss_markov"):
        return 0.0
    three = model.theta[model.kinds.first_slot :].reshape(-1, EACH)[place]
    first, breadth = (float(each) for each in shape_of(name, three, data.samples))
    excess = _SHORTEST / first if name == "gauss_markov" else breadth / _USUAL[name]
    return -2 * _RARER * float(np.logaddexp(0.0, np.log(excess)))


def rise_without(term: int, model: Model, data: Data) -> float:
    """How much the deviance rises without one of Q, N, B, K, all else fitted again."""
    terms = np.array(data.terms)
    terms[term] = False
    less = best([(model.kinds, model.theta)], data._replace(terms=terms))[0]
    return less.deviance - model.deviance


def without(model: Model, place: int) -> Model:
    """The structure less one of `kinds.names`, where its other parameters are."""
    kinds, begin = model.kinds, TERMS + EACH * place
    kept = np.concatenate([model.theta[:begin], model.theta[begin + EACH :]])
    if kinds.shaping is not None and place == 0:
        return Model(kinds._replace(shaping=None, last=False), kept, model.deviance)
    place -= kinds.shaping is not None
    added = kinds.added[:place] + kinds.added[place + 1 :]
    return Model(kinds._replace(added=added), kept, model.deviance)


def instead(model: Model, place: int, name: str, data: Data) -> Model | None:
    """The structure with another noise in place of one of `kinds.added`; it comes last of them."""
    bare = rescaled(without(model, place + (model.kinds.shaping is not None)), data)
    found = _compare(_added(name, _shapes(name, data, ()), bare, data), bare, data)
    return found[0].model if found else None
