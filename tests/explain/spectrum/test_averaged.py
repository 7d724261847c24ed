"""Intervals of N where two names fit one spectrum and leave different white noise to it."""

import numpy as np
from scipy.signal import lfilter

from allanfit.explain._investigate import investigate
from allanfit.explain.spectrum._averaged import averaged
from allanfit.explain.spectrum._posterior import sample_structure

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
