"""What an output that is clipped leaves of a line and of noise."""

import numpy as np
import pytest

import allanfit

SAMPLES = 40_000


@pytest.mark.parametrize(("amplitude", "low"), [(0.9, -np.inf), (1.5, -1.8)])
def test_a_line_that_is_cut_is_told_as_it_was(amplitude, low):
    """The noise is cut in time with it, and that is no noise whose strength swings by itself."""
    rng = np.random.default_rng(12)
    line = amplitude * np.sin(2 * np.pi * 0.2213 * np.arange(SAMPLES))
    values = rng.standard_normal(SAMPLES) + 1e-3 * np.cumsum(rng.standard_normal(SAMPLES))
    values = np.clip(values + line, low, 1.6)
    recording = allanfit.recording_of(values, rate_hz=1.0, unit="rad/s")
    (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert set(effects) == {"saturation", "sinusoid"}
    lower, upper = effects["sinusoid"]["amplitude"]["intervals"]["0.95"]
    assert lower < amplitude < upper
    assert upper / lower < 1.06
