"""Relaxations that stand for flicker: their Allan variance, and how few keep to it."""

import decimal

import numpy as np
import pytest

from allanfit.export import ExportError, fit_relaxations
from allanfit.export._gauss_markov import allan_variance

FLOOR = 2 * np.log(2) / np.pi


def by_summing_the_autocovariance(n, dt, time_s):
    """Definition, in 60 digits: half the mean square of the difference of adjacent means."""
    with decimal.localcontext(prec=60):
        phi = (-decimal.Decimal(dt) / decimal.Decimal(time_s)).exp()
        lags = [(i, j) for i in range(n) for j in range(n)]
        within = sum(phi ** abs(i - j) for i, j in lags)
        between = sum(phi ** abs(i - j - n) for i, j in lags)
        return float((within - between) / n**2)


@pytest.mark.parametrize("n", [1, 2, 7, 25])
@pytest.mark.parametrize("step", [1e-7, 1e-4, 3e-3, 0.05, 1.0, 20.0])
def test_allan_variance_is_that_of_the_definition(n, step):
    found = allan_variance(np.array([float(n)]), 0.01, np.array([0.01 / step]))[0, 0]
    wanted = by_summing_the_autocovariance(n, 0.01, 0.01 / step)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


def test_series_and_closed_form_meet():
    """The switch is at (2 n + 1) dt/T = 0.3; both sides lie on one smooth curve."""
    n = np.array([100.0])
    times = 0.01 * 201 / 0.3 * np.array([1 - 1e-9, 1 + 1e-9])
    below, above = allan_variance(n, 0.01, times)[0]
    assert abs(above / below - 1) < 1e-8


@pytest.mark.parametrize(("decades", "states"), [(1, 2), (2, 2), (3, 3), (4, 4), (6, 5)])
def test_few_states_keep_to_a_flat_line(decades, states):
    dt = 0.01
    band = (4 * dt, 4 * dt * 10.0**decades)
    found = fit_relaxations(lambda n: np.full_like(n, FLOOR), dt, band)
    assert len(found.relaxations) == states
    # Between the points that were fitted too, by the textbook's formula for continuous time,
    # which differs from that of samples by less than 1 % for relaxations longer than 4 samples.
    tau = np.geomspace(20 * dt, band[1], 777)
    variance = sum(each.variance * continuous(tau / each.time_s) for each in found.relaxations)
    error = np.abs(np.sqrt(variance / FLOOR) - 1)
    assert error.max() < 0.06
    assert found.worst_error <= 0.05


def continuous(ratio):
    return 2 / ratio - (3 - 4 * np.exp(-ratio) + np.exp(-2 * ratio)) / ratio**2


def test_a_finer_error_takes_more_states():
    flat = lambda n: np.full_like(n, 1.0)  # noqa: E731  (a target is a function)
    rough = fit_relaxations(flat, 0.01, (0.04, 400.0))
    fine = fit_relaxations(flat, 0.01, (0.04, 400.0), allowed_error=0.01)
    assert len(fine.relaxations) > len(rough.relaxations)
    assert fine.worst_error <= 0.01


@pytest.mark.parametrize("band", [(0.001, 10.0), (5.0, 5.0), (5.0, 1.0), (0.1, float("inf"))])
def test_impossible_bands_are_refused(band):
    with pytest.raises(ExportError, match="band must run from the sampling interval"):
        fit_relaxations(np.ones_like, 0.01, band)
