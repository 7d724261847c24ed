"""Noise that hides within a code: what is left to say of it."""

import numpy as np
import pytest

import allanfit

SAMPLES, RATE, WIDTH = 60_000, 100.0, 0.01


def explained(narrow, drift, seed):
    """White noise of a `narrow`-th of a code, about a mean that walks so many codes or stays."""
    rng = np.random.default_rng((narrow, seed))
    values = rng.standard_normal(SAMPLES) / narrow + rng.uniform(-0.5, 0.5)
    values += drift * np.cumsum(rng.standard_normal(SAMPLES)) / np.sqrt(SAMPLES)
    codes = WIDTH * np.rint(values)
    (channel,) = allanfit.explain(codes, rate_hz=RATE, unit="rad/s", posterior=False).to_dict()[
        "channels"
    ]
    return channel


@pytest.mark.parametrize(
    ("narrow", "drift", "seed"), [(6, 0.0, 0), (6, 0.0, 2), (6, 1.2, 0), (12, 0.0, 1), (12, 1.2, 1)]
)
def test_noise_within_a_code_is_a_limit_and_makes_no_physics_up(narrow, drift, seed):
    """N was known to a tenth, and wrong by up to three; a walk was steps, and bumps, and a filter.

    No noise that stays within a code has a larger deviation than one that is spread over it evenly.
    """
    channel = explained(narrow, drift, seed)
    assert channel["verdict"] == "explained"
    assert [effect["name"] for effect in channel["effects"]] == ["output_rounding"]
    assert any("hides within a code" in sentence for sentence in channel["advice"])
    told = channel["coefficients_after"]
    largest = WIDTH / np.sqrt(12 * RATE)
    for symbol, truth in (("N", WIDTH / narrow / RATE**0.5), ("B", 0.0), ("Q", 0.0)):
        low, high = told[symbol]["intervals"]["0.95"]
        assert low <= truth <= high
        assert not told[symbol]["resolved"]
    assert 0.9 * largest < told["N"]["upper_limit_95"] < largest
    low, high = told["K"]["intervals"]["0.95"]
    assert low <= drift * WIDTH / np.sqrt(SAMPLES / RATE) <= high


def test_noise_of_a_quarter_of_a_code_is_known():
    """Within five standard errors of a per cent or so each; codes are how it is told."""
    told = explained(4, 0.0, 1)["coefficients_after"]["N"]
    assert told["resolved"]
    assert told["value"] == pytest.approx(WIDTH / 4 / RATE**0.5, rel=0.08)
    assert told["intervals"]["0.95"][1] < 1.1 * WIDTH / 4 / RATE**0.5
