"""Variances of means and their differences: against spectra, covariances and the Allan variance."""

import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.calibrate._intervals import mixture_intervals, student_intervals
from allanfit.calibrate._means import drift_weights, white_weights
from allanfit.physics import SYMBOLS, standard_model

STARTS, LENGTHS, WEIGHTS = (0.0, 7.0, 15.0), (5.0, 8.0, 6.0), (0.5, 0.5, -1.0)


@pytest.mark.parametrize("symbol", SYMBOLS)
def test_neighbouring_means_differ_by_twice_the_allan_variance(symbol):
    # Q apart: separate recordings share no rounding error at a seam, so 4 of the 6 parts are left.
    length = 40.0
    found = white_weights((length, length), (1.0, -1.0))
    found = found + drift_weights((0.0, length), (length, length), (1.0, -1.0))
    model = standard_model({symbol: 1.0})
    expected = 2 * float(model.allan_variance(jnp.asarray(4000.0), 0.01, "averaged"))
    expected *= 4 / 6 if symbol == "Q" else 1
    assert found[SYMBOLS.index(symbol)] == pytest.approx(expected, rel=1e-6)


def test_flicker_is_the_integral_of_its_density():
    # S(f) = 1/(pi f) through the transfer function of the weighted means.
    frequency = np.geomspace(1e-7, 3e3, 3_000_001)
    response = 0.0
    for start, length, weight in zip(STARTS, LENGTHS, WEIGHTS, strict=True):
        middle = start + length / 2
        response = response + weight * np.sinc(frequency * length) * np.exp(
            -2j * np.pi * frequency * middle
        )
    expected = np.trapezoid(np.abs(response) ** 2 / np.pi, np.log(frequency))
    assert drift_weights(STARTS, LENGTHS, WEIGHTS)[2] == pytest.approx(expected, rel=1e-5)


def test_walk_is_the_double_integral_of_its_covariance():
    # Cov(w(s), w(t)) = min(s, t), by the midpoint rule.
    times, shares = [], []
    for start, length, weight in zip(STARTS, LENGTHS, WEIGHTS, strict=True):
        times.append(start + length * (np.arange(400) + 0.5) / 400)
        shares.append(np.full(400, weight / 400))
    time, share = np.concatenate(times), np.concatenate(shares)
    expected = share @ np.minimum(time[:, None], time) @ share
    found = drift_weights(STARTS, LENGTHS, WEIGHTS)
    assert found[3] == pytest.approx(expected, rel=1e-5)
    # A ramp of one unit a second, by the middles of the stretches.
    assert found[4] == pytest.approx((0.5 * 2.5 + 0.5 * 11.0 - 18.0) ** 2)


def test_a_bias_that_wanders_has_no_variance_of_its_own():
    with pytest.raises(ValueError, match="add up to zero"):
        drift_weights((0.0,), (1.0,), (1.0,))


def test_mixture_of_inverse_chi_squares_is_students_t():
    freedom = 6
    draws = freedom / np.random.default_rng(0).chisquare(freedom, 200_000)
    found, exact = mixture_intervals(1.0, draws), student_intervals(1.0, 1.0, freedom)
    for level in ("0.68", "0.95"):
        # The half-width of 200000 draws has a standard error of about 0.2 %.
        np.testing.assert_allclose(found[level], exact[level], rtol=0.01)


def test_mixture_counts_weights():
    variances = np.array([1.0, 4.0])
    doubled = mixture_intervals(0.0, np.array([1.0, 4.0, 4.0]))
    weighted = mixture_intervals(0.0, variances, np.array([1.0, 2.0]))
    np.testing.assert_allclose(weighted["0.95"], doubled["0.95"], rtol=1e-9)
