"""Noise whose strength varies all the time, or between more than two levels."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt

import allanfit
from allanfit.explain._investigate import investigate
from allanfit.explain.strength._modulation import modulation

SAMPLES = 60_000
PART = np.arange(SAMPLES) / SAMPLES
COURSES = {
    "rising": (1 + PART, 2.0),
    "swinging": (1 + 0.4 * np.sin(6 * np.pi * PART), 1.4 / 0.6),
    "of three levels": (np.repeat([1.0, 1.5, 2.5, 1.0, 2.5, 1.5], SAMPLES // 6), 2.5),
}


@pytest.mark.parametrize("course", COURSES)
def test_the_extremes_of_a_course_are_known(course):
    """Within 6 %, which is three standard deviations of the smoothed ends of 400 samples or so."""
    deviation, ratio = COURSES[course]
    found = modulation(deviation * np.random.default_rng(1).standard_normal(SAMPLES), 0)
    assert found.strength is not None
    assert np.median(found.extremes) == pytest.approx(ratio, rel=0.06)
    # As it is at each sample, but for the windows at jumps.
    told = found.strength / np.median(found.strength) * np.median(deviation)
    assert np.median(np.abs(told / deviation - 1)) < 0.03


def test_the_ratio_of_a_swing_is_in_its_interval():
    """Of 20 intervals of 95 % 16 at least hold, but for a chance of .003; 3 did, all too high."""
    held = []
    for seed in range(20):
        rng = np.random.default_rng((4, seed))
        ratio, turn = rng.uniform(1.4, 3), rng.integers(1, 7) * PART + rng.random()
        deviation = ratio ** (np.sin(2 * np.pi * turn) / 2)
        found = modulation(deviation * rng.standard_normal(SAMPLES), 0)
        low, high = np.quantile(found.extremes, [0.025, 0.975])
        held.append(low < ratio < high)
    assert sum(held) >= 16


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_line_beside_noise_that_swings_is_a_line(seed):
    """It is as strong at all times, though it stands out more when the noise is weak."""
    rng = np.random.default_rng(seed)
    deviation, _ = COURSES["swinging"]
    values = deviation * rng.standard_normal(SAMPLES)
    values += 0.3 * np.sin(2 * np.pi * 0.0913 * np.arange(SAMPLES) + seed)
    state = investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, 1e-9]))
    names = {finding.name for finding in state.findings}
    assert names == {"variance_modulation", "sinusoid"}
    assert state.sized is not None
    assert np.linalg.norm(state.sized.sizes) == pytest.approx(0.3, rel=0.08)


@pytest.mark.parametrize("ratio", [1.2, 1.5, 3.0])
def test_two_levels_stay_two(ratio):
    """Of 20 records all, and the level that is loud for a tenth of the time is not cut off."""
    loud = np.zeros(SAMPLES, bool)
    loud[20_000:23_000] = loud[40_000:43_000] = True
    ratios = []
    for seed in range(20):
        white = np.random.default_rng(seed).standard_normal(SAMPLES)
        found = modulation(np.where(loud, ratio, 1.0) * white, 0)
        assert found.strength is None
        ratios.append(found.ratio)
    # One is known to 1/sqrt(2 6000), and choosing windows makes it a little larger.
    assert np.mean(ratios) == pytest.approx(ratio, rel=0.01)


def test_two_loud_times_of_one_strength_are_of_one():
    """Of 12 records 11 at least: if one in a hundred has not two levels, but for a chance of .006.

    Half of them had a third, of the windows in which loud times begin and end, and no edges.
    """
    samples, two = 100_000, []
    for seed in range(12):
        rng = np.random.default_rng((7, seed))
        edges = np.sort(rng.integers(5000, samples - 5000, 4))
        values = rng.standard_normal(samples)
        for begin, end in edges.reshape(2, 2):
            values[begin:end] *= 1.2
        found = modulation(values, 0)
        told = np.flatnonzero(np.diff(found.loud))
        near = np.abs(told[:, None] - edges) < 500
        two.append(found.strength is None and near.any(axis=0).all() and near.any(axis=1).all())
    assert sum(two) >= 11


@pytest.mark.parametrize("course", COURSES)
def test_noise_that_varies_has_no_spikes_and_no_lines(course):
    deviation, _ = COURSES[course]
    white = deviation * np.random.default_rng(2).standard_normal(SAMPLES)
    state = investigate(white, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, 0.0]))
    assert [finding.name for finding in state.findings] == ["variance_modulation"]
    assert not state.unknown


def test_n_is_that_of_the_quietest_of_several_levels():
    """Of a third of 60,000 samples: to three standard deviations, 1/sqrt(2 20,000) each."""
    deviation, _ = COURSES["of three levels"]
    white = deviation * np.random.default_rng(3).standard_normal(SAMPLES)
    state = investigate(white, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, 0.0]))
    assert abs(np.exp(state.model.theta[1] / 2) - 1) < 0.015


def test_vibration_of_varying_strength_leaves_n():
    """A band of 0.15 to 0.3 cycles per sample, up to four times as strong as the noise."""
    rng = np.random.default_rng(4)
    walk = lfilter([1.0], [1, -np.exp(-1 / 3000)], rng.standard_normal(SAMPLES))
    band = lfilter(*butter(1, [0.3, 0.6], "band"), rng.standard_normal(SAMPLES))
    values = rng.standard_normal(SAMPLES) + band / band.std() * np.exp(0.8 * walk / walk.std())
    state = investigate(values, ((0, SAMPLES),), "point", np.array([0.0, 1.0, 0.0, 0.0]))
    assert state.vibration is not None
    assert [each.like for each in state.unknown] == ["vibration does so"]
    assert abs(np.exp(state.model.theta[1] / 2) - 1) < 0.04


def test_a_weak_swing_is_loud_half_of_the_time():
    """Forty-five swings of a tenth in power: none is worth the changes of two levels."""
    swing = np.sin(90 * np.pi * np.arange(134_000) / 134_000)
    white = np.sqrt(1 + 0.114 * swing) * np.random.default_rng(0).standard_normal(134_000)
    found = modulation(white, 0)
    assert found.p_value < 1e-8
    assert found.strength is not None
    assert 0.3 < found.loud.mean() < 0.7
    assert np.mean(found.loud[swing > 0.5]) > 0.85 > 0.15 > np.mean(found.loud[swing < -0.5])
    # Where it is loud power is 1 + 0.114 * 2/pi of the mean, and as much less elsewhere.
    assert found.ratio == pytest.approx(np.sqrt(1.073 / 0.927), rel=0.03)


def test_levels_at_other_times():
    """Loud times that were known with a part missing are as loud as they are without it."""
    loud = (np.arange(SAMPLES) // 10_000) % 2 == 1
    white = np.where(loud, 1.5, 1.0) * np.random.default_rng(2).standard_normal(SAMPLES)
    found = modulation(white / white.std(), 0)
    wrong = found.at_times(found.loud & (np.arange(SAMPLES) < 40_000))
    assert wrong.ratio < 0.95 * found.ratio
    assert wrong.at_times(loud).ratio == pytest.approx(1.5, rel=0.03)


@pytest.mark.parametrize("oversampled", [6, 1], ids=["in front of the converter", "behind it"])
def test_filtered_noise_that_is_louder_is_a_filter_and_louder_noise(oversampled):
    """Half as much again for a sixth of the time, and a Butterworth filter.

    N of the quiet times is one, within 2 %, which is four times its error by 100,000 samples; of
    all times it is 10 % more. The louder part of a filtered spectrum is no spectrum of its own.
    """
    rng, samples = np.random.default_rng(71), 100_000
    x = rng.standard_normal(samples * oversampled) * np.sqrt(oversampled)
    x[int(0.3 * x.size) : int(0.47 * x.size)] *= 1.5
    corner = 2 * 0.225 / oversampled
    values = sosfilt(butter(2, corner, output="sos"), x)[::oversampled]
    values += 2e-4 * np.cumsum(rng.standard_normal(samples))
    recording = allanfit.recording_of(values, rate_hz=1.0, unit="rad/s")
    (found,) = allanfit.explain(recording, posterior=False).to_dict()["channels"]
    effects = {effect["name"]: effect["parameters"] for effect in found["effects"]}
    assert effects.keys() == {"low_pass", "variance_modulation"}
    assert effects["variance_modulation"]["ratio"]["value"] == pytest.approx(1.5, abs=0.04)
    assert found["coefficients_after"]["N"]["value"] == pytest.approx(1.0, rel=0.02)
