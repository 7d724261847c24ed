"""Is the better model better on data that it was not fitted to?

The two halves of the ordinates, neighbours dealt out in pairs, are two independent records: what is
fitted to one is scored on the other. A course in time may show in few of them, even in one: so
neighbours are turned into one another first, by a rotation that leaves independent ordinates of
one variance what they are and gives each half its share of every course. Where that cannot be, at
the lowest frequencies, each amplitude is split in two by noise of its own variance, y + e and
y - e, which are independent and have the same mean (data fission: Rasines and Young 2023,
Biometrika 110:597); the gain is then understated, since each has twice the noise.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import hadamard

from ._held_out_values import Gain
from ._ordinates import Bins, Ordinates, binned
from ._search import Model, best, five_terms, mean_density
from ._structure import TERMS, Data

# Neighbours that are rotated lie within such a part of their frequency, and are at most so many.
_ALIKE = 0.1
_MOST_ROTATED = 32
# The least share of a course that each half must hold.
_LEAST_SHARE = 0.2


class HeldOut(NamedTuple):
    """Log predictive density [nats] of ordinates that were not fitted."""

    before: float
    after: float
    standard_error: float

    @property
    def difference(self) -> float:
        """What the better model gains."""
        return self.after - self.before

    def joined(self, gains: Iterable[Gain]) -> "HeldOut":
        """With what the values of samples gain, given their spectrum."""
        gains = list(gains)
        after = self.after + sum(gain.nats for gain in gains)
        variance = self.standard_error**2 + sum(gain.variance for gain in gains)
        return HeldOut(self.before, after, variance**0.5)


def held_out(
    spectrum: Ordinates,
    moved: Float[np.ndarray, "ordinates columns"],
    edges: Float[np.ndarray, " edges"],
    model: Model,
    data: Data,
    plain: Data,
    variance: Float[np.ndarray, " ordinates"],
    seed: int,
) -> HeldOut:
    """Score five terms and the model named on what neither was fitted to.

    `spectrum` holds all ordinates, `moved` the amplitudes that courses put there, `data` and
    `plain` what is known of the samples with and without what was found out.
    """
    if moved.shape[1]:
        turned = _rotated(np.column_stack([spectrum.amplitude, moved]), variance, seed)
        spectrum, moved = spectrum._replace(amplitude=turned[:, 0]), turned[:, 1:]
        energy = moved * _weighted(spectrum, moved, variance)
        share = energy[spectrum.fold == 0].sum(axis=0) / energy.sum(axis=0)
        if np.any(np.abs(share - 0.5) > 0.5 - _LEAST_SHARE):
            return _fission(spectrum, moved, edges, model, data, plain, variance, seed)
    parts = [_fold(spectrum, moved, edges, model, data, plain, variance, fold) for fold in (0, 1)]
    before, after = (sum(part[i] for part in parts) for i in range(2))
    return HeldOut(float(before), float(after), float(np.sqrt(sum(part[2] for part in parts))))


def _rotated(
    columns: Float[np.ndarray, "ordinates columns"],
    variance: Float[np.ndarray, " ordinates"],
    seed: int,
) -> Float[np.ndarray, "ordinates columns"]:
    """Amplitudes with neighbours of nearly one frequency turned into one another."""
    deviation = np.sqrt(variance)[:, None]
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=len(variance))
    white = columns / deviation * signs[:, None]
    start = int(np.ceil(2 / _ALIKE))
    while start < len(white):
        size = min(2 ** int(np.log2(start * _ALIKE)), _MOST_ROTATED)
        # As many blocks of this size as there are before a larger one fits.
        end = 2 * size / _ALIKE if size < _MOST_ROTATED else len(white)
        blocks = max(1, int((min(end, len(white)) - start) // size))
        stop = start + blocks * size
        if stop > len(white):
            break
        part = white[start:stop].reshape(blocks, size, -1)
        white[start:stop] = np.einsum("ij,bjc->bic", hadamard(size), part).reshape(
            blocks * size, -1
        ) / np.sqrt(size)
        start = stop
    return white * deviation


def _fold(spectrum: Ordinates, moved, edges, model: Model, data: Data, plain: Data, variance, fold):
    train = spectrum.fold != fold
    test = (spectrum.fold == fold) & spectrum.clean(spectrum.frequency)
    weighted = _weighted(spectrum, moved, variance)[train]
    sizes = np.linalg.lstsq(
        weighted.T @ moved[train], weighted.T @ spectrum.amplitude[train], rcond=None
    )[0]
    rest = spectrum.less(moved @ sizes)
    whole, clean = (binned(each, edges, 1 - fold) for each in (spectrum, rest))
    old, new = _fitted(whole, clean, model, data, plain)
    bins = binned(spectrum, edges, fold)
    low, high, scatter = _scores(bins, old, new, data, plain)
    if moved.shape[1]:
        high = _scores(binned(rest, edges, fold), old, new, data, plain)[1]
        scatter = _scatter(spectrum, rest, bins, old, new, data, plain, test) ** 2
    return low, high, float(np.sum(scatter))


def _weighted(spectrum: Ordinates, moved, variance) -> Float[np.ndarray, "ordinates columns"]:
    """By the inverse of the noise's variance, where an ordinate is the noise's own."""
    return np.where(spectrum.clean(spectrum.frequency), 1 / variance, 0.0)[:, None] * moved


def _fitted(
    plain_bins: Bins, bins: Bins, model: Model, data: Data, plain: Data
) -> tuple[Model, Model]:
    """Five terms fitted to ordinates, and the model to those without the courses."""
    old = five_terms(np.exp(model.theta[:TERMS]), plain._replace(bins=plain_bins))
    return old, best([(model.kinds, model.theta)], data._replace(bins=bins))[0]


def _scores(test: Bins, old: Model, new: Model, data: Data, plain: Data):
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
    everywhere = spectrum.clean(spectrum.frequency)
    for sign in (1.0, -1.0):
        train = spectrum.less(-sign * noise)
        test = spectrum.less(sign * noise)
        weighted = _weighted(spectrum, moved, variance)
        sizes = np.linalg.lstsq(weighted.T @ moved, weighted.T @ train.amplitude, rcond=None)[0]
        whole, clean = (binned(each, edges) for each in (train, train.less(moved @ sizes)))
        old, new = _fitted(whole, clean, model, data, plain)
        rest = test.less(moved @ sizes)
        whole, clean = binned(test, edges), binned(rest, edges)
        low = _scores(whole, old, new, data, plain)[0]
        high = _scores(clean, old, new, data, plain)[1]
        total_before += low / 2
        total_after += high / 2
        scatter = max(scatter, _scatter(test, rest, whole, old, new, data, plain, everywhere))
    return HeldOut(float(total_before), float(total_after), float(scatter))


def _scatter(test, rest, bins: Bins, old, new, data: Data, plain: Data, scored) -> float:
    """Standard error of the difference when the better model is right."""
    before = mean_density(old, plain._replace(bins=bins))
    after = mean_density(new, data._replace(bins=bins))
    used, frequency = bins.used, bins.frequency
    m0 = np.interp(test.frequency, frequency[used], before[used])
    m1 = np.interp(test.frequency, frequency[used], after[used])
    course = test.amplitude - rest.amplitude
    # Half of z^2 (m1/m0 - 1), and of the product of the course with the noise.
    each = (m1 / m0 - 1) ** 2 / 2 + course**2 * m1 / m0**2
    return float(np.sqrt(np.sum(each[scored])))
