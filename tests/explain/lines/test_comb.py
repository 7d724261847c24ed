"""What repeats without a harmonic that stands out."""

import numpy as np
import pytest

import allanfit
from allanfit.explain.lines._comb import strongest_comb

SAMPLES = 100_000


def test_white_noise_has_none():
    """Of 300 records more than 27 are below a chance of .05 once in 2000 times."""
    rng = np.random.default_rng(1)
    chances = [strongest_comb(rng.standard_normal(8000)) for _ in range(300)]
    below = [comb for comb in chances if comb is not None and comb.log_p < np.log(0.05)]
    assert None not in chances
    assert len(below) <= 27


@pytest.mark.parametrize(
    ("period", "strength"), [(20.0, 25), (33.7, 25), (100.0, 25), (512.3, 30)], ids=str
)
def test_pulses_are_found_at_their_period(period, strength):
    """Each a sample long, all of them so many standard deviations; no harmonic is above 8."""
    rng = np.random.default_rng(2)
    values = rng.standard_normal(SAMPLES)
    at = np.round(np.arange(5, SAMPLES, period)).astype(int)[:-1]
    values[at] += strength / np.sqrt(at.size)
    found = strongest_comb(values)
    assert found is not None
    assert found.log_p < np.log(1e-6)
    # Or a multiple of it, where harmonics beyond those that are added up are left out.
    times = found.frequency * period
    assert times == pytest.approx(round(times), abs=period / SAMPLES)


def test_some_lines_are_none():
    rng = np.random.default_rng(3)
    at = np.arange(SAMPLES)
    lines = sum(np.cos(2 * np.pi * f * at) for f in (0.0123, 0.0246, 0.31))
    found = strongest_comb(rng.standard_normal(SAMPLES) + lines)
    assert found is not None
    assert found.log_p > np.log(0.01)


def test_none_is_looked_for_in_a_short_record():
    assert strongest_comb(np.random.default_rng(4).standard_normal(2000)) is None


def test_a_pulse_each_second_has_no_name_and_is_told():
    """Half as high as the noise, in one sample of a hundred; nothing was said of it."""
    rng = np.random.default_rng(5)
    values = rng.standard_normal(SAMPLES)
    values[37::100] += 0.55
    recording = allanfit.recording_of(values, rate_hz=100.0, unit="deg/s")
    (told,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    (effect,) = told["effects"]
    assert told["verdict"] == "unexplained"
    assert "a waveform repeats, every 1 s" in effect["sentence"]
