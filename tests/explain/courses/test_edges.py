"""Loud times: where they begin and end."""

import numpy as np

from allanfit.explain.courses._edges import sharpened
from allanfit.explain.spectrum._ordinates import ordinates


def test_a_shift_begins_and_ends_where_the_mean_says():
    """Of white noise: an edge of height h is known to some 1/h^2 samples."""
    rng, samples = np.random.default_rng(0), 100_000
    times, shift = ((20_300, 41_000), (60_500, 90_010)), 0.5
    inside, roughly = np.zeros(samples, bool), np.zeros(samples, bool)
    for start, stop in times:
        inside[start:stop] = True
        roughly[start - 700 : stop + 500] = True
    values = rng.standard_normal(samples) + shift * inside
    spectrum = ordinates((values,), "point")
    variance = np.full(spectrum.frequency.size, 2.0)
    found = sharpened(roughly, 1024, values, spectrum, variance, np.zeros(samples))
    edges = np.flatnonzero(np.diff(found)) + 1
    np.testing.assert_allclose(edges, np.ravel(times), atol=40)


def test_noise_that_knows_its_edges_is_not_moved_by_the_mean():
    """Twice as strong within, an edge is known to some ten samples; a walk would choose others."""
    rng, samples = np.random.default_rng(0), 100_000
    inside = np.zeros(samples, bool)
    inside[20_300:41_000] = inside[60_500:90_010] = True
    noise = rng.standard_normal(samples) * np.where(inside, np.sqrt(2), 1)
    odds = (noise**2 / 2 - np.log(2)) / 2
    values = noise + 0.02 * np.cumsum(rng.standard_normal(samples))
    spectrum = ordinates((values,), "point")
    variance = 2 * 1.5 + 2 * (0.02 / (2 * np.pi * spectrum.frequency)) ** 2
    by_mean, by_both = (
        sharpened(inside, 2048, values, spectrum, variance, each) for each in (0 * odds, odds)
    )
    assert np.sum(by_mean != inside) > 500
    assert np.sum(by_both != inside) < 200
