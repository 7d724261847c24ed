"""Spikes of which only those beyond some reach are told."""

import numpy as np
import pytest

from allanfit.explain.values._contamination import beyond, in_units, unseen

SAMPLES = 300_000


def drawn(seed: int, fraction: float, size: float, reach: float, samples: int = SAMPLES):
    rng = np.random.default_rng(seed)
    hit = rng.random(samples) < fraction
    values = np.abs(rng.standard_normal(samples) + hit * size * rng.standard_normal(samples))
    return values[values > reach], values[values <= reach]


def test_those_within_are_counted_by_those_beyond():
    """Of 40 sets 95 % intervals hold 34 times at least: fewer by chance of .01 or less."""
    held = np.zeros(2, int)
    for seed in range(40):
        far, _ = drawn(seed, 2e-3, 5.0, 5.5)
        found = beyond(far, 5.5, SAMPLES, seed)
        low, high = np.quantile(found.draws[:, :2], [0.025, 0.975], axis=0)
        held += (low < [2e-3, 5.0]) & (high > [2e-3, 5.0])
    assert held.min() >= 34


def test_what_is_unseen_is_the_variance_that_they_add_within():
    far, near = drawn(1, 2e-3, 5.0, 5.5, 3_000_000)
    found = beyond(far, 5.5, 3_000_000, 0)
    # The mean square of so many is known to .0008, and the spikes to some per cent.
    added = float(np.mean(near**2)) - 1
    assert unseen(found) == pytest.approx(added, abs=0.003)
    assert added > 0.006


def test_units():
    far, _ = drawn(2, 2e-3, 5.0, 5.5)
    found = beyond(far, 5.5, SAMPLES, 0)
    other = in_units(found, 4.0)
    assert other.amplitude == pytest.approx(found.amplitude / 4)
    assert other.threshold == pytest.approx(5.5 / 4)
    assert unseen(other) == pytest.approx(unseen(found) / 16, rel=1e-3)
