"""Noise that leans to one side is no noise with spikes."""

import numpy as np
import pytest
from scipy.stats import gamma

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain._skewness import leans, skewness

RATE, SAMPLES = 50.0, 30_000


def test_skewness_is_that_of_the_quartiles():
    lower, middle, upper = gamma(4).ppf([0.25, 0.5, 0.75])
    expected = (upper + lower - 2 * middle) / (upper - lower)
    values = gamma(4).ppf((np.arange(100_000) + 0.5) / 100_000)
    assert skewness(values) == pytest.approx(expected, rel=1e-3)
    assert skewness(-values) == pytest.approx(-expected, rel=1e-3)


def test_normal_noise_leans_as_seldom_as_it_says():
    """Of 1000 chances below .05, 50 are expected with a standard deviation of 7."""
    rng = np.random.default_rng(3)
    chances = [leans(rng.standard_normal(5000), 0.0, 0.0, 0) for _ in range(1000)]
    assert 25 < np.sum(np.exp(chances) < 0.05) < 75


@pytest.mark.parametrize("share", [0.005, 0.02, 0.07])
def test_spikes_of_one_side_are_no_leaning(share):
    rng = np.random.default_rng(4)
    values = rng.standard_normal(200_000)
    values[rng.random(values.size) < share] += 6.0
    assert leans(values, share, 0.0, 0) > np.log(1e-3)
    assert leans(gamma(16).rvs(200_000, random_state=rng), share, 0.0, 0) < np.log(1e-3)


def test_codes_are_no_leaning():
    rng = np.random.default_rng(5)
    rounded = np.round(rng.standard_normal(200_000) / 0.5 + 0.3) * 0.5
    assert leans(rounded, 0.0, 0.5, 0) > np.log(1e-3)


def test_noise_that_leans_keeps_all_of_its_strength(tmp_path):
    """Gamma noise of shape 4: a mixture of two normal ones takes a tenth of it for spikes."""
    rng = np.random.default_rng(6)
    walk = np.cumsum(rng.standard_normal(SAMPLES)) * 2e-4 * RATE**-0.5
    values = 0.005 * RATE**0.5 * (rng.gamma(4, size=SAMPLES) - 4) / 2 + walk
    path = tmp_path / "gyro.npz"
    np.savez(path, gyro_x=values, rate_hz=RATE, units='{"gyro_x": "deg/s"}')
    found = explain_recording(allanfit.load(path), posterior=False).to_dict()["channels"][0]
    assert found["verdict"] == "unexplained"
    assert "leans to one side" in found["effects"][0]["sentence"]
    assert found["mismatch"][0]["sentence"] == "The noise leans to one side."
    n = found["coefficients_after"]["N"]["value"]
    assert n == pytest.approx(0.005, rel=0.03)
