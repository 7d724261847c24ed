"""A bias that goes elsewhere for a while and comes back, where one step alone might be chance."""

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
    monkeypatch.setattr(_rounds, "_take_two_steps", lambda state, found: False)
    assert not investigated(2, 1.35).findings


def test_none_where_there_is_none():
    """One seed of noise alone; of 150 records none had two (false alarm of one .0004)."""
    assert not investigated(2, 0.0).findings
