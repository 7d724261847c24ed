"""The posterior of a structure: coefficients and effects together, by emcee.

Coefficients have the prior of the five-term fit (`identify._posterior`). The size of an effect is
uniform in its logarithm down to a twentieth of what was found, and its shape is uniform in the
logarithm within the bounds in which it was looked for.
"""

from typing import Any, NamedTuple

import emcee
import numpy as np
from jaxtyping import Bool, Float

from ...identify._posterior import _ABSENCE
from .._chance import PRICE
from ._density import log_slopes, parts, summed
from ._holding import foreign, held_rows
from ._model import Model, best, reshaped, rise_without
from ._running_mean import nearest_running_means, running_means
from ._structure import (
    DROOPING,
    DROOPS,
    EACH,
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

_WALKERS = 32
_BURN_IN = 500
_STEPS = 700
_THIN = 5
_LOST = 12.0
# A kind of filter that is less likely is not sampled.
_OPEN = 0.02
# Two poles that are somewhat apart, as a free droop.
_APART = 1.5
_SMALLEST = float(np.log(0.05**2))
_MOVES = [(emcee.moves.DEMove(), 0.7), (emcee.moves.StretchMove(), 0.3)]


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
            drawn = _sample(each, data, seed, quick)
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
    kinds, top = model.kinds, model.theta
    terms = np.asarray(data.terms)
    effects = active(kinds, terms)[TERMS:]
    place = np.concatenate([np.flatnonzero(terms), TERMS + np.flatnonzero(effects)])
    count = int(terms.sum())
    # Sizes of added noises: a prior bounded below keeps a faint effect from drifting to nothing.
    sizes = kinds.first_slot + EACH * np.arange(len(kinds.added))
    deviation = _deviations(model, data)[terms]
    scale = np.sqrt(_ABSENCE[terms] * deviation)
    shape, density = np.asarray(data.bins.shape), np.asarray(data.bins.density)

    def unpacked(x: Float[np.ndarray, "walkers dim"]) -> Float[np.ndarray, "walkers parameters"]:
        theta = np.tile(top, (len(x), 1))
        theta[:, place[count:]] = x[:, count:]
        power = (scale * np.sinh(x[:, :count])) ** 2
        theta[:, place[:count]] = np.log(np.maximum(power, np.exp(FLOOR)))
        return theta

    held, alien = held_rows(data), foreign(data)

    def log_density(x: Float[np.ndarray, "walkers dim"]) -> Float[np.ndarray, " walkers"]:
        with np.errstate(all="ignore"):
            x = np.clip(x, -300, 300)
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
            value += np.sum(np.log((power + deviation) / (power + scale**2)), axis=1)
            value += np.sum(np.log(np.abs(np.sinh(2 * x[:, :count]))), axis=1)
            # Uniform in the logarithm between the bounds: the slope of the logistic function.
            for index in place[count:]:
                if index not in sizes and not (kinds.shaping in ("bump", FLAT) and index == TERMS):
                    u = theta[:, index]
                    value += -np.abs(u) - 2 * np.log1p(np.exp(-np.abs(u)))
            for index in sizes:
                value = np.where(theta[:, index] < top[index] + _SMALLEST, -np.inf, value)
        return np.where(np.isfinite(value), value, -np.inf)

    rng = np.random.default_rng(seed)
    start = _starts(model, data, place, count, scale, deviation, rng)
    sampler = emcee.EnsembleSampler(
        len(start), place.size, log_density, vectorize=True, moves=_MOVES
    )
    # emcee draws from NumPy's global state unless it is given its own.
    sampler.random_state = np.random.RandomState(seed).get_state()
    burn_in, steps = (part // (4 if quick else 1) for part in (_BURN_IN, _STEPS))
    sampler.run_mcmc(start, burn_in + steps, skip_initial_state_check=True)
    chain = np.asarray(sampler.get_chain(discard=burn_in, thin=_THIN))
    height = np.median(np.asarray(sampler.get_log_prob(discard=burn_in, thin=_THIN)), axis=0)
    # A walker that never left a side maximum says nothing of the posterior.
    chain = chain[:, height > height.max() - _LOST - place.size]
    theta = unpacked(chain.reshape(-1, place.size))
    power = np.where(terms, np.exp(theta[:, :TERMS]), 0.0)
    return Draws(power, theta)


def _deviations(model: Model, data: Data) -> Float[np.ndarray, " terms"]:
    """Standard deviations of the powers, the effects held; as `identify._posterior.coordinates`."""
    every = parts(model.theta[None], model.kinds, data, held_rows(data))
    power = np.where(np.asarray(data.terms), np.exp(model.theta[:TERMS]), 0.0)
    relative = every[0][0] / summed(power[None], every, foreign(data))[0]
    information = (relative * np.asarray(data.bins.shape)) @ relative.T
    unit = np.sqrt(np.diag(information))
    correlation = information / unit / unit[:, None] + 1e-6 * np.eye(TERMS)
    return np.sqrt(np.diag(np.linalg.inv(correlation))) / unit


def _starts(model, data, place, count, scale, deviation, rng) -> Float[np.ndarray, "walkers dim"]:
    walkers = max(_WALKERS, 2 * place.size + 2 + place.size % 2)
    power = np.exp(model.theta[place[:count]])
    scattered = np.abs(power + deviation * rng.standard_normal((walkers, count)))
    x = np.arcsinh(np.sqrt(scattered) / scale)
    effects = model.theta[place[count:]] + _scatter(model, data, place, rng, walkers)[:, count:]
    return np.concatenate([x, effects], axis=1)


def _scatter(model, data, place, rng, walkers) -> Float[np.ndarray, "walkers dim"]:
    """Steps about the best as wide as the information there allows, half of them."""
    slope = log_slopes(model.theta[None], model.kinds, data)[0][:, place]
    information = (slope * np.asarray(data.bins.shape)[:, None]).T @ slope
    values, vectors = np.linalg.eigh(information)
    width = 0.5 / np.sqrt(np.maximum(values, 4.0))
    return (rng.standard_normal((walkers, place.size)) * width) @ vectors.T
