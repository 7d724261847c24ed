"""Courses in time: where they are looked for."""

import numpy as np
import pytest
from scipy.fft import dct

from allanfit.explain._investigate import investigate
from allanfit.explain._state import begin
from allanfit.explain.courses._blocks import blocks_of
from allanfit.explain.courses._course import ordinate_variance
from allanfit.explain.courses._scan import _slow_waves, propose


def test_a_step_in_a_strong_random_walk_is_proposed_where_it_is():
    """The walk hides a step but for some 5 samples to either side; A^2/(2 s k) is its evidence."""
    samples, k, height = 100_000, 0.2, 8.0
    proposed = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        at = int(rng.uniform(0.1, 0.9) * samples)
        walk = k * np.cumsum(rng.standard_normal(samples))
        values = walk + rng.standard_normal(samples) + height * (np.arange(samples) >= at)
        pieces = ((0, samples),)
        state = begin(values, pieces, "point", np.array([1e-6, 1.0, 1e-6, k**2]), 0.001)
        found = propose(samples, pieces, values, state.left, state.model, state.data, {})
        steps = [course.shape["time"] for course in found if course.name == "step"]
        proposed.append(min((abs(time - at) for time in steps), default=np.inf))
    # 160 in twice the logarithm of the likelihood: noise moves none by more than that.
    assert max(proposed) < 8


@pytest.mark.parametrize("periods", [3.47, 3.78])
def test_the_frequency_of_a_slow_oscillation_is_known_as_well_as_noise_allows(periods):
    """Of a sinusoid of amplitude A in white noise s^2: var f = 6 s^2/(pi^2 A^2 n^3)."""
    rng, samples = np.random.default_rng(4), 30_000
    frequency, amplitude = periods / samples, 1.0
    values = amplitude * np.sin(2 * np.pi * np.arange(samples) * frequency + 1)
    values += rng.standard_normal(samples)
    state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 1e-8]))
    assert [finding.name for finding in state.findings] == ["sinusoid"]
    (course,) = state.courses
    bound = np.sqrt(6 / (np.pi**2 * amplitude**2 * samples**3))
    assert course.shape["deviation"] == pytest.approx(bound, rel=0.1)
    assert abs(course.shape["frequency"] - frequency) < 3 * bound


def test_the_first_error_of_an_angle_is_no_warm_up_and_no_step():
    """Of four deviations, where quantization is sixty times N: a rate that is over at once."""
    rng = np.random.default_rng(0)
    angle = rng.standard_normal(120_001)
    angle[0] = 4.0
    x = rng.standard_normal(120_000) + 60 * np.diff(angle)
    state = investigate(x, ((0, x.size),), "point", np.array([3600.0, 1.0, 0.0, 0.0]))
    assert not state.findings


@pytest.mark.parametrize("part", [1.0, 1 - 1e-12, 0.37])
def test_slow_waves_have_the_coefficients_of_their_values(part):
    """Whole and half periods in a stretch are orders of the transform, or nearly."""
    count, waves = 301, 40
    periods = part * (1.5 + 0.25 * np.arange(waves))[:, None, None]
    angle = 2 * np.pi * periods * (np.arange(count) + 0.5) / count
    columns = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    expected = np.asarray(dct(columns, norm="ortho"))[..., 1:150]
    np.testing.assert_allclose(_slow_waves(count, part, waves).both, expected, atol=1e-6)


def test_gains_are_those_of_least_squares():
    """Against two fits by NumPy, of a ramp and of the ramp beside each wave, in white noise."""
    samples, waves = 8192, 24
    values = np.random.default_rng(2).standard_normal(samples)
    values += 0.3 * np.sin(2 * np.pi * 3.2 * np.arange(samples) / samples)
    pieces = ((0, samples),)
    state = begin(values, pieces, "point", np.array([1e-6, 1.0, 1e-6, 1e-6]), 0.001)
    blocks = blocks_of(values, list(pieces))
    scan = blocks.scan(state.left, ordinate_variance(state.left, state.model, state.data))
    (stretch,) = scan.stretches

    def white(columns):
        own = stretch.scale * np.asarray(dct(columns, axis=0, norm="ortho"))[stretch.orders]
        return own / np.sqrt(stretch.variance)[:, None]

    def left(columns):
        return np.linalg.lstsq(columns, scan.white, rcond=None)[1][0]

    ramp = white(np.arange(blocks.means[0].size)[:, None])
    angle = 2 * np.pi * (1.5 + 0.25 * np.arange(waves)) * blocks.time[:, None] / samples
    sets = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    expected = [left(ramp) - left(np.hstack([ramp, white(sets[:, each])])) for each in range(waves)]
    np.testing.assert_allclose(scan.gains(sets), expected, rtol=1e-6, atol=1e-6)
    found = stretch.gains(_slow_waves(stretch.count, 1.0, waves))
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)
    assert scan.gains(np.ones((samples // blocks.size, 1, 1))) == 0
