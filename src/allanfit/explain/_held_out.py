"""Is the better model better on data that it was not fitted to?

The two halves of the ordinates, neighbours dealt out in pairs, are two independent records: what is
fitted to one is scored on the other. A course in time may show in few of them, even in one: so
neighbours are turned into one another first, by a rotation that leaves independent ordinates of
one variance what they are and gives each half its share of every course. Where that cannot be, at
the lowest frequencies, each amplitude is split in two by noise of its own variance, y + e and
y - e, which are independent and have the same mean (data fission: Rasines and Young 2023,
Biometrika 110:597); the gain is then understated, since each has twice the noise.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.linalg import eigh, hadamard

from .courses._sums import Moved
from .spectrum._model import Model, best, five_terms, mean_density
from .spectrum._ordinates import Bins, Ordinates, binned
from .spectrum._structure import TERMS, Data
from .values._held_out import Gain

# Neighbours that are rotated lie within such a part of their frequency, and are at most so many.
_ALIKE = 0.1
_MOST_ROTATED = 32
# The least share of the information about courses that each half must hold, and what is none.
_LEAST_SHARE, _FAINT = 0.2, 1e-6
# Ordinates that are worked on together.
_AT_A_TIME = 2**18


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
    moved: Sequence[Moved],
    edges: Float[np.ndarray, " edges"],
    model: Model,
    data: Data,
    plain: Data,
    variance: Float[np.ndarray, " ordinates"],
    seed: int,
) -> HeldOut:
    """Score five terms and the model named on what neither was fitted to.

    `spectrum` holds all ordinates, `moved` the amplitudes that each course puts there, `data` and
    `plain` what is known of the samples with and without what was found out.
    """
    columns = _side_by_side(spectrum.amplitude, moved)
    if moved:
        _turn(columns, variance, seed)
        spectrum = spectrum._replace(amplitude=columns[:, 0].copy())
    weight = _weight(spectrum, variance)
    halves = [_products(columns, weight * (spectrum.fold == fold)) for fold in (0, 1)]
    if moved:
        share = _share(*(half[1:, 1:] for half in halves))
        if np.any(np.abs(share - 0.5) > 0.5 - _LEAST_SHARE):
            return _fission(spectrum, columns, edges, model, data, plain, variance, seed)
    parts = [
        _fold(spectrum, columns, _sizes(halves[1 - fold]), edges, model, data, plain, fold)
        for fold in (0, 1)
    ]
    before, after = (sum(part[i] for part in parts) for i in range(2))
    return HeldOut(float(before), float(after), float(np.sqrt(sum(part[2] for part in parts))))


def _side_by_side(
    own: Float[np.ndarray, " ordinates"], moved: Sequence[Moved]
) -> Float[np.ndarray, "ordinates columns"]:
    """The record's own amplitudes, and those that courses move, which need not reach all."""
    columns = np.zeros((own.size, 1 + sum(each.shape[1] for each in moved)))
    columns[:, 0], at = own, 1
    for each in moved:
        columns[: len(each), at : at + each.shape[1]] = each
        at += each.shape[1]
    return columns


