"""Is the better model better on data that it was not fitted to?

Without courses in time the two halves of the ordinates, neighbours dealt out in pairs, are two
independent records: what is fitted to one is scored on the other. With courses each amplitude is
split in two by noise of its own variance, y + e and y - e, which are independent and have the same
mean (data fission: Rasines and Young 2023, Biometrika 110:597), for a course shows in all of them.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ._ordinates import Bins, Ordinates, binned
from ._search import Model, best, five_terms, mean_density
from ._structure import TERMS, Data


class HeldOut(NamedTuple):
    """Log predictive density [nats] of ordinates that were not fitted."""

    before: float
    after: float
    standard_error: float

    @property
    def difference(self) -> float:
        """What the better model gains."""
        return self.after - self.before


def held_out(
    spectrum: Ordinates,
    left: Ordinates,
    moved: Float[np.ndarray, "ordinates columns"],
    edges: Float[np.ndarray, " edges"],
    model: Model,
    data: Data,
    plain: Data,
    variance: Float[np.ndarray, " ordinates"],
    seed: int,
) -> HeldOut:
    """Score five terms and the model named on what neither was fitted to.

    `spectrum` holds all ordinates, `left` those less the courses of amplitudes `moved`, `data` and
    `plain` what is known of the samples with and without what was found out.
    """
    if moved.shape[1]:
        return _fission(spectrum, moved, edges, model, data, plain, variance, seed)
    parts = [_fold(left, edges, model, data, plain, fold) for fold in (0, 1)]
    before, after = (sum(part[i] for part in parts) for i in range(2))
    each = np.concatenate([part[2] for part in parts])
    return HeldOut(float(before), float(after), float(np.sqrt(np.sum(each))))


def _fold(left: Ordinates, edges, model: Model, data: Data, plain: Data, fold: int):
    train, test = binned(left, edges, 1 - fold), binned(left, edges, fold)
    old, new = _fitted(train, model, data, plain)
    return _scores(test, old, new, model, data, plain)


def _fitted(train: Bins, model: Model, data: Data, plain: Data) -> tuple[Model, Model]:
    known = data._replace(bins=train)
    simple = plain._replace(bins=train)
    old = five_terms(np.exp(model.theta[:TERMS]), simple)
    new = best([(model.kinds, model.theta)], known)[0]
    return old, new


def _scores(test: Bins, old: Model, new: Model, model: Model, data: Data, plain: Data):
    """Log-likelihoods of the bins under both, and the variance of the difference."""
    before = mean_density(old, plain._replace(bins=test))
    after = mean_density(new, data._replace(bins=test))
    shape, density = np.asarray(test.shape), np.asarray(test.density)
    low = -np.sum(shape * (np.log(before) + density / before))
    high = -np.sum(shape * (np.log(after) + density / after))
    return float(low), float(high), shape * (after / before - 1) ** 2


def _fission(spectrum, moved, edges, model: Model, data: Data, plain: Data, variance, seed):
    noise = np.random.default_rng(seed).standard_normal(variance.size) * np.sqrt(variance)
    total_before = total_after = scatter = 0.0
    for sign in (1.0, -1.0):
        train = spectrum.less(-sign * noise)
        test = spectrum.less(sign * noise)
        weighted = moved / variance[:, None]
        sizes = np.linalg.lstsq(weighted.T @ moved, weighted.T @ train.amplitude, rcond=None)[0]
        old, _ = _fitted(binned(train, edges), model, data, plain)
        _, new = _fitted(binned(train.less(moved @ sizes), edges), model, data, plain)
        rest = test.less(moved @ sizes)
        whole, clean = binned(test, edges), binned(rest, edges)
        low = _scores(whole, old, new, model, data, plain)[0]
        high = _scores(clean, old, new, model, data, plain)[1]
        total_before += low / 2
        total_after += high / 2
        scatter = max(scatter, _scatter(test, rest, whole, old, new, data, plain))
    return HeldOut(float(total_before), float(total_after), float(scatter))


def _scatter(test, rest, bins: Bins, old, new, data: Data, plain: Data) -> float:
    """Standard error of the difference when the better model is right."""
    before = mean_density(old, plain._replace(bins=bins))
    after = mean_density(new, data._replace(bins=bins))
    used, frequency = bins.used, bins.frequency
    m0 = np.interp(test.frequency, frequency[used], before[used])
    m1 = np.interp(test.frequency, frequency[used], after[used])
    course = test.amplitude - rest.amplitude
    # Half of z^2 (m1/m0 - 1), and of the product of the course with the noise.
    return float(np.sqrt(np.sum((m1 / m0 - 1) ** 2 / 2 + course**2 * m1 / m0**2)))
