"""A structure at its best parameters, and what it is like."""

from typing import NamedTuple

import numpy as np

from ._climb import LEAST_GAIN, MOST_STEPS, climb, rescale
from ._density import TOGETHER, expected_density
from ._structure import (
    EACH,
    ECHO,
    NOTCH,
    SHAPE,
    TERMS,
    Data,
    Kinds,
    bounds,
    free,
    free_filter,
    shape_of,
)

# Less than this in a step, and another start of the same name is ahead or soon will be; so it is
# with such a part of what a poor model leaves beyond one a bin.
_ROUGH_GAIN, _ROUGH_SHARE = 0.02, 1e-3
# Part of the spectrum that a term is given to start with.
_FAINT = 1e-4
# Quality and relative width up to which they are usual, and the power with which they become rare.
_USUAL = {"resonance": 150.0, "drifting_line": 0.01}
_RARER = 1.5
#: With less quality a resonance hardly swings, which is rare as well.
SWINGS = 1.5
# The correlation time in samples from which on it is usual.
_SHORTEST = 2.0
# The relative width from which on a notch is none, and the distance of an echo's ripples [cycles
# per sample] from which on other shapes are as good.
_WIDEST, _RIPPLES = 0.7, 0.35


class Model(NamedTuple):
    """A structure at its best parameters."""

    kinds: Kinds
    theta: np.ndarray
    #: Sum of squared deviance residuals.
    deviance: float


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

    `rough` is near enough to say which start leads furthest.
    """
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
        for begin in range(0, len(places), TOGETHER):
            group = places[begin : begin + TOGETHER]
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


def without(model: Model, place: int) -> Model:
    """The structure less one of `kinds.names`, where its other parameters are."""
    kinds = model.kinds
    if kinds.shaping is not None and place == 0:
        bare = kinds._replace(shaping=None, last=False, floored=False)
        return Model(bare, np.delete(model.theta, SHAPE), model.deviance)
    place -= kinds.shaping is not None
    begin = kinds.first_notch + EACH * place
    kept = np.delete(model.theta, slice(begin, begin + EACH))
    if place < kinds.notches:
        return Model(kinds._replace(notches=kinds.notches - 1), kept, model.deviance)
    place -= kinds.notches
    added = kinds.added[:place] + kinds.added[place + 1 :]
    return Model(kinds._replace(added=added), kept, model.deviance)


def of_samples(model: Model, before: Data, after: Data) -> Model:
    """The same structure for a record of another length, which bounds its shapes elsewhere."""
    theta = np.array(model.theta)
    kinds = model.kinds
    places = [kinds.first_slot + EACH * place for place in range(len(kinds.added))]
    begins = list(zip(kinds.added, places, strict=True))
    begins += [(NOTCH, begin) for begin in range(kinds.first_notch, kinds.first_slot, EACH)]
    if kinds.shaping is not None:
        begins.append((kinds.shaping, TERMS))
    for name, begin in begins:
        shape = shape_of(name, theta[begin : begin + EACH], before.samples)
        limits = bounds(name, after.samples)
        theta[begin + 1 : begin + EACH] = [
            free(float(each), *limit) for each, limit in zip(shape, limits, strict=True)
        ]
    return Model(kinds, theta, model.deviance)


def mean_density(model: Model, data: Data) -> np.ndarray:
    """The expected density of each bin."""
    return expected_density(model.theta, model.kinds, data)


def notches(model: Model, data: Data) -> list[tuple[float, float]]:
    """The frequency and the relative width of each notch."""
    threes = model.theta[model.kinds.first_notch : model.kinds.first_slot].reshape(-1, EACH)
    shapes = [shape_of(NOTCH, three, data.samples) for three in threes]
    return [(float(frequency), float(width)) for frequency, width in shapes]


def is_narrow_notch(model: Model, data: Data) -> bool:
    """Whether there are notches, and the last is narrow; of a wide one any shape may be as good."""
    return model.kinds.notches > 0 and notches(model, data)[-1][1] < _WIDEST


def ripples(model: Model, data: Data) -> bool:
    """Whether there is an echo, and late enough that no other shape is as good."""
    return model.kinds.shaping == ECHO and shaping_shape(model, data)[0] < _RIPPLES


def shaping_shape(model: Model, data: Data) -> tuple[float, float]:
    """The two shape parameters of what shapes the model: a filter's cut-off and order, say."""
    three = model.theta[TERMS : TERMS + EACH]
    cutoff, order = shape_of(model.kinds.shaping or "", three, data.samples)
    return float(cutoff), float(order)


def reshaped(
    model: Model, kind: str, cutoff: float, order: float, data: Data, droop: float = 0.0
) -> tuple[Kinds, np.ndarray]:
    """Where a climb begins from the model with a filter of another kind or shape; floors stay."""
    theta = model.theta.copy()
    theta[TERMS : TERMS + EACH] = free_filter(kind, cutoff, order, data.samples, droop)
    return model.kinds._replace(shaping=kind), theta


def rise_without(term: int, model: Model, data: Data) -> float:
    """How much the deviance rises without one of Q, N, B, K, all else fitted again."""
    terms = np.array(data.terms)
    terms[term] = False
    less = best([(model.kinds, model.theta)], data._replace(terms=terms))[0]
    return less.deviance - model.deviance


def swings(model: Model, data: Data) -> bool:
    """Whether the resonance that was added last has a quality that makes it swing."""
    three = model.theta[model.kinds.first_slot :].reshape(-1, EACH)[-1]
    return float(shape_of("resonance", three, data.samples)[1]) > SWINGS


def rarity(model: Model, data: Data, place: int = -1) -> float:
    """Twice the log of how usual an added noise is: where spectra do not tell, engineers do.

    A resonance that rings for hundreds of periods is rare in a sensor, and so is one that hardly
    swings; a line that wanders by more than a hundredth is hardly a line; nor is a bias that is
    forgotten within two samples one, but white noise behind a filter. `place` is among the noises
    added, the last by default.
    """
    name = model.kinds.added[place] if model.kinds.added else ""
    if name not in (*_USUAL, "gauss_markov"):
        return 0.0
    three = model.theta[model.kinds.first_slot :].reshape(-1, EACH)[place]
    first, breadth = (float(each) for each in shape_of(name, three, data.samples))
    excess = _SHORTEST / first if name == "gauss_markov" else breadth / _USUAL[name]
    if name == "resonance":
        excess = max(excess, SWINGS / breadth - 1)
    return -2 * _RARER * float(np.logaddexp(0.0, np.log(excess)))
