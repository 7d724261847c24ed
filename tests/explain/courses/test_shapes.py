"""Warm-ups: how well they are known, and several beside one another."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate
from allanfit.explain.courses._shapes import draw_courses

SAMPLES = 40_000
TIME = np.arange(SAMPLES)


def investigated(values, walk):
    return investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, walk**2]))


def test_size_and_constant_of_a_warm_up_are_known_together_only():
    """In white noise of one, of A e^(-t/c): var A = 4/c and var ln c = 8/(A^2 c), by Fisher's
    information over c << T. With c known the former would be half of it.
    """
    constant, size = 1200.0, 0.8
    values = np.random.default_rng(3).standard_normal(SAMPLES) + size * np.exp(-TIME / constant)
    state = investigated(values, 1e-4)
    assert [finding.name for finding in state.findings] == ["warm_up"]
    (sizes,), (logs,) = draw_courses(state, np.random.default_rng(0), 4000)
    # A mean and a ramp of the record are not known either, nor is the noise.
    assert 1.0 < sizes.std() / np.sqrt(4 / constant) < 1.2
    assert 1.0 < logs.std() / np.sqrt(8 / (size**2 * constant)) < 1.2
    assert abs(sizes.mean() - size) < 3 * sizes.std()
    assert abs(np.log(state.courses[0].shape["time_constant"] / constant)) < 3 * logs.std()


@pytest.mark.parametrize("walk", [1e-3, 0.02])
def test_a_warm_up_that_overshoots_is_two_exponentials(walk):
    """Each was found without the other, which moved its constant by a factor of two."""
    rng = np.random.default_rng(111)
    noise = rng.standard_normal(SAMPLES) + walk * np.cumsum(rng.standard_normal(SAMPLES))
    size = 20 * np.sqrt(1 / 5000 + walk**2 * 5000 / 3)
    sizes, constants = size * np.array([-2.0, 3.0]), np.array([800.0, 5000.0])
    values = noise + np.exp(-TIME[:, None] / constants) @ sizes
    state = investigated(values, walk)
    assert [finding.name for finding in state.findings] == ["warm_up", "warm_up"]
    drawn, logs = draw_courses(state, np.random.default_rng(0), 2000)
    found = np.array([course.shape["time_constant"] for course in state.courses])
    for i, k in enumerate(np.argsort(found)):
        assert found[k] == pytest.approx(constants[i], rel=0.35)
        assert np.abs(np.log(found[k] / constants[i])) < 3 * logs[k].std()
        assert drawn[k].mean() == pytest.approx(sizes[i], rel=0.25)
