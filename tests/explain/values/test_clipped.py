"""What an output that is clipped leaves of a line and of noise."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

import allanfit

SAMPLES = 40_000


@pytest.mark.parametrize(("amplitude", "low"), [(0.9, -np.inf), (1.5, -2.2)])
def test_a_line_that_is_cut_is_told_as_it_was(amplitude, low):
    """The noise is cut in time with it, and that is no noise whose strength swings by itself.

    The mean of four records within three standard errors.
    """
    told, deviations = [], []
    for seed in range(12, 16):
        white = np.random.default_rng(seed).standard_normal(SAMPLES)
        line = amplitude * np.sin(2 * np.pi * 0.2213 * np.arange(SAMPLES))
        values = np.clip(white + line, low, 2.0)
        recording = allanfit.recording_of(values, rate_hz=1.0, unit="rad/s")
        (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
        assert {effect["name"] for effect in found["effects"]} == {"saturation", "sinusoid"}
        lines = [each["parameters"] for each in found["effects"] if each["name"] == "sinusoid"]
        # What the rails make of it are harmonics.
        for other in lines[1:]:
            turns = other["frequency"]["value"] / 0.2213
            assert min(abs(turns - 3), abs(1 / 0.2213 - turns - 3)) < 1e-3
        lower, upper = lines[0]["amplitude"]["intervals"]["0.95"]
        assert upper / lower < 1.06
        told.append(lines[0]["amplitude"]["value"])
        deviations.append((upper - lower) / 3.92)
    assert abs(np.mean(told) - amplitude) < 3 * np.mean(deviations) / 2


def test_a_clipped_output_of_a_filter_is_not_held():
    """Samples stand at a rail one after the other; with knocks cut out they did not know why.

    N within four per cent: it was a third of itself.
    """
    rng = np.random.default_rng(59)
    white = rng.standard_normal(100_500)
    passed = lfilter(*butter(2, 0.4), white)[500:]
    values = np.clip(passed, -1.9 * passed.std(), 1.9 * passed.std())
    recording = allanfit.recording_of(values, rate_hz=1.0, unit="rad/s")
    (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    named = {effect["name"] for effect in found["effects"]}
    assert {"saturation", "low_pass"} <= named
    assert not {"sample_hold", "random_telegraph"} & named
    assert found["coefficients_after"]["N"]["value"] == pytest.approx(1, abs=0.04)


@pytest.mark.parametrize("limit", [3.0, 5.0])
def test_clipped_noise_is_as_strong_as_before_and_does_not_switch(limit):
    """A Gauss-Markov process of 1.5 beside N of 2, a fifth and a twentieth of it at the rails.

    What stands at a rail was a level of a telegraph, with 95 %. Rails pass the size of noise by
    Bussgang's theorem; within four of its standard errors, which are 2 %.
    """
    rng = np.random.default_rng(77)
    keep = np.exp(-1 / 50)
    wandering = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.standard_normal(80_000)) * 1.5
    values = np.clip(wandering + 2 * rng.standard_normal(80_000), -limit, limit)
    recording = allanfit.recording_of(values, rate_hz=1.0, unit="rad/s")
    (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert set(effects) == {"saturation", "gauss_markov"}
    assert effects["gauss_markov"]["sigma"]["value"] == pytest.approx(1.5, rel=0.08)
