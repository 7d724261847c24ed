"""Slow noise that two lags in a row leave, beside white noise: neither is a filter's."""

import numpy as np
import pytest
from scipy.signal import lfilter

import allanfit

RATE_HZ = 50.0
N = 0.004


def behind_two_lags(
    first_s: float, second_s: float, sigma: float, seed: int, samples: int = 40_000
) -> np.ndarray:
    """White noise of `N` on noise of a standard deviation that has passed two first-order lags."""
    rng = np.random.default_rng(seed)
    slow = rng.standard_normal(samples + 2_000)
    for time in (first_s, second_s):
        kept = np.exp(-1 / (time * RATE_HZ))
        slow = lfilter([1 - kept], [1, -kept], slow)
    slow = slow[2_000:]
    return N * np.sqrt(RATE_HZ) * rng.standard_normal(samples) + sigma * slow / slow.std()


@pytest.mark.parametrize(
    ("first_s", "second_s", "sigma"), [(0.25, 0.25, 0.012), (0.4, 0.15, 0.02)], ids=str
)
def test_noise_behind_two_lags_is_no_filter_and_n_is_the_white_noise(first_s, second_s, sigma):
    """It was a filter that let little of all noise through, and N 3 to 8 times too large."""
    values = behind_two_lags(first_s, second_s, sigma, 1)
    found = allanfit.explain(values, RATE_HZ, unit="deg/s", posterior=False)
    (channel,) = found.to_dict()["channels"]
    (effect,) = channel["effects"]
    assert channel["verdict"] == "explained"
    assert effect["name"] == "resonance"
    assert "two lags" in effect["sentence"]
    told = effect["parameters"]
    assert told["sigma"]["value"] == pytest.approx(sigma, rel=0.05)
    assert told["frequency"]["value"] == pytest.approx(
        1 / (2 * np.pi * np.sqrt(first_s * second_s)), rel=0.15
    )
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(N, rel=0.02)


@pytest.mark.parametrize("quality", [0.7, 1.0])
def test_a_quality_below_one_and_a_half_is_told(quality):
    """Its interval was [1.50, 1.62] at the bound, with correlated noise beside it."""
    rng = np.random.default_rng(3)
    turn = 2 * np.pi * 0.5 / RATE_HZ
    # Displacement and velocity of an oscillator, step by step, each step in ten parts.
    place, speed, path = 0.0, 0.0, []
    drive = rng.standard_normal((42_000, 10))
    for pushes in drive:
        for push in pushes:
            speed += turn / 10 * (-place - speed / quality) + push * np.sqrt(turn / 10)
            place += turn / 10 * speed
        path.append(place)
    swing = np.array(path[2_000:])
    values = N * np.sqrt(RATE_HZ) * rng.standard_normal(swing.size) + 0.03 * swing / swing.std()
    found = allanfit.explain(values, RATE_HZ, unit="deg/s", posterior=False)
    (channel,) = found.to_dict()["channels"]
    (effect,) = channel["effects"]
    assert effect["name"] == "resonance"
    assert effect["parameters"]["quality_factor"]["value"] == pytest.approx(quality, rel=0.08)
    assert effect["parameters"]["frequency"]["value"] == pytest.approx(0.5, rel=0.05)
    assert channel["coefficients_after"]["N"]["value"] == pytest.approx(N, rel=0.02)
