"""Steps and telegraphs that pass the sensor's filter with its noise."""

import numpy as np
import pytest
from scipy.signal import butter, firwin, freqz, lfilter

from allanfit.explain._investigate import investigate
from allanfit.explain.courses._arrival import settled
from allanfit.explain.courses._course import step
from allanfit.explain.courses._one_by_one import Edges
from allanfit.explain.courses._passing import (
    _LENGTH,
    _least_phase,
    _response,
    half_and_rise,
    passed,
)
from allanfit.explain.courses._phase import _AROUND, _at_best

SAMPLES, BEFORE = 40_000, 1_000
FILTERS = {
    "Butterworth": butter(2, 0.2),
    "averages": (np.full(4, 0.25), np.array([1.0])),
    "windowed": (firwin(31, 0.4), np.array([1.0])),
}


def gain_of(b: np.ndarray, a: np.ndarray) -> np.ndarray:
    frequency = 2 * np.pi * np.arange(_LENGTH // 2 + 1) / _LENGTH
    return np.maximum(np.abs(freqz(b, a, frequency)[1]), 1e-30)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_least_phase_is_that_of_feedback(order):
    b, a = butter(order, 0.2)
    edge = _response(_least_phase(gain_of(b, a)), 0, 1, 1)
    expected = lfilter(b, a, np.ones(60))
    np.testing.assert_allclose(edge.height[1:61], expected, atol=2e-3)
    assert (edge.lag[0], edge.height[0]) == (-1, 0)


def test_no_phase_is_that_of_symmetric_filters():
    taps = firwin(31, 0.4)
    impulse = np.roll(np.fft.irfft(gain_of(taps, np.array([1.0]))), _LENGTH // 2)
    edge = _response(impulse, _LENGTH // 2, 1, 1)
    # It is 15 samples late.
    shown = np.interp(np.arange(31) - 15.0, *edge)
    np.testing.assert_allclose(shown, np.cumsum(taps), atol=2e-3)
    half, rise = half_and_rise(edge)
    assert (half, 3 <= rise < 31) == (0, True)


def test_a_course_in_steps_is_filtered():
    b, a = butter(2, 0.2)
    edge = _response(_least_phase(gain_of(b, a)), 0, 1, 1)
    level = np.repeat([0.0, 1.0, 0.0, 1.0], [200, 30, 5, 300])
    np.testing.assert_allclose(passed(level, edge), lfilter(b, a, level), atol=2e-3)
    later = passed(level, edge, 0.5)
    expected = (lfilter(b, a, level)[1:] + lfilter(b, a, level)[:-1]) / 2
    np.testing.assert_allclose(later[1:], expected, atol=2e-3)


def filtered(seed: int, course: np.ndarray, by: str) -> np.ndarray:
    """White noise of one unit and a course through a filter that is filled already."""
    rng = np.random.default_rng(seed)
    course = np.concatenate([np.full(BEFORE, course[0]), course])
    return lfilter(*FILTERS[by], rng.standard_normal(course.size) + course)[BEFORE:]


def investigated(values: np.ndarray):
    return investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 0.5, 0.0, 1e-8]))


@pytest.mark.parametrize("by", ["Butterworth", "averages"])
@pytest.mark.parametrize("height", [3.0, -15.0])
def test_a_step_behind_a_filter_has_no_knock_and_no_spikes(by, height):
    """A sharp one drawn there would leave pulses of several deviations in the whitened record."""
    values = filtered(3, height * (np.arange(SAMPLES) >= 17_000), by)
    state = investigated(values)
    assert {finding.name for finding in state.findings} == {"step", "low_pass"}
    assert state.knocks == []
    (course,) = state.courses
    # In deviations of one sample of the noise in front of it; its edge is several samples long.
    assert course.shape["time"] == pytest.approx(17_000, abs=10 / abs(height))
    assert state.sized is not None
    assert state.sized.sizes[0] == pytest.approx(height, abs=0.1)


@pytest.mark.parametrize("by", ["Butterworth", "averages"])
def test_a_telegraph_behind_a_filter_is_one(by):
    rng = np.random.default_rng(4)
    held = rng.exponential(900, 400).astype(int) + 1
    path = np.repeat(np.arange(400) % 2.0, held)[:SAMPLES]
    state = investigated(filtered(5, 4 * path, by))
    assert {finding.name for finding in state.findings} == {"random_telegraph", "low_pass"}
    assert state.sized is not None
    assert state.sized.sizes[-1] == pytest.approx(4, abs=0.1)
    # The white noise is as strong as it is at low frequency.
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


@pytest.mark.parametrize("at", [3, SAMPLES - 4])
def test_a_step_at_the_very_ends_stays_within(at):
    values = filtered(6, np.zeros(SAMPLES), "Butterworth")
    state = investigated(values)
    found = settled(state, step(at, SAMPLES))
    assert 0 < found.shape["time"] < SAMPLES


@pytest.mark.parametrize("switches", [0, 1])
def test_switches_are_moved_in_a_stretch_that_has_any(switches):
    """One that is three samples late in white noise of no size; a stretch without stays so."""
    near, moves = np.arange(-_AROUND, _AROUND + 1), np.arange(-4, 5)
    moved = np.array([(near - move >= 0).astype(float) - (near >= 0) for move in moves])
    none = np.zeros(0)
    edges = Edges(100, 400, none.astype(int), none, none, none)
    told = np.zeros(300)
    if switches:
        one = np.ones(1)
        edges = edges._replace(at=np.array([203]), turns=one, tall=one, height=one)
        told[100:103] = 1.0
    found = _at_best(edges, told, moved, np.sum(moved**2, axis=1), moves)
    assert found.at.tolist() == [200] * switches