def _turn(
    columns: Float[np.ndarray, "ordinates columns"],
    variance: Float[np.ndarray, " ordinates"],
    seed: int,
) -> None:
    """Turn amplitudes of nearly one frequency into one another, in place."""
    random = np.random.default_rng(seed)
    start = int(np.ceil(2 / _ALIKE))
    while start < len(columns):
        size = min(2 ** int(np.log2(start * _ALIKE)), _MOST_ROTATED)
        # As many blocks of this size as there are before a larger one fits.
        end = 2 * size / _ALIKE if size < _MOST_ROTATED else start + _AT_A_TIME
        blocks = max(1, int((min(end, len(columns)) - start) // size))
        stop = start + blocks * size
        if stop > len(columns):
            break
        deviation = np.sqrt(variance[start:stop, None])
        signs = random.choice([-1.0, 1.0], size=(stop - start, 1))
        white = (columns[start:stop] / deviation * signs).reshape(blocks, size, -1)
        turned = np.einsum("ij,bjc->bic", hadamard(size), white).reshape(stop - start, -1)
        columns[start:stop] = turned * (deviation / np.sqrt(size))
        start = stop


def _share(
    first: Float[np.ndarray, "columns columns"], second: Float[np.ndarray, "columns columns"]
) -> Float[np.ndarray, " columns"]:
    """What part of the information about each combination of courses the first half holds."""
    unit = np.sqrt(np.maximum(np.diag(first) + np.diag(second), 1e-300))
    whole = (first + second) / np.outer(unit, unit)
    # Of what no half knows each is said to know as much.
    faint = _FAINT * np.eye(len(unit))
    return eigh(first / np.outer(unit, unit) + faint / 2, whole + faint, eigvals_only=True)


def _products(
    columns: Float[np.ndarray, "ordinates columns"], weight: Float[np.ndarray, " ordinates"]
) -> Float[np.ndarray, "columns columns"]:
    """Weighted sums of products of amplitudes."""
    products = np.zeros((columns.shape[1], columns.shape[1]))
    for part in _parts(len(columns)):
        products += (columns[part] * weight[part, None]).T @ columns[part]
    return products


def _parts(ordinates: int) -> Iterable[slice]:
    """Few enough that what is made of them is small beside the record."""
    return (slice(at, at + _AT_A_TIME) for at in range(0, ordinates, _AT_A_TIME))


def _sizes(products: Float[np.ndarray, "columns columns"]) -> Float[np.ndarray, " sizes"]:
    """Of the courses, by least squares."""
    return np.linalg.lstsq(products[1:, 1:], products[1:, 0], rcond=None)[0]


def _fold(spectrum: Ordinates, columns, sizes, edges, model: Model, data: Data, plain: Data, fold):
    course = columns[:, 1:] @ sizes
    rest = spectrum.less(course)
    old, new = _fitted(
        binned(spectrum, edges, 1 - fold), binned(rest, edges, 1 - fold), model, data, plain
    )
    bins = binned(spectrum, edges, fold)
    low, high, scatter = _scores(bins, old, new, data, plain)
    if sizes.size:
        high = _scores(binned(rest, edges, fold), old, new, data, plain)[1]
        test = (spectrum.fold == fold) & spectrum.clean(spectrum.frequency)
        scatter = _scatter(spectrum, course, bins, old, new, data, plain, test) ** 2
    return low, high, float(np.sum(scatter))


def _weight(
    spectrum: Ordinates, variance: Float[np.ndarray, " ordinates"]
) -> Float[np.ndarray, " ordinates"]:
    """The inverse of the noise's variance, where an ordinate is the noise's own."""
    return np.where(spectrum.clean(spectrum.frequency), 1 / variance, 0.0)


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


def _fission(spectrum, columns, edges, model: Model, data: Data, plain: Data, variance, seed):
    noise = np.random.default_rng(seed).standard_normal(variance.size) * np.sqrt(variance)
    total_before = total_after = scatter = 0.0
    everywhere = spectrum.clean(spectrum.frequency)
    weight = _weight(spectrum, variance)
    for sign in (1.0, -1.0):
        train = spectrum.less(-sign * noise)
        columns[:, 0] = train.amplitude
        course = columns[:, 1:] @ _sizes(_products(columns, weight))
        old, new = _fitted(
            binned(train, edges), binned(train.less(course), edges), model, data, plain
        )
        test = spectrum.less(sign * noise)
        bins = binned(test, edges)
        low = _scores(bins, old, new, data, plain)[0]
        high = _scores(binned(test.less(course), edges), old, new, data, plain)[1]
        total_before += low / 2
        total_after += high / 2
        scatter = max(scatter, _scatter(test, course, bins, old, new, data, plain, everywhere))
    return HeldOut(float(total_before), float(total_after), float(scatter))


def _scatter(spectrum, course, bins: Bins, old, new, data: Data, plain: Data, scored) -> float:
    """Standard error of the difference when the better model is right."""
    before = mean_density(old, plain._replace(bins=bins))
    after = mean_density(new, data._replace(bins=bins))
    used, frequency = bins.used, bins.frequency
    total = 0.0
    for part in _parts(scored.size):
        m0 = np.interp(spectrum.frequency[part], frequency[used], before[used])
        m1 = np.interp(spectrum.frequency[part], frequency[used], after[used])
        # Half of z^2 (m1/m0 - 1), and of the product of the course with the noise.
        each = (m1 / m0 - 1) ** 2 / 2 + course[part] ** 2 * m1 / m0**2
        total += float(np.sum(each[scored[part]]))
    return total**0.5
