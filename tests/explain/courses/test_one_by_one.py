"""Switches that are seen one by one: what they are told from, and what is told of them."""

import numpy as np
import pytest
from scipy.signal import lfilter

from allanfit.explain._investigate import ALARM, investigate
from allanfit.explain._state import begin
from allanfit.explain.courses._course import Course
from allanfit.explain.courses._dwells import dwells
from allanfit.explain.courses._one_by_one import seen_one_by_one

SAMPLES = 40_000
WALK = 0.1


def switching(rng, dwell: float, share: float = 0.5) -> np.ndarray:
    """0 and 1, each for exponential times."""
    held = rng.exponential(np.resize([2 * (1 - share) * dwell, 2 * share * dwell], SAMPLES))
    held = held.astype(int) + 1
    return np.repeat(np.arange(SAMPLES) % 2, np.minimum(held, SAMPLES))[:SAMPLES].astype(float)


def walking(rng) -> np.ndarray:
    """White noise of one unit on a random walk that the levels hardly stand out of."""
    return rng.standard_normal(SAMPLES) + WALK * np.cumsum(rng.standard_normal(SAMPLES))


def investigated(values: np.ndarray, pieces=((0, SAMPLES),)):
    return investigate(values, pieces, "point", np.array([0.0, 1.0, 0.0, WALK**2]))


def test_a_telegraph_on_a_strong_walk_is_found_switch_by_switch():
    rng = np.random.default_rng(5)
    path, values = switching(rng, 900.0), walking(rng)
    state = investigated(values + 5 * path)
    assert [finding.name for finding in state.findings] == ["random_telegraph"]
    assert (state.knocks, len(state.courses)) == ([], 1)
    assert state.sized is not None
    assert state.sized.sizes[-1] == pytest.approx(5, abs=0.4)
    # A switch is a sample off where noise stands halfway between the levels: two of a hundred.
    (found,) = state.courses[-1].draw().T
    assert np.mean(found != path) < 2 * 0.02 * np.abs(np.diff(path)).mean() + 1e-4
    white, walk = np.exp(state.model.theta[[1, 3]] / 2)
    assert white == pytest.approx(1, abs=0.03)
    assert walk == pytest.approx(WALK, rel=0.2)


def test_stretches_of_a_record_have_levels_of_their_own():
    rng = np.random.default_rng(6)
    path, values = switching(rng, 500.0), walking(rng)
    state = investigated(values + 5 * path, ((0, 21_000), (23_000, SAMPLES)))
    assert [finding.name for finding in state.findings] == ["random_telegraph"]
    (found,) = state.courses[-1].draw().T
    for piece in (slice(0, 21_000), slice(23_000, SAMPLES)):
        assert np.mean(found[piece] != path[piece]) < 1e-3


@pytest.mark.parametrize("seed", range(6))
def test_a_normal_process_of_the_same_spectrum_has_none(seed):
    rng = np.random.default_rng([seed, 7])
    constant = 300.0
    decay = np.exp(-1 / constant)
    driven = np.sqrt(1 - decay**2) * rng.standard_normal(SAMPLES)
    values = walking(rng) + 2.5 * np.asarray(lfilter([1.0], [1.0, -decay], driven))
    state = begin(values, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, WALK**2]), ALARM)
    seen = seen_one_by_one(state)
    assert seen is None or seen.worth(state) < 0


def test_steps_of_any_height_stay_steps():
    rng = np.random.default_rng(9)
    values = walking(rng)
    heights = 7 * (0.5 + rng.random(8)) * np.resize([1, -1], 8)
    for at, height in zip(range(4_000, SAMPLES, 4_500), heights, strict=True):
        values[at:] += height
    names = {finding.name for finding in investigated(values).findings}
    assert "step" in names
    assert not names & {"random_telegraph", "gauss_markov"}


@pytest.mark.parametrize("share", [0.5, 0.25])
def test_the_dwell_is_told_of_switches_of_which_brief_ones_are_missed(share):
    rng = np.random.default_rng(11)
    # Levels for a million dwells; what is left before its time is up was never seen.
    unseen, dwell, count = 4.0, 50.0, 1_000_000
    held = rng.exponential(np.resize([2 * share * dwell, 2 * (1 - share) * dwell], count))
    high = np.arange(count) % 2 == 0
    long = np.flatnonzero(held > unseen)
    turns = 1 + int(np.sum(high[long][1:] != high[long][:-1]))
    shape = {
        "switches": float(turns),
        "samples": float(held.sum()),
        "upper": float(held[high].sum() / held.sum()),
        "unseen": unseen,
    }
    course = Course("random_telegraph", lambda: np.zeros((1, 1)), 1, shape)
    draws, upper, uneven = dwells(course, np.random.default_rng(1), 4000)
    assert np.median(draws) == pytest.approx(dwell, rel=0.02)
    assert (uneven, np.median(upper)) == (share != 0.5, pytest.approx(share, abs=0.01))
    low, high_end = np.quantile(draws, [0.025, 0.975])
    assert low < dwell < high_end
