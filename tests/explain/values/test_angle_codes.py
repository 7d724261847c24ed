"""Nothing is left out where an angle is rounded to wide codes."""

import numpy as np
import pytest

import allanfit


@pytest.mark.parametrize(("over", "rate"), [(3.0, 0.05), (6.0, 0.0)], ids=str)
def test_differences_of_an_angle_in_wide_codes_are_the_five_terms(over, rate):
    """Three times the noise were a low-pass filter, six times a dead band, with N 25 % too large.

    One of 500 recordings with nothing hidden raises an alarm.
    """
    rng = np.random.default_rng(4)
    n, rate_hz, samples = 2e-3, 100.0, 120_000
    width = over * n / np.sqrt(rate_hz)
    moves = n / np.sqrt(rate_hz) * rng.standard_normal(samples + 1) + rate * width
    values = np.diff(np.round((rng.random() * width + np.cumsum(moves)) / width)) * width * rate_hz
    recording = allanfit.recording_of(values, rate_hz=rate_hz, unit="deg/s")
    (told,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    assert (told["verdict"], told["effects"]) == ("consistent", [])
    for symbol, truth in (("N", n), ("Q", width / np.sqrt(12))):
        assert told["coefficients_after"][symbol]["value"] == pytest.approx(truth, rel=0.03)
