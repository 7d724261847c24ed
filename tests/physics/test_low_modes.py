"""What the ends of a record do to each noise, against its whole covariance matrix."""

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.fft
from scipy.linalg import toeplitz

from allanfit.physics import SYMBOLS, standard_model

SAMPLES = 512
LAG = np.arange(SAMPLES, dtype=float)


def squares_times_logarithm(k):
    return k**2 * np.log(np.maximum(np.abs(k), 1))


def covariance(symbol, sampling):
    """Of 512 samples of a unit coefficient and dt = 1, up to what a constant offset adds.

    A flicker has a generalised covariance: minus half its structure function D. For Kasdin's
    D(k) = (4/pi) (1 + 1/3 + ... + 1/(2k - 1)); for the averaged one the second difference of
    (1/2 pi) k^2 ln k, which is the mean of (1/pi) ln|t| over two intervals.
    """
    common = np.minimum.outer(LAG, LAG)
    if symbol == "Q":
        return toeplitz(np.concatenate([[2.0, -1.0], np.zeros(SAMPLES - 2)]))
    if symbol == "N":
        return np.eye(SAMPLES)
    if symbol == "K":
        # The mean of a Wiener process over [k, k + 1] has variance k + 1/3.
        return common if sampling == "point" else common + 0.5 - np.eye(SAMPLES) / 6
    if sampling == "point":
        return toeplitz(-2 / np.pi * np.cumsum(np.append(0, 1 / (2 * LAG[1:] - 1))))
    second = np.diff(squares_times_logarithm(np.arange(-1.0, SAMPLES + 1)), 2)
    return toeplitz(-second / (2 * np.pi))


@pytest.mark.parametrize("sampling", ["point", "averaged"])
@pytest.mark.parametrize(
    ("symbol", "tolerance"), [("Q", 1e-10), ("N", 1e-10), ("B", 6e-4), ("K", 1e-9)]
)
def test_expected_ordinates_are_those_of_the_covariance(symbol, tolerance, sampling):
    half = scipy.fft.dct(covariance(symbol, sampling), norm="ortho", axis=0)
    exact = 2 * np.diag(scipy.fft.dct(half, norm="ortho", axis=1))[1:]
    order = np.arange(1.0, SAMPLES)
    noise = standard_model({symbol: 1.0}).terms[SYMBOLS.index(symbol)]
    density = noise.density(jnp.asarray(order / (2 * SAMPLES)), 1.0, sampling)
    ratio = noise.low_mode_ratio(jnp.asarray(order), SAMPLES)
    np.testing.assert_allclose(density * ratio, exact, rtol=tolerance)


def test_the_first_ordinate_of_flicker_holds_three_quarters():
    """(2/pi) (Si(pi) - 2/pi), and Si(pi) = 1.8519370519824662 (the Wilbraham-Gibbs constant)."""
    noise = standard_model({"B": 1.0}).terms[SYMBOLS.index("B")]
    expected = 2 / np.pi * (1.8519370519824662 - 2 / np.pi)
    found = float(noise.low_mode_ratio(jnp.asarray(1.0), 10_000))
    assert found == pytest.approx(expected, rel=1e-8)
