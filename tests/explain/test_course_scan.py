"""Courses in time: where they begin and end."""

import numpy as np

from allanfit.explain._course_scan import sharpened
from allanfit.explain._ordinates import ordinates


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
    found = sharpened(roughly, 1024, values, spectrum, np.full(spectrum.frequency.size, 2.0))
    edges = np.flatnonzero(np.diff(found)) + 1
    np.testing.assert_allclose(edges, np.ravel(times), atol=40)
