"""The posterior of a structure: coefficients and effects together, by emcee.

Coefficients have the prior of the five-term fit (`identify._posterior`). The size of an effect is
uniform in its logarithm down to a twentieth of what was found, and its shape is uniform in the
logarithm within the bounds in which it was looked for.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import expit, log_ndtr, ndtri

from ...identify._posterior import _ABSENCE
from .._chance import PRICE
from ._density import log_slopes, parts, summed
from ._holding import foreign, held_rows
from ._model import Model, best, reshaped, rise_without
from ._population import draw
from ._running_mean import nearest_running_means, running_means
from ._structure import (
    DROOPING,
    DROOPS,
    EACH,
    ECHO,
    FLAT,
    FLOOR,
    FREE_FILTERS,
    MEANS,
    RIPPLED,
    SHAPE,
    TERMS,
    TWO_POLES,
    WINDOWED,
    Data,
    Kinds,
    active,
    droop_of,
    floor_of,
    poles,
    ripple_of,
    shape_of,
)

# Points about the best, of which the first kernels are.
_ABOUT = 1500
# A kind of filter that is less likely is not sampled.
_OPEN = 0.02
# And one that is so much less likely than the likeliest is sampled roughly.
_MINOR = 0.3
# Two poles that are somewhat apart, as a free droop.
_APART = 1.5
_SMALLEST = float(np.log(0.05**2))


class Draws(NamedTuple):
    """Draws from the posterior of a structure."""

    #: Squares of Q, N, B, K for a sampling interval of one, shape (draws, 4).
    power: Float[np.ndarray, "draws terms"]
    #: All parameters, as `Model.theta`, shape (draws, parameters).
    theta: Float[np.ndarray, "draws parameters"]
    #: Cut-off frequency [cycles per sample], order, droop, and in dB ripple, attenuation and floor
    #: of a filter, (draws, 6), or none.
    filtering: Float[np.ndarray, "draws six"] | None = None
    #: The structure with the likeliest kind of filter, and which draws are of it.
    likeliest: Model | None = None
    of_likeliest: Bool[np.ndarray, " draws"] | None = None


def sample_structure(model: Model, data: Data, seed: int, *, quick: bool = False) -> Draws:
    """Draw the coefficients and the parameters of all effects of a structure.

    A filter before the converter looks like one behind it, of another cut-off: the draws are of
    all kinds that the data leave open, each as often as its likelihood says, less what it costs if
    it needs quantization noise where others do without. `quick` is a quarter of the work, for rough
    intervals.
    """
    if not model.kinds.filtering:
        return _sample(model, data, seed, quick)
    models = [model, *_other_filters(model, data)]
    costs = [each.deviance + min(rise_without(0, each, data), PRICE) for each in models]
    weights = np.exp((min(costs) - np.array(costs)) / 2)
    weights /= weights.sum()
    likeliest = models[int(np.argmax(weights))]
    parts, rng = [], np.random.default_rng(seed)
    for each, weight in zip(models, weights, strict=True):
        if weight > _OPEN:
            drawn = _sample(each, data, seed, quick or weight < _MINOR * weights.max())
            kept = rng.random(len(drawn.power)) < weight / weights.max()
            filters = _filters(each.kinds, drawn.theta[kept, SHAPE].T, data.samples)
            best = np.full(kept.sum(), each is likeliest)
            parts.append((drawn.power[kept], drawn.theta[kept], filters, best))
    power, theta, filtering, best = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Draws(power, theta, filtering, likeliest, best)


def _filters(kinds: Kinds, four: Float[np.ndarray, "four draws"], samples: Any):
    shaping = kinds.shaping or ""
    cutoff, order = shape_of(shaping, four, samples)
    none = np.zeros(four.shape[1])
    droop = droop_of(four) if shaping in DROOPS else none
    rippled = none, none
    if shaping in RIPPLED:
        rippled, order = (ripple_of(four), order), none + poles(shaping)
    floor = floor_of(four) if kinds.floored else none
    return np.stack([cutoff, order, droop, *rippled, floor], axis=1)


def _other_filters(model: Model, data: Data) -> list[Model]:
    """The same structure with filters of the other kinds."""
    three = model.theta[TERMS : TERMS + EACH]
    cutoff, order = map(float, shape_of(model.kinds.shaping or "", three, data.samples))
    if model.kinds.shaping in RIPPLED:
        # It is far from all but those of one pole more or less, and those on the other side.
        own = poles(model.kinds.shaping)
        near = [
            reshaped(model, kind, cutoff, order, data, three[0])
            for kind in RIPPLED
            if abs(poles(kind) - own) <= 1 and kind != model.kinds.shaping
        ]
        return best(near, data)
    alike = (*FREE_FILTERS, *TWO_POLES)
    if model.kinds.shaping in DROOPING:
        alike = DROOPING
    elif model.kinds.shaping == WINDOWED:
        # It is far from all others.
        alike = ()
    tried = [(kind, cutoff, order) for kind in alike]
    means = {*nearest_running_means(cutoff), *running_means(data)[:2]}
    tried += sorted(means)
    starts = []
    for kind, cutoff, order in tried:
        if kind != model.kinds.shaping:
            droop = model.theta[TERMS]
            if kind in TWO_POLES:
                order, droop = 2.0, droop or _APART
            elif kind in FREE_FILTERS:
                droop = 0.0
            kinds, theta = reshaped(model, kind, cutoff, order, data, droop)
            starts.append((kinds._replace(floored=kinds.floored and kind not in MEANS), theta))
    found = best(starts, data)
    means = [each for each in found if each.kinds.shaping in MEANS]
    free_ones = [each for each in found if each.kinds.shaping not in MEANS]
    found = free_ones + sorted(means, key=lambda each: each.deviance)[:1]
    return [each for each in found if np.isfinite(each.deviance)]


def _sample(model: Model, data: Data, seed: int, quick: bool) -> Draws:
    """Draws of one structure, in coordinates that leave its ridges as straight as may be.

    Powers are quartic: their absence takes some room beside zero, and what they trade off against
    is nearly straight. A shape is a standard normal variate where nothing is known of it.
    """
    kinds, top = model.kinds, model.theta
    terms = np.asarray(data.terms)
    effects = active(kinds, terms)[TERMS:]
    place = np.concatenate([np.flatnonzero(terms), TERMS + np.flatnonzero(effects)])
    count = int(terms.sum())
    # Sizes of added noises: a prior bounded below keeps a faint effect from drifting to nothing.
    sizes = kinds.first_slot + EACH * np.arange(len(kinds.added))
    heights = [TERMS] if kinds.shaping in ("bump", FLAT, ECHO) else []
    bounded = np.flatnonzero(
        ~np.isin(place, np.array([*sizes, *heights])) & (np.arange(place.size) >= count)
    )
    faint = np.flatnonzero(np.isin(place, sizes))
    deviation, absence = _deviations(model, data)[terms], _ABSENCE[terms]
    shape, density = np.asarray(data.bins.shape), np.asarray(data.bins.density)
    held, alien = held_rows(data), foreign(data)

    def unpacked(x: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, "points parameters"]:
        theta = np.tile(top, (len(x), 1))
        rest = x.copy()
        # From a normal variate to a uniform one, and from that to one of any size.
        rest[:, bounded] = log_ndtr(x[:, bounded]) - log_ndtr(-x[:, bounded])
        theta[:, place[count:]] = rest[:, count:]
        power = deviation * x[:, :count] ** 4
        theta[:, place[:count]] = np.log(np.maximum(power, np.exp(FLOOR)))
        return theta

    def log_density(x: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, " points"]:
        with np.errstate(all="ignore"):
            theta = unpacked(x)
            rows, bump, added = parts(theta, kinds, data, held)
            rows = rows[:, terms]
            power = np.exp(theta[:, place[:count]])
            total = summed(power, (rows, bump, added), alien)
            excess = density / total - 1
            value = -(excess - np.log1p(excess)) @ shape
            relative = rows / total[:, None]
            information = (relative * shape) @ relative.swapaxes(1, 2)
            value += np.linalg.slogdet(information)[1] / 2
            value += np.sum(np.log((power + deviation) / (power + absence * deviation)), axis=1)
            value += 3 * np.sum(np.log(x[:, :count]), axis=1)
            # Uniform in the logarithm between the bounds.
            value -= np.sum(x[:, bounded] ** 2, axis=1) / 2
            too_faint = theta[:, place[faint]] < top[place[faint]] + _SMALLEST
        inside = np.all(x[:, :count] > 0, axis=1) & ~too_faint.any(axis=1) & np.isfinite(value)
        return np.where(inside, value, -np.inf)

    rng = np.random.default_rng(seed)
    power = np.exp(top[place[:count]])
    about = np.abs(power + deviation * rng.standard_normal((_ABOUT, count)))
    rest = top[place[count:]] + _scatter(model, data, place, rng)[:, count:]
    start = np.concatenate([(about / deviation) ** 0.25, rest], axis=1)
    start[:, bounded] = _normal(start[:, bounded])
    theta = unpacked(draw(log_density, start, seed, quick=quick))
    return Draws(np.where(terms, np.exp(theta[:, :TERMS]), 0.0), theta)


def _normal(logit: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """The normal variate that is as far out as a logistic one."""
    return -np.sign(logit) * ndtri(expit(-np.abs(logit)))


def _deviations(model: Model, data: Data) -> Float[np.ndarray, " terms"]:
    """Standard deviations of the powers, the effects held; as `identify._posterior.coordinates`."""
    every = parts(model.theta[None], model.kinds, data, held_rows(data))
    power = np.where(np.asarray(data.terms), np.exp(model.theta[:TERMS]), 0.0)
    relative = every[0][0] / summed(power[None], every, foreign(data))[0]
    information = (relative * np.asarray(data.bins.shape)) @ relative.T
    unit = np.sqrt(np.diag(information))
    correlation = information / unit / unit[:, None] + 1e-6 * np.eye(TERMS)
    return np.sqrt(np.diag(np.linalg.inv(correlation))) / unit


def _scatter(model, data, place, rng) -> Float[np.ndarray, "start dim"]:
    """Steps about the best as wide as the information there allows."""
    slope = log_slopes(model.theta[None], model.kinds, data)[0][:, place]
    information = (slope * np.asarray(data.bins.shape)[:, None]).T @ slope
    values, vectors = np.linalg.eigh(information)
    width = 1 / np.sqrt(np.maximum(values, 1.0))
    return (rng.standard_normal((_ABOUT, place.size)) * width) @ vectors.T
