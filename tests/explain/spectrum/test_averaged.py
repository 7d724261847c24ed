"""Intervals of N where two names fit one spectrum and leave different white noise to it."""

import numpy as np
import pytest
from scipy.signal import lfilter

import allanfit
from allanfit.explain._investigate import investigate
from allanfit.explain.spectrum._averaged import averaged
from allanfit.explain.spectrum._posterior import sample_structure
from allanfit.explain.values._effects import probabilities

SAMPLES = 20_000


def wandering(seed: int, correlation: float, sigma: float):
    """White noise of variance 1 with a Gauss-Markov process beside it, and draws of its model."""
    rng = np.random.default_rng(seed)
    decay = np.exp(-1 / correlation)
    white, drive = rng.standard_normal((2, SAMPLES))
    values = white + lfilter([sigma * np.sqrt(1 - decay**2)], [1, -decay], drive)
    power = np.array([0.0, np.var(values) / 2, 0.0, 0.0])
    state = investigate(values, ((0, SAMPLES),), "point", power)
    assert state.model.kinds.added == ("gauss_markov",)
    return state, sample_structure(state.model, state.data, 1, quick=True)


def test_a_weak_process_leaves_white_noise_as_open_as_its_name():
    """A power law with an exponent near zero is nearly white: it takes N with it."""
    state, draws = wandering(6, 10.0, 0.3)
    mixed = averaged(state, draws, 1, quick=True)
    taken = np.any(mixed.power != draws.power, axis=1)
    # The power law's deviance is 5 higher: exp(-5 / 2) before what is thought of the names.
    assert 0.02 < np.mean(taken) < 0.3
    white, rival = draws.power[~taken, 1], mixed.power[taken, 1]
    assert np.quantile(rival, 0.975) < np.quantile(white, 0.025)
    np.testing.assert_array_equal(mixed.power[~taken, 1], white)
    # What is not a coefficient stays that of the structure which was named.
    np.testing.assert_array_equal(mixed.theta, draws.theta)


def test_a_plain_process_has_its_own_draws():
    state, draws = wandering(6, 100.0, 1.0)
    assert averaged(state, draws, 1, quick=True) is draws


def test_a_filter_that_quantization_hides_leaves_open_whether_its_noise_is_white():
    """One pole at 0.03 of the rate, its noise of 1 a sample below it, under angle quantization.

    Correlated noise beside no white noise has the same spectrum, and N is nothing then.
    """
    rng = np.random.default_rng(4)
    decay = np.exp(-2 * np.pi * 0.03)
    white, angle = rng.standard_normal((2, SAMPLES + 500))
    values = lfilter([1 - decay], [1, -decay], white) + 2 * np.diff(angle, prepend=0.0)
    values = values[500:]
    state = investigate(values, ((0, SAMPLES),), "point", np.array([4.0, 0.2, 0.0, 0.0]))
    assert state.model.kinds.filtering
    draws = sample_structure(state.model, state.data, 1, quick=True)
    mixed = averaged(state, draws, 1, quick=True)
    taken = np.any(mixed.power != draws.power, axis=1)
    own, rivals = probabilities(state.finding("low_pass"), "low_pass")
    told = rivals["gauss_markov"] / (own + rivals["gauss_markov"])
    assert np.mean(taken) == pytest.approx(told, abs=0.03)
    assert 0.9 < np.sqrt(np.median(draws.power[~taken, 1])) < 1.1
    assert np.sqrt(np.median(mixed.power[taken, 1])) < 0.3


def test_a_power_law_of_which_nothing_folds():
    """f^-0.6 that ends at half the rate: all of it folded had exponents .1 and N 5 % too small.

    Of four intervals of each one may miss.
    """
    held = {"N": 0, "exponent": 0}
    for seed in range(4):
        rng, n = np.random.default_rng((6, seed)), 60_000
        frequency, spectrum = np.fft.rfftfreq(n), np.fft.rfft(rng.standard_normal(n))
        spectrum[1:] *= frequency[1:] ** -0.3 * np.sqrt(0.1)
        spectrum[0] = 0
        values = np.fft.irfft(spectrum, n) + rng.standard_normal(n)
        recording = allanfit.recording_of(values, rate_hz=1.0, unit="rad/s")
        (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
        assert [effect["name"] for effect in found["effects"]] == ["power_law"]
        told = {**found["coefficients_after"], **found["effects"][0]["parameters"]}
        for name, truth in (("N", 1.0), ("exponent", 0.6)):
            low, high = told[name]["intervals"]["0.95"]
            held[name] += low <= truth <= high
    assert min(held.values()) >= 3
