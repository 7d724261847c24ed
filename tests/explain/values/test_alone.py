"""Single samples that are wrong, among noise that a filter has been at."""

import numpy as np
import pytest
from scipy.signal import butter, firwin, lfilter

from allanfit.explain._investigate import ALARM, investigate
from allanfit.explain._state import begin
from allanfit.explain.values._alone import Others, behind_filter

SAMPLES = 60_000


def filtered(seed: int, order: int = 2) -> tuple[np.ndarray, np.random.Generator]:
    """White noise of standard deviation 1 behind a digital low-pass at a fifth of the rate."""
    rng = np.random.default_rng(seed)
    return lfilter(*butter(order, 0.4), rng.standard_normal(SAMPLES)), rng


def started(values: np.ndarray):
    power = np.array([0.0, np.var(values) / 2, 0.0, 0.0])
    return begin(values, ((0, values.size),), "point", power, ALARM)


def none_known() -> np.ndarray:
    return np.zeros(SAMPLES, bool)


@pytest.mark.parametrize("order", [1, 2])
def test_errors_in_transmission_are_told_one_by_one(order):
    """Five times the noise in one sample of a thousand; each was many outliers, some a knock."""
    values, rng = filtered(1, order)
    wrong = rng.random(SAMPLES) < 1e-3
    values[wrong] += rng.choice([-5.0, 5.0], wrong.sum())
    power = np.array([0.0, np.var(values) / 2, 0.0, 0.0])
    state = investigate(values, ((0, SAMPLES),), "point", power)
    assert {finding.name for finding in state.findings} == {"outliers", "low_pass"}
    assert state.contamination.fraction == pytest.approx(wrong.mean(), rel=0.1)
    assert state.contamination.amplitude == pytest.approx(5, rel=0.1)
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_a_filter_alone_has_no_wrong_samples(seed):
    wrong, values = behind_filter(started(filtered(seed)[0]), none_known())
    assert not wrong.any()
    assert np.array_equal(values, filtered(seed)[0])


def test_contradictions_of_noise_scatter_as_far_as_stated():
    """Behind an edge so steep that a smoothed spectrum is wrong there, a third more than by it.

    The standard deviation of 60,000 is known within 3 % however few of them are independent.
    """
    values = lfilter(firwin(31, 0.25), 1, filtered(5, 1)[1].standard_normal(SAMPLES))
    state = started(values)
    others = Others(state)
    contradicted = others.contradict(state.calm[state.looked_at]) / others.spread
    assert np.std(contradicted) == pytest.approx(1, rel=0.05)


def test_steps_where_quantization_rules_are_no_wrong_samples():
    """Others contradict all that is slow there: each step would be thousands of spikes."""
    rng = np.random.default_rng(6)
    angle = rng.uniform(-0.5, 0.5, SAMPLES + 1)
    values = np.diff(angle) / np.std(np.diff(angle)) + 0.06 * rng.standard_normal(SAMPLES)
    steps = (15_000, 31_000, 47_000)
    for at in steps:
        values[at:] += 0.6
    state = investigate(values, ((0, SAMPLES),), "point", np.array([0.5, 0.0018, 0.0, 0.0]))
    assert {finding.name for finding in state.findings} == {"step"}
    found = sorted(course.shape["time"] for course in state.courses)
    np.testing.assert_allclose(found, steps, atol=20)


def test_white_noise_is_told_without_its_neighbours():
    values = np.random.default_rng(5).standard_normal(SAMPLES)
    values[::1000] += 10
    assert behind_filter(started(values), none_known()) is None


def test_steps_behind_a_filter_are_no_errors():
    """At half the sampling rate a step of one unit is like an error of half a unit."""
    values, rng = filtered(6)
    levels = np.cumsum(rng.random(SAMPLES) < 1e-3) % 2
    wrong, _ = behind_filter(started(values + 3 * levels), none_known())
    assert not wrong.any()


def test_the_others_expect_what_a_first_order_recursion_says():
    """Of x[k] = p x[k-1] + e[k] the best guess between two neighbours is p/(1 + p^2) their sum."""
    keep = 0.9
    values = lfilter([1], [1, -keep], np.random.default_rng(7).standard_normal(SAMPLES))
    others = Others(started(values))
    at = np.arange(1000, SAMPLES - 1000, 500)
    best = keep / (1 + keep**2) * (values[at - 1] + values[at + 1])
    # What they leave open has the variance 1/(1 + p^2); the spectrum is known to some per cent.
    assert np.std(others.expect(values, at) - best) < 0.2 / np.sqrt(1 + keep**2)
    assert others.height == pytest.approx(np.sqrt(1 + keep**2), rel=0.03)
