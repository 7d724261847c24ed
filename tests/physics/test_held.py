"""How much more noise there is at low frequency where values are held."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import butter, lfilter

from allanfit.physics import LowPass, held_factor


def test_behind_a_filter_it_is_less():
    """Variances of means of 500 samples, which tell of N alone: 16,000 each, of the same noise."""
    rng, repeat, samples = np.random.default_rng(3), 1.5, 8_000_000
    values = np.asarray(lfilter(*butter(1, 10.0, fs=100.0), rng.standard_normal(samples)))
    fresh = np.where(rng.random(samples) < 1 / repeat, np.arange(samples), 0)
    held = values[np.maximum.accumulate(fresh)]
    there, then = (np.var(each.reshape(-1, 500).mean(axis=1)) for each in (values, held))
    before = LowPass(jnp.asarray(10.0), jnp.asarray(1.0), digital=True)
    assert held_factor(repeat, False, before, 100.0) ** 2 == pytest.approx(then / there, rel=0.015)
    assert held_factor(repeat, False) ** 2 == pytest.approx(2.0)
