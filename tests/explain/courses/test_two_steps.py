"""A bias that comes back or climbs in steps, of which one alone might be chance."""

import numpy as np

from allanfit.explain import _rounds
from allanfit.explain._investigate import investigate

SAMPLES, K = 60_000, 0.03


def investigated(seed: int, height: float):
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(SAMPLES) + K * np.cumsum(rng.standard_normal(SAMPLES))
    x[20_000:43_000] += height
    return investigate(x, ((0, SAMPLES),), "point", np.array([1e-6, 1.0, 1e-6, K**2]))


def test_two_steps_that_are_no_chance_together(monkeypatch):
    state = investigated(2, 1.35)
    assert [finding.name for finding in state.findings] == ["step", "step"]
    times = sorted(course.shape["time"] for course in state.courses)
    # A step of 1.35 in this noise is known to some ten samples.
    np.testing.assert_allclose(times, [20_000, 43_000], atol=40)
    # Neither is told by itself.
    monkeypatch.setattr(_rounds, "_take_steps", lambda state, found: False)
    assert not investigated(2, 1.35).findings


def test_a_bias_that_climbs_in_steps_is_no_walk(monkeypatch):
    """Three steps of a sixth of the noise: a walk ten times too strong stands for them."""
    rng = np.random.default_rng(2)
    x = rng.standard_normal(100_000) + 1e-4 * np.cumsum(rng.standard_normal(100_000))
    for time in (24_000, 50_000, 64_000):
        x[time:] += 0.165
    steps = investigate(x, ((0, x.size),), "point", np.array([0.0, 1.0, 1e-6, 1e-6]))
    assert [finding.name for finding in steps.findings] == ["step"] * 3
    assert np.exp(steps.model.theta[3] / 2) < 3e-4
    monkeypatch.setattr(_rounds, "_MOST_STEPS", 2)
    walk = investigate(x, ((0, x.size),), "point", np.array([0.0, 1.0, 1e-6, 1e-6]))
    assert not walk.findings
    assert np.exp(walk.model.theta[3] / 2) > 6e-4


def test_none_where_there_is_none():
    """One seed of noise alone; of 150 records none had two (false alarm of one .0004)."""
    assert not investigated(2, 0.0).findings
