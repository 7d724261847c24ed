"""What repeats as a whole, and is many lines."""

import numpy as np
import pytest

from allanfit.explain.lines._waveform import waveform

SAMPLES = 40_000


def pulses(period: float, height: float, seed: int = 1) -> np.ndarray:
    """White noise and a pulse, of two samples or a thirtieth of the period that it comes with."""
    phase = np.arange(SAMPLES) % period
    return np.random.default_rng(seed).standard_normal(SAMPLES) + height * (
        phase < max(2, period / 30)
    )


@pytest.mark.parametrize("period", [100.0, 37.2, 1503.7])
def test_pulses_below_the_noise_are_found_with_their_period(period):
    found = waveform(pulses(period, 0.9), 1 / period + 0.6 / SAMPLES)
    assert found.log_p < np.log(1e-6)
    # Over the record the phase is right to a part of a pulse.
    assert abs(1 / found.period - 1 / period) * SAMPLES < 0.1


def test_what_repeats_is_predicted_and_taken_away():
    """The score of n samples with means m is the sum of m^2 / 2, and what is left is noise."""
    period, height = 100.0, 0.9
    record = pulses(period, height)
    found = waveform(record, 1 / period)
    nats, variance = found.held_out(record)
    expected = SAMPLES / period * 4 * height**2 / 2
    # The means cost half a nat a phase for the fit and as much for the prediction.
    assert nats == pytest.approx(expected - 64, abs=4 * np.sqrt(variance))
    left = found.taken_from(record)
    assert waveform(left, 1 / period).log_p > np.log(0.01)
    assert np.var(left) == pytest.approx(1 - 100 / SAMPLES, abs=4 * np.sqrt(2 / SAMPLES))


def test_noise_repeats_as_seldom_as_said():
    """Of 200 records one in ten at most is rarer than a tenth; 33 and more once in a thousand."""
    rng = np.random.default_rng(3)
    chances = [
        waveform(rng.standard_normal(4000), rng.uniform(0.002, 0.2)).log_p for _ in range(200)
    ]
    assert np.sum(np.array(chances) < np.log(0.1)) < 33
