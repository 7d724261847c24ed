"""Whether a spectrum is said to fall toward the Nyquist frequency."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

import allanfit
from allanfit.identify._recording_fit import series_fit

RATE_HZ, SAMPLES = 100.0, 60_000
TIME = np.arange(SAMPLES) / RATE_HZ


def white(seed: int) -> np.ndarray:
    """Of N = 0.004 u/sqrt(Hz)."""
    return 0.04 * np.random.default_rng(seed).standard_normal(SAMPLES)


def filtered(samples: np.ndarray, order: int, cutoff_hz: float) -> np.ndarray:
    return np.asarray(sosfilt(butter(order, cutoff_hz, fs=RATE_HZ, output="sos"), samples))


def falls(samples: np.ndarray) -> bool:
    (channel,) = series_fit(allanfit.fit(samples, RATE_HZ)).channels
    return any("falls toward the Nyquist" in each for each in channel.findings)


@pytest.mark.parametrize("amplitude", [0.02, 0.2])
@pytest.mark.parametrize("frequency_hz", [2.0, 10.0, 17.3, 40.0])
def test_a_line_lifts_the_level_and_nothing_falls(frequency_hz, amplitude):
    line = amplitude * np.sin(2 * np.pi * frequency_hz * TIME)
    assert not falls(white(round(frequency_hz)) + line)


def test_neither_do_white_noise_and_a_tone_with_its_harmonics():
    assert not falls(white(1))
    assert not falls(white(2) + 0.02 * sum(np.sin(10 * np.pi * k * TIME) for k in range(1, 10)))


@pytest.mark.parametrize("cutoff_hz", [1.0, 20.0, 40.0])
@pytest.mark.parametrize("order", [1, 4])
def test_a_filter_is_told(cutoff_hz, order):
    assert falls(filtered(white(3), order, cutoff_hz))


def test_repeats_and_a_filter_behind_a_line_are_told():
    line = 0.02 * np.sin(2 * np.pi * 17.3 * TIME)
    assert falls(np.repeat(white(4)[::2], 2))
    assert falls(filtered(white(5), 2, 20.0) + line)
