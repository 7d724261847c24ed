"""Errors of an angle at the ends of a stretch."""

import numpy as np
import pytest

import allanfit
from allanfit.curves import even_ends

ERROR, SAMPLES, RATE_HZ = 60.0, 8192, 10.0


def drawn(rng):
    """White noise of one beside the differences of errors of an angle, and these."""
    angle = ERROR * rng.standard_normal(SAMPLES + 1)
    return 3 + rng.standard_normal(SAMPLES) + np.diff(angle), angle


def test_they_are_found_and_made_as_large_as_expected():
    """To q n of q^2, the variance of a steady Kalman filter of a walk beneath errors: 60 of 3600.

    The mean rate of 32 memories costs a fifth more. 400 of them: a standard error of 7 %.
    """
    rng, wrong = np.random.default_rng(1), []
    for _ in range(200):
        x, angle = drawn(rng)
        even = even_ends(x, ERROR, 1.0)
        # The first error is there with a minus, the last one with a plus.
        first = angle[0] - (even - x)[0]
        last = angle[-1] + (even - x)[-1]
        for put, true in ((first, angle[0]), (last, angle[-1])):
            # As large as expected, but for what of the error itself is not known.
            wrong.append(put - np.copysign(ERROR, put))
            assert np.sign(put) == np.sign(true) or abs(true) < 5 * ERROR**0.5
        assert np.array_equal(even[1:-1], x[1:-1])
    assert np.mean(np.square(wrong)) == pytest.approx(1.2 * ERROR, rel=0.25)


def test_where_they_are_no_matter_nothing_is_changed():
    x = np.random.default_rng(2).standard_normal(SAMPLES)
    assert even_ends(x, 1.0, 1.0) is x
    assert even_ends(x, 0.0, 1.0) is x


def test_the_drift_of_a_rate_is_no_error():
    rng = np.random.default_rng(4)
    x = np.cumsum(rng.standard_normal(SAMPLES)) + np.diff(rng.standard_normal(SAMPLES + 1))
    assert np.array_equal(even_ends(x, 1.0, 0.0), x)


def test_intervals_of_n_hold_it_where_quantization_rules():
    """Four or more of 12 miss once in 400. Two numbers for the ends make N wrong by factors.

    In a batch as alone, and beside a sensor whose ends are no matter.
    """
    rng = np.random.default_rng(3)
    x = np.stack([drawn(rng)[0] for _ in range(12)] + [rng.standard_normal(SAMPLES)])
    fits = allanfit.fit_many(x, RATE_HZ)
    low, high = np.asarray(fits.intervals["N"]).T
    assert np.sum((low > RATE_HZ**-0.5) | (high < RATE_HZ**-0.5)) < 4
    for i in (0, 12):
        alone = allanfit.fit(x[i], RATE_HZ)
        np.testing.assert_allclose(fits.least_squares["N"][i], alone.least_squares["N"], rtol=1e-6)
        batch, single = (each.estimate.statistics.allan for each in (fits, alone))
        np.testing.assert_allclose(batch[i], single, rtol=1e-9)
        np.testing.assert_allclose(single, allanfit.allan_variance(x[i], RATE_HZ), rtol=1e-9)
