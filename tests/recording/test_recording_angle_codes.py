"""Differences of an angle in wide codes, told from rates that are rounded."""

import numpy as np
import pytest

import allanfit
from allanfit.recording._angle_codes import angle_codes

SAMPLES = 40_000


def counts(move: float, rate: float = 0.0, seed: int = 1, samples: int = SAMPLES) -> np.ndarray:
    rng = np.random.default_rng(seed)
    angle = rng.random() + np.cumsum(rate + move * rng.standard_normal(samples + 1))
    return np.diff(np.round(angle))


@pytest.mark.parametrize(
    ("move", "rate"), [(0.12, 0.0), (0.2, 0.1), (0.35, 0.3), (0.55, 0.0)], ids=str
)
def test_the_codes_passed_tell_how_the_angle_moves(move, rate):
    found = angle_codes(0.06 * counts(move, rate), 0.06)
    assert found is not None
    # Of some thousand codes that were passed, which come in bursts.
    assert found.move == pytest.approx(move, rel=0.08)
    np.testing.assert_allclose(found.rates, rate, atol=4 * move / np.sqrt(256))


@pytest.mark.parametrize("width", [2.0, 3.0, 6.0])
def test_a_rate_that_is_rounded_is_none(width):
    rng = np.random.default_rng(2)
    rate = rng.standard_normal(SAMPLES) + rng.uniform(-0.5, 0.5) * width
    assert angle_codes(np.round(rate / width) * width, width) is None


def test_nor_is_what_has_no_codes_or_fine_ones_or_is_short():
    assert angle_codes(np.random.default_rng(3).standard_normal(SAMPLES), 1e-6) is None
    assert angle_codes(counts(3.0), 1.0) is None
    assert angle_codes(counts(0.2) + 0.3, 1.0) is None
    assert angle_codes(counts(0.2, samples=1000), 1.0) is None


def test_they_are_no_dead_band_and_no_held_samples():
    for rate in (0.0, 0.1):
        values = 0.12 * counts(0.17, rate, samples=200_000)
        recording = allanfit.recording_of(values, rate_hz=100.0, unit="deg/s")
        (finding,) = recording.channels[0].findings
        assert "differences of an angle" in finding
        assert "0.12 deg/s" in finding
