"""Sentences of an explanation."""

import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.explain._effect import Effect
from allanfit.explain._effects import _described
from allanfit.explain._words import effect_sentence, without_pointer
from allanfit.physics import LowPass
from allanfit.recording import recording_of


@pytest.mark.parametrize("kind", ["coarse", "alone"])
def test_an_explanation_does_not_point_to_itself(kind):
    """What the findings of such recordings say for a reader of a fit."""
    values = np.random.default_rng(1).standard_normal(20_000)
    if kind == "coarse":
        values = np.round(values / 2) * 2
    else:
        values[::500] += 50
    (channel,) = recording_of(values, rate_hz=100.0, unit="rad/s").channels
    pointing = [each for each in channel.findings if "`allanfit explain`" in each]
    assert pointing
    for finding in pointing:
        left = without_pointer(finding)
        assert "explain" not in left
        assert left.endswith(".")
        assert finding.startswith(left[:-1])
    for finding in set(channel.findings) - set(pointing):
        assert without_pointer(finding) == finding


def parameter(value: float, low: float, high: float, unit: str) -> dict:
    return {"value": value, "unit": unit, "intervals": {"0.95": [low, high]}}


@pytest.mark.parametrize(
    ("name", "shown", "said"),
    [
        (
            "resonance",
            {
                "sigma": parameter(0.0083006, 0.0062768, 0.0098988, "deg/s"),
                "frequency": parameter(20.57705, 20.51577, 20.64044, "Hz"),
                "quality_factor": parameter(473.15, 85.8, 2764.0, ""),
            },
            "A resonance of 0.0083 deg/s rms at 20.577 Hz with a quality factor of 500.",
        ),
        (
            "sinusoid",
            {
                "amplitude": parameter(1.23456e-3, 1.1e-3, 1.4e-3, "rad/s"),
                "frequency": parameter(7.123456, 7.11, 7.13, "Hz"),
            },
            "A sinusoid of amplitude 0.00123 rad/s at 7.123 Hz.",
        ),
        (
            "dropped_samples",
            {"fraction": parameter(0.0123456, 0.011, 0.0137, "")},
            "1.23 % of the samples were lost on the way, by the time stamps.",
        ),
        (
            "power_law",
            {"exponent": parameter(1.2345, 1.0, 1.5, "1")},
            "Noise whose density falls as f^-1.23, which is neither white, flicker nor random "
            "walk.",
        ),
        # Of what has no interval four digits, as in a table.
        (
            "bump",
            {"frequency": {"value": 1234.567, "unit": "Hz", "intervals": {}}},
            "Nothing of the catalogue explains a lack of power about 1235 Hz; a smooth bump "
            "stands for it.",
        ),
    ],
)
def test_sentences_have_the_digits_that_intervals_support(name, shown, said):
    """Half of an interval has two: of 62 mHz those are thousandths."""
    assert effect_sentence(Effect(name, 0.99, {}, {}), shown) == said


def test_a_corner_that_may_fold_has_the_digits_of_its_interval():
    shown = {
        "cutoff_frequency": parameter(36.8, 28.7, 268.4, "Hz"),
        "order": parameter(2.0, 1.8, 2.3, ""),
    }
    said = effect_sentence(Effect("low_pass", 0.99, {}, {}, band_hz=(9.2, 50.0)), shown)
    assert said.startswith("A low-pass filter at 40 Hz of order 2.00, or any corner from 30 to 270")


def test_a_sentence_has_the_numbers_of_the_table():
    """Where several kinds of filter are as likely, the likeliest at its best has others."""
    best = LowPass(jnp.asarray(2.0), jnp.asarray(0.7), floor=jnp.asarray(-4.0))
    told = {"cutoff_frequency": 2.0, "order": 1.94, "floor": -3.8}
    words = "of order 1.94, and behind it white noise at -4 dB, as a converter adds"
    assert _described(best, told) == words
    # What is no floor is not told.
    assert _described(best, {"cutoff_frequency": 2.0, "order": 1.94}) == ""
