"""Whether the power of a band stands still, wanders or sweeps."""

import numpy as np
from scipy.signal import lfilter

from allanfit.explain.lines._moving import Band, moving

SAMPLES = 30_000
LOW, HIGH = 0.14, 0.26
AT = np.linspace(LOW, HIGH, 200)


def band_with(power: float) -> Band:
    """A cause of so much more power than the white noise, spread evenly over the band."""
    return Band(LOW, HIGH, AT, np.full(AT.size, power / (1 + power)))


def line_along(frequency: np.ndarray, power: float, rng: np.random.Generator) -> np.ndarray:
    """White noise, and a line whose power spread over the band would be `power` times as dense."""
    amplitude = np.sqrt(4 * power * (HIGH - LOW))
    x = rng.standard_normal(SAMPLES) + amplitude * np.cos(2 * np.pi * np.cumsum(frequency))
    # White again on average, as the model of its spectrum would make it.
    spectrum = np.fft.rfft(x)
    inside = (np.fft.rfftfreq(SAMPLES) > LOW) & (np.fft.rfftfreq(SAMPLES) < HIGH)
    spectrum[inside] /= np.sqrt(1 + power)
    return np.fft.irfft(spectrum, SAMPLES)


def test_noise_that_stands_still_does_whatever_its_strength():
    """White noise, steady and loud in parts: of 300 none is below .001, false alarm .2."""
    rng = np.random.default_rng(1)
    loud = 1 + 2 * (np.arange(SAMPLES) % 9000 < 3000)
    found = []
    for strength in (1.0, loud):
        for _ in range(150):
            path = moving(strength * rng.standard_normal(SAMPLES), band_with(1.0))
            found.append(0.0 if path is None else path.log_p)
    # The highest of 300 fair chances is below .001 in .26 of all cases; these are on the safe side.
    assert min(found) > np.log(0.001)


def test_a_line_that_wanders_is_followed():
    rng = np.random.default_rng(2)
    drift = lfilter([1], [1, -0.9995], rng.standard_normal(SAMPLES))
    frequency = 0.2 + 0.02 * drift / np.std(drift)
    path = moving(line_along(frequency, 0.6, rng), band_with(0.6))
    assert path is not None
    assert path.log_p < np.log(1e-6)
    assert not path.even
    middle = np.arange(path.frequency.size) + 0.5
    true = frequency[(middle * (SAMPLES // path.frequency.size)).astype(int)]
    # Most of it to a tenth of the band; where it leaves the band it cannot be followed.
    assert np.mean(np.abs(path.frequency - true) < 0.1 * (HIGH - LOW)) > 0.8


def test_a_sweep_is_even():
    rng = np.random.default_rng(3)
    path = moving(line_along(np.linspace(0.15, 0.25, SAMPLES), 0.3, rng), band_with(0.3))
    assert path is not None
    assert path.even
    assert path.log_p < np.log(1e-6)


def test_a_line_that_turns_is_not_even():
    rng = np.random.default_rng(4)
    swing = 0.2 + 0.04 * np.sin(2 * np.pi * np.arange(SAMPLES) / 7000)
    path = moving(line_along(swing, 0.3, rng), band_with(0.3))
    assert path is not None
    assert not path.even
    assert path.log_p < np.log(1e-6)


def test_a_band_too_narrow_to_be_resolved_says_nothing():
    x = np.random.default_rng(5).standard_normal(SAMPLES)
    width = 5 / SAMPLES
    at = np.linspace(0.2, 0.2 + width, 9)
    assert moving(x, Band(0.2, 0.2 + width, at, np.full(9, 0.5))) is None
