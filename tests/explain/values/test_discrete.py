"""Spikes and loud times among values that are held or rounded coarsely."""

import numpy as np
import pytest
from scipy.stats import norm

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain.values._discrete import _own_change, as_held, replaced

RATE, SAMPLES, N = 100.0, 60_000, 0.005
SIGMA = N * RATE**0.5


def _noise(rng):
    return SIGMA * rng.standard_normal(SAMPLES) + np.cumsum(2e-5 * rng.standard_normal(SAMPLES))


def _spikes(values, rng):
    hit = rng.random(SAMPLES) < 0.002
    return values + hit * 20 * SIGMA * rng.standard_normal(SAMPLES)


def _louder(values, rng):
    """Half as loud again for a quarter of the time."""
    more = np.zeros(SAMPLES)
    more[18_000:33_000] = np.sqrt(1.5**2 - 1) * SIGMA
    return values + more * rng.standard_normal(SAMPLES)


def _hold(values, rng):
    fresh = rng.random(SAMPLES) > 0.15
    fresh[0] = True
    return values[np.maximum.accumulate(np.where(fresh, np.arange(SAMPLES), 0))]


def _round(values, _rng):
    return np.round(values / (2 * SIGMA)) * 2 * SIGMA


def _explained(values, path):
    np.savez(path, gyro_x=values, rate_hz=RATE, units='{"gyro_x": "deg/s"}')
    return explain_recording(allanfit.load(path), posterior=False).to_dict()["channels"][0]


@pytest.mark.parametrize("written", [_hold, _round])
def test_spikes_are_told_and_leave_n_alone(written, tmp_path):
    """Left in, they make N a third too large: .002 of 400 variances are .8."""
    rng = np.random.default_rng(21)
    found = _explained(written(_spikes(_noise(rng), rng), rng), tmp_path / "gyro.npz")
    named = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert "outliers" in named
    assert not {"disturbance", "resonance", "variance_modulation"} & named.keys()
    assert named["outliers"]["fraction"]["value"] == pytest.approx(0.002, rel=0.35)
    assert named["outliers"]["amplitude"]["value"] == pytest.approx(20 * SIGMA, rel=0.2)
    assert found["coefficients_after"]["N"]["value"] == pytest.approx(N, rel=0.02)


@pytest.mark.parametrize("written", [_hold, _round])
def test_loud_times_are_told_with_their_ratio(written, tmp_path):
    rng = np.random.default_rng(22)
    found = _explained(written(_louder(_noise(rng), rng), rng), tmp_path / "gyro.npz")
    named = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert named["variance_modulation"]["ratio"]["value"] == pytest.approx(1.5, rel=0.05)
    assert not {"disturbance", "resonance", "outliers"} & named.keys()
    assert found["coefficients_after"]["N"]["value"] == pytest.approx(N, rel=0.02)


@pytest.mark.parametrize("written", [_hold, _round])
def test_even_noise_is_left_alone(written, tmp_path):
    """Of seventy such records rounded, one was given a resonance that is not there."""
    for seed in (24, 26):
        rng = np.random.default_rng(seed)
        found = _explained(written(_noise(rng), rng), tmp_path / "gyro.npz")
        names = {effect["name"] for effect in found["effects"]}
        assert not {"disturbance", "resonance", "variance_modulation", "outliers"} & names


@pytest.mark.parametrize("codes", [1.0, 2.0, 3.0])
def test_change_of_the_variance_by_codes_is_that_of_exact_sums(codes):
    """Of a normal variable of deviation one in codes so wide, at all places of its mean."""
    variances = []
    at = codes * np.arange(-60, 61)
    for mean in np.linspace(0, codes, 41):
        chance = norm.cdf(at + codes / 2 - mean) - norm.cdf(at - codes / 2 - mean)
        first = chance @ at
        variances.append(chance @ at**2 - first**2)
    assert _own_change(codes) == pytest.approx(max(variances) / min(variances), rel=0.02)


def test_replaced_values_stay_codes_and_stay_held():
    rng = np.random.default_rng(25)
    values = np.repeat(rng.integers(-3, 4, 400) * 0.5, 3)
    values[300:306] = np.repeat([40.0, -35.0], 3)
    filled = replaced(values, np.arange(300, 306), 0)
    assert np.array_equal(np.delete(filled, np.s_[300:306]), np.delete(values, np.s_[300:306]))
    new = filled[300:306]
    assert np.abs(new).max() <= 1.5
    assert np.all(new[:3] == new[0])
    assert np.all(new[3:] == new[3])
    assert set(np.unique(new)) <= set(np.unique(values))


def test_what_is_true_of_a_fresh_value_is_so_of_its_copies():
    told = np.array([0, 3, 4])
    flags = np.array([True, False, True])
    assert as_held(flags, told, 6).tolist() == [True, True, True, False, True, True]
