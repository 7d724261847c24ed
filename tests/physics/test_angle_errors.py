"""Errors of an angle in wide codes, against angles that are rounded."""

import numpy as np
import pytest
from scipy.signal import welch

from allanfit.physics import AngleCodes

SAMPLES = 1_000_000


def errors(move: float, rate: float, seed: int) -> np.ndarray:
    """Of a walk that is rounded to whole codes, in units of their rms when they are uniform."""
    rng = np.random.default_rng(seed)
    angle = rng.random() + np.cumsum(rate + move * rng.standard_normal(SAMPLES))
    return (np.round(angle) - angle) * np.sqrt(12)


@pytest.mark.parametrize(
    ("move", "rate"), [(0.12, 0.0), (0.2, 0.1), (0.35, 0.3), (0.6, 0.0)], ids=str
)
def test_errors_are_as_alike_as_those_of_a_rounded_walk(move, rate):
    error = errors(move, rate, 1)
    lags = np.arange(12)
    found = [np.mean(error[: SAMPLES - lag] * error[lag:]) for lag in lags]
    # A correlation over some dozens of samples at most: known to better than 1 %.
    np.testing.assert_allclose(AngleCodes(move, (rate,)).correlation(lags), found, atol=0.012)


@pytest.mark.parametrize(("move", "rate"), [(0.12, 0.02), (0.2, 0.1), (0.35, 0.3)], ids=str)
def test_their_density_is_that_of_a_rounded_walk(move, rate):
    frequency, density = welch(errors(move, rate, 2), nperseg=256, detrend=False)
    expected = AngleCodes(move, (rate,)).density_ratio(frequency)
    # White errors have one everywhere, two in one-sided densities; 7800 half-overlapping segments.
    inside = slice(2, -1)
    np.testing.assert_allclose(density[inside] / 2 / expected[inside], 1, atol=0.08)


def test_correlation_and_density_are_a_fourier_pair():
    codes = AngleCodes(0.15, (0.05, 0.2))
    lags = np.arange(-200, 201)
    frequency = np.linspace(0, 0.5, 33)
    transform = np.cos(2 * np.pi * frequency[:, None] * lags) @ codes.correlation(abs(lags))
    np.testing.assert_allclose(codes.density_ratio(frequency), transform, rtol=1e-6, atol=2e-3)


def test_an_angle_through_whole_codes_has_white_errors():
    codes = AngleCodes(1.0, (0.0,))
    np.testing.assert_allclose(codes.density_ratio(np.linspace(0, 0.5, 9)), 1, atol=1e-4)
    np.testing.assert_allclose(codes.correlation(np.arange(3)), [1, 0, 0], atol=1e-4)
