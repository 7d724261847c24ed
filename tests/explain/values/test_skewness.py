"""Noise that leans to one side is no noise with spikes."""

import numpy as np
import pytest
from scipy.stats import gamma

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain.values._skewness import leans, skewness

RATE, SAMPLES = 50.0, 30_000


def test_a_curved_characteristic_leans_by_as_much_as_it_curves():
    """For y = x + a (x^2 - 1) of n normal values, by quadrature: 1.185 a sqrt(n) errors."""
    curved = 0.02
    rng = np.random.default_rng(2)
    found = []
    for _ in range(200):
        x = rng.standard_normal(10_000)
        found.append(skewness(x + curved * (x**2 - 1)))
    expected = 1.185 * curved * 100
    assert np.mean(found) == pytest.approx(expected, abs=4 / np.sqrt(len(found)))
    assert np.std(found) == pytest.approx(1, abs=4 / np.sqrt(2 * len(found)))
    assert skewness(-x - curved * (x**2 - 1)) == pytest.approx(-found[-1], rel=1e-9)


@pytest.mark.parametrize("shape", ["normal", "uniform", "long tails", "lattice"])
def test_symmetric_noise_leans_as_seldom_as_it_says(shape):
    """Of 1000 chances below .05, 50 are expected with a standard deviation of 7."""
    rng = np.random.default_rng(3)
    draw = {
        "normal": rng.standard_normal,
        "uniform": lambda size: rng.uniform(-1, 1, size) + 0.5 * rng.standard_normal(size),
        "long tails": lambda size: rng.standard_t(3, size),
        # Codes of half a deviation, of which none is at the middle.
        "lattice": lambda size: np.round(2 * rng.standard_normal(size) + 0.3),
    }[shape]
    chances = [leans(draw(5000), 0.0) for _ in range(1000)]
    assert 25 < np.sum(np.exp(chances) < 0.05) < 75


@pytest.mark.parametrize("share", [0.005, 0.02, 0.07])
def test_spikes_of_one_side_are_no_leaning(share):
    rng = np.random.default_rng(4)
    values = rng.standard_normal(200_000)
    values[rng.random(values.size) < share] += 6.0
    assert leans(values, share) > np.log(1e-3)
    assert leans(gamma(16).rvs(200_000, random_state=rng), share) < np.log(1e-3)


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
