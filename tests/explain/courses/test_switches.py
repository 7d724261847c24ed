"""Steps and disturbed times that are the switches of a telegraph, and those that are not."""

import numpy as np
import pytest
from scipy.signal import lfilter

from allanfit.explain._investigate import investigate
from allanfit.explain.courses._switches import _levels_in_time

SAMPLES = 40_000


def telegraph(rng, dwells: tuple[int, int]) -> np.ndarray:
    """0 and 1, each for exponential times of these means."""
    held = rng.exponential(np.resize(dwells, SAMPLES)).astype(int) + 1
    return np.repeat(np.arange(SAMPLES) % 2, np.minimum(held, SAMPLES))[:SAMPLES].astype(float)


def investigated(values: np.ndarray):
    power = np.array([0.0, np.var(values) / 2, 0.0, 0.0])
    return investigate(values, ((0, SAMPLES),), "point", power)


def test_switches_that_are_clear_to_the_eye_are_neither_steps_nor_disturbances():
    rng = np.random.default_rng(1)
    state = investigated(3 * telegraph(rng, (600, 300)) + rng.standard_normal(SAMPLES))
    assert [finding.name for finding in state.findings] == ["random_telegraph"]
    assert (state.knocks, len(state.courses)) == ([], 1)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_switches_that_a_walk_stands_for_are_seen(seed):
    """A fitted walk is as strong as some 15 to 30 steps of 0.6 deviations, and hid them all."""
    rng = np.random.default_rng((31, seed))
    levels = telegraph(rng, (2000, 2000))
    walk = 3e-4 * np.cumsum(rng.standard_normal(SAMPLES))
    state = investigated(0.6 * levels + walk + rng.standard_normal(SAMPLES))
    assert [finding.name for finding in state.findings] == ["random_telegraph"]
    # Levels as they are, but for what is too brief.
    (course,) = state.courses
    path = course.draw()[:, 0]
    assert np.mean((path > np.median(np.unique(path))) != (levels > 0)) < 0.05
    assert state.sized.sizes[0] == pytest.approx(0.6, rel=0.1)


def test_a_knock_beside_a_telegraph_stays_one():
    rng = np.random.default_rng(3)
    values = 0.7 * telegraph(rng, (300, 300)) + rng.standard_normal(SAMPLES)
    values[9_000:9_400] += 5 * rng.standard_normal(400)
    state = investigated(values)
    assert {"disturbance", "gauss_markov"} <= {finding.name for finding in state.findings}
    ((start, stop),) = state.knocks
    assert (start <= 9_000, stop >= 9_400) == (True, True)


def test_switches_are_placed_where_the_level_changes():
    rng = np.random.default_rng(4)
    levels = np.repeat([0, 1, 0, 1], [300, 150, 400, 150])
    moments = np.repeat([False, True, False, True], [312, 150, 388, 150])[::4]
    path = _levels_in_time(2 * levels + 0.5 * rng.standard_normal(1000), moments, 40)
    assert np.mean(path != levels) < 0.01


def test_a_step_beside_a_process_that_wanders_is_no_switch_of_it():
    """Seen together they have two levels; a telegraph would have to go there and back."""
    kept, samples = np.exp(-1 / 300), 120_000
    for seed in (0, 2):
        rng = np.random.default_rng((21, seed))
        values = rng.standard_normal(samples) + 2e-4 * np.cumsum(rng.standard_normal(samples))
        drive = np.sqrt(1 - kept**2) * rng.standard_normal(samples)
        values += 0.1 * lfilter([1.0], [1.0, -kept], drive)
        values[70_000:] -= 0.9
        state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 1e-7]))
        assert [course.name for course in state.courses] == ["step"]
        assert state.sized.sizes[0] == pytest.approx(-0.9, abs=0.15)
        assert {finding.name for finding in state.findings} == {"step", "gauss_markov"}
