"""Chances of courses, against simulation."""

import numpy as np
import pytest
from scipy.stats import binom, f

from allanfit.explain._chance import course_log_chance, course_score


@pytest.mark.parametrize(("known", "sizes"), [(8, 1), (8, 2), (40, 1)])
def test_with_few_ordinates_of_one_unknown_variance_the_chance_is_the_f_test(known, sizes):
    for gain in (0.5, 5.0, 20.0, 80.0):
        explained = np.expm1(gain / known)
        expected = f.logsf(explained * (known - sizes) / sizes, sizes, known - sizes)
        assert course_log_chance(gain, sizes, float(known)) == pytest.approx(expected, rel=1e-6)


def test_with_known_variance_the_chance_is_chi_square():
    for gain in (1.0, 30.0, 400.0, 5000.0):
        # Two degrees of freedom: exp(-x/2).
        assert course_log_chance(gain, 2, 1e9) == pytest.approx(-gain / 2, rel=1e-5)


def test_a_scan_along_a_path_holds_its_chance():
    """Steps at 200 places in white noise: the bound is met, and not far above.

    False alarm below 1e-3 by the binomial, for shares at the bound.
    """
    rng, places, records = np.random.default_rng(4), 200, 4000
    step = np.triu(np.ones((places - 1, places)), 1)
    step -= step.mean(axis=1, keepdims=True)
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    length = np.arccos(np.sum(step[1:] * step[:-1], axis=1)).sum()
    gains = ((rng.standard_normal((records, places)) @ step.T) ** 2).max(axis=1)
    logs = np.array([course_log_chance(gain, 1, 1e9, length=length) for gain in gains])
    for level in (0.1, 0.02):
        below = np.sum(logs < np.log(level))
        assert binom.sf(below - 1, records, level) > 1e-3
        assert binom.cdf(below, records, 0.3 * level) > 1e-3


def test_more_places_cost_more():
    scores = [course_score(30.0, 1, places=n) for n in (1.0, 10.0, 1000.0)]
    assert np.all(np.diff(scores) < 0)
    assert course_score(30.0, 1) > course_score(30.0, 1, length=50.0)
