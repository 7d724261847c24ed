"""Coarse codes of what came through a filter: the everyday case of a MEMS sensor."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain._refit import refit
from allanfit.explain._state import begin
from allanfit.explain.values._codes import Rounding

RATE, SAMPLES = 100.0, 60_000


def explained(order: int, corner: float, codes: float, seed: int):
    """Of white noise of N = 0.005 deg/s/sqrt(Hz), by SciPy's filter, in codes of so many sigma."""
    rng = np.random.default_rng(seed)
    white = 0.005 * np.sqrt(RATE) * rng.standard_normal(SAMPLES + 500)
    passed = lfilter(*butter(order, corner, fs=RATE), white)[500:]
    passed = passed + 2e-6 * np.cumsum(rng.standard_normal(SAMPLES)) + 0.3
    width = codes * passed.std()
    recording = allanfit.recording_of(
        {"gyro_x": np.round(passed / width) * width}, rate_hz=RATE, units={"gyro_x": "deg/s"}
    )
    return explain_recording(recording, posterior=False).to_dict()["channels"][0]


@pytest.mark.parametrize(
    ("order", "corner", "codes", "seed"),
    [(2, 15.0, 0.7, 1), (1, 20.0, 1.0, 2), (2, 30.0, 0.4, 3), (2, 10.0, 1.3, 4), (2, 20.0, 2.0, 5)],
)
def test_a_filter_and_coarse_codes_are_all_that_is_named(order, corner, codes, seed):
    """The floor of rounding is all that is left near the Nyquist frequency, where a filter is zero.

    Taken for less than it is, it was a resonance or a telegraph there; codes of 1.3 sigma, of which
    a sample moves less, made the noise swing; and those of two were taken for codes of an angle.
    """
    channel = explained(order, corner, codes, seed)
    effects = {effect["name"]: effect["parameters"] for effect in channel["effects"]}
    assert effects.keys() == {"low_pass", "output_rounding"}
    low, high = effects["low_pass"]["cutoff_frequency"]["intervals"]["0.95"]
    assert 0.97 * low < corner < 1.03 * high
    white = channel["coefficients_after"]["N"]
    assert white["value"] == pytest.approx(0.005, rel=0.03)


def test_rounding_is_counted_in_full_unless_it_is_not_there():
    """A floor of 0.01 a sample behind a filter that is zero at the Nyquist frequency."""
    rng = np.random.default_rng(6)
    passed = lfilter(*butter(2, 0.3), rng.standard_normal(SAMPLES))
    values = passed + 0.1 * rng.standard_normal(SAMPLES)
    power = np.array([0.0, np.var(values), 0.0, 0.0])
    state = begin(values, ((0, SAMPLES),), "point", power, 8e-4)
    state.rounding = Rounding(0.01, 0.0, 0.0)
    refit(state)
    assert state.data.foreign == pytest.approx(0.02, rel=0.03)
    # Codes far wider than the noise add a twelfth of their square only in theory.
    state.rounding = Rounding(0.1, 0.0, 0.0)
    refit(state)
    assert state.data.foreign < 0.018
