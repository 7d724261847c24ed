"""Sums over bins give what passes over all ordinates give."""

import numpy as np
import pytest

from allanfit.explain.courses import _course
from allanfit.explain.courses._sums import Summing
from allanfit.explain.spectrum._model import five_terms
from allanfit.explain.spectrum._ordinates import bin_edges, binned, less_bands, ordinates
from allanfit.explain.spectrum._structure import Data

SAMPLES = 30_000
WHOLE, CUT = ((0, SAMPLES),), ((0, 9_000), (9_500, 9_560), (10_000, SAMPLES))
# Holes in the middle and at the end, as below the leakage of a steep filter.
BANDS = [(0.2, 0.22), (0.47, 0.5)]


def record(pieces, bands=()):
    rng = np.random.default_rng(5)
    values = rng.standard_normal(SAMPLES) + 0.01 * np.cumsum(rng.standard_normal(SAMPLES))
    spectrum = ordinates(tuple(values[a:b] for a, b in pieces), "point")
    spectrum = less_bands(spectrum, list(bands)) if bands else spectrum
    variance = 1 + 1e-4 / (2 * np.pi * spectrum.frequency) ** 2
    edges = bin_edges(spectrum.longest, ((0.1, 1e-3),))
    return spectrum, edges, variance, Summing(spectrum, edges, variance)


def courses(pieces, top=0.5):
    made = [
        _course.oscillation(0.1003, np.arange(float(SAMPLES))),
        _course.step(21_111, SAMPLES),
        _course.warm_up(2_000.0, SAMPLES),
    ]
    return [_course.moved_by(course, pieces, top) for course in made]


@pytest.mark.parametrize("bands", [(), BANDS], ids=["all", "holes"])
@pytest.mark.parametrize("pieces", [WHOLE, CUT], ids=["whole", "cut"])
def test_sums_are_those_of_all_ordinates(pieces, bands):
    spectrum, edges, variance, sums = record(pieces, bands)
    every = courses(pieces)
    products = sums.of(every)
    sizes = np.array([0.3, -0.2, 0.05, 2.0])
    left = binned(spectrum.less(np.hstack(every) @ sizes), edges)
    np.testing.assert_allclose(products.less(sizes) / sums.count, left.density[left.used])
    # Generalised least squares with the variance of each ordinate, if the model's is the mean.
    seen = spectrum.clean(spectrum.frequency)
    design = np.column_stack([spectrum.amplitude, *every])[seen]
    expected = design.T @ (design / variance[seen, None])
    of_bins = binned(spectrum._replace(amplitude=np.sqrt(variance)), edges)
    found = np.tensordot(1 / of_bins.density[of_bins.used], products.weighted, 1)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10 * expected.max())


@pytest.mark.parametrize("pieces", [WHOLE, CUT], ids=["whole", "cut"])
def test_slow_courses_need_no_more_than_low_ordinates(pieces):
    """Within 4 % at the last of them, a thousandth of the largest, and like these before."""
    top = 0.01
    for full, low in zip(courses(pieces)[1:], courses(pieces, top)[1:], strict=True):
        frequency = record(pieces)[0].frequency[: len(low)]
        assert frequency[-1] <= top
        assert record(pieces)[0].frequency[len(low)] > top
        error = np.abs(low - full[: len(low)])
        assert np.max(error / np.abs(full).max()) < 1e-3
        early = frequency < top / 8
        assert np.linalg.norm(error[early]) < 2e-3 * np.linalg.norm(full[: len(low)][early])


def test_sizes_may_be_asked_for_in_bins_that_are_new():
    """As when they are made finer about a peak; by least squares over all ordinates."""
    spectrum, edges, variance, sums = record(WHOLE)
    before = binned(spectrum, bin_edges(spectrum.longest))
    data = Data(before, float(SAMPLES), 0.0, 1.0, np.ones(4, bool))
    model = five_terms(np.array([0.0, 1.0, 0.0, 1e-4]), data)
    (line,) = courses(WHOLE)[:1]
    sized = _course.size_up(sums.of([line]), sums, model, data)
    white = np.sqrt(variance)
    expected = np.linalg.lstsq(line / white[:, None], spectrum.amplitude / white, rcond=None)[0]
    # A standard deviation is 0.008.
    np.testing.assert_allclose(sized.sizes, expected, atol=4e-4)
    assert binned(spectrum, edges).density.size == sized.data.bins.density.size


def test_what_is_beyond_the_top_of_slow_courses_is_a_part_in_a_hundred_thousand():
    _, _, variance, sums = record(WHOLE)
    (step,) = [moved[:, 0] for moved in courses(WHOLE)[1:2]]
    told = np.cumsum(step**2 / variance) / np.sum(step**2 / variance)
    spectrum = record(WHOLE)[0]
    at = np.searchsorted(spectrum.frequency, sums.slow_top)
    assert 0 < 1 - told[min(at, told.size - 2)] < 1e-4
