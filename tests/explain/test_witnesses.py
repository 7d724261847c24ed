"""Tests that do not look at the spectrum: each with a null that must stay silent, and a case."""

import numpy as np
import pytest
from scipy.stats import norm

from allanfit.explain._intervals import runs
from allanfit.explain._state import begin
from allanfit.explain.lines._lines import refine, scan
from allanfit.explain.strength._modulation import modulation, uneven
from allanfit.explain.values._contamination import contamination, log_body
from allanfit.explain.values._format import sample_format
from allanfit.explain.values._rounded import about_format

SAMPLES = 40_000


@pytest.fixture(scope="module")
def white():
    return np.random.default_rng(3).standard_normal(SAMPLES)


def test_white_noise_is_normal_and_lasts(white):
    """Nominal chance of a p-value below 0.001: 0.3 % over the three tests, at this seed fixed."""
    assert contamination(white, 0).p_value > 1e-3
    assert uneven(white)[0] > 1e-3
    assert scan(white, 1e-3) == []


def test_p_values_of_uneven_variance_are_honest():
    """Of 200 records 5 % or fewer at 5 %; 20 or more would happen once in 2000 (binomial)."""
    rng = np.random.default_rng(4)
    low = sum(uneven(rng.standard_normal(8192))[0] < 0.05 for _ in range(200))
    assert low < 20


def test_p_values_of_uneven_variance_are_honest_where_noise_is_no_longer_white():
    """Averages of neighbours, whose squares scatter by 1 + 2 (2/3)^2 + 2 (1/3)^2 more; as above."""
    rng = np.random.default_rng(14)
    low = 0
    for _ in range(200):
        white = rng.standard_normal(8194)
        low += uneven((white[2:] + white[1:-1] + white[:-2]) / 3**0.5)[0] < 0.05
    assert low < 20


def test_spikes_are_counted_and_sized(white):
    rng = np.random.default_rng(5)
    spikes = (rng.random(SAMPLES) < 0.003) * 9.0 * rng.standard_normal(SAMPLES)
    found = contamination(white + spikes, 0)
    assert found.p_value < 1e-20
    low, high = np.quantile(found.draws, [0.001, 0.999], axis=0)
    assert low[0] < 0.003 < high[0]
    assert low[1] < 9.0 < high[1]
    assert found.sigma == pytest.approx(1.0, abs=0.02)


def test_light_tails_of_a_rounded_angle_hide_no_spikes():
    """The error of a rounded angle is uniform: taken as normal, it makes spikes few and large."""
    rng, samples = np.random.default_rng(6), 2**18
    angle = 12**0.5 * rng.uniform(-0.5, 0.5, samples + 1)
    record = np.diff(angle) + rng.standard_normal(samples)
    frequency = np.fft.rfftfreq(samples)
    density = 1 + 4 * np.sin(np.pi * frequency) ** 2
    height = np.mean(density**-0.5)
    spikes = (rng.random(samples) < 1e-3) * 3 / height * rng.standard_normal(samples)
    white = np.fft.irfft(np.fft.rfft(record + spikes) / density**0.5)
    calm = np.fft.irfft(np.fft.rfft(record) / density**0.5)
    # Of one angle's error, what each whitened sample holds, by whitening a record of it alone.
    impulse = np.zeros(samples)
    impulse[:2] = 1, -1
    parts = np.abs(np.fft.irfft(np.fft.rfft(impulse) / density**0.5))
    boxes = tuple(3**0.5 * parts[parts > 0.02])
    assert contamination(calm, 0, boxes).p_value > 1e-3
    found = contamination(white, 0, boxes)
    low, high = np.quantile(found.draws, [0.001, 0.999], axis=0)
    assert found.boxes == boxes
    assert low[0] < 1e-3 < high[0]
    assert low[1] < 3 < high[1]
    # The peaks only: a fifth of the energy is beside them, which counts as fainter spikes.
    normal = contamination(white, 0)
    assert normal.gain < found.gain
    assert normal.fraction < 0.7 * found.fraction


def test_sum_of_uniform_values_has_its_moments_and_tail():
    """Cumulants of a uniform value: h^2/3, -2 h^4/15, 16 h^6/63; one alone is known exactly."""
    at = np.linspace(-12, 12, 24001)
    half = np.array([1.0, 1.0, 0.3])
    density = np.exp(log_body(at, 1.0, tuple(half)))
    second, fourth, sixth = (np.trapezoid(at**power * density, at) for power in (2, 4, 6))
    assert second == pytest.approx(1, rel=1e-4)
    kappa4, kappa6 = -2 / 15 * np.sum(half**4), 16 / 63 * np.sum(half**6)
    assert fourth == pytest.approx(3 + kappa4, rel=1e-4)
    assert sixth == pytest.approx(15 + 15 * kappa4 + kappa6, rel=1e-4)
    rest = (1 - 1.5**2 / 3) ** 0.5
    alone = (norm.sf((at - 1.5) / rest) - norm.sf((at + 1.5) / rest)) / 3.0
    near, far = np.abs(at) < 4, np.abs(at) > 8
    found = np.exp(log_body(at, 1.0, (1.5,)))
    assert found[near] == pytest.approx(alone[near], rel=1e-3)
    assert np.all(found[far] < np.exp(-(at[far] ** 2) / 2))


def test_spikes_that_are_not_there_may_have_any_size():
    """Of normal noise their size and share say nothing, and run away in opposite directions."""
    for seed in (0, 36):
        with np.errstate(over="raise"):
            found = contamination(np.random.default_rng(seed).standard_normal(400), 0)
        assert np.isfinite(found.draws).all()


def test_loud_times_are_found_to_some_samples(white):
    """A sample on the wrong side takes .22 from the log of the likelihood; a window has 64."""
    loud = np.ones(SAMPLES)
    loud[10_000:16_000] = 1.5
    found = modulation(white * loud, 0)
    assert found.p_value < 1e-20
    assert found.ratio == pytest.approx(1.5, abs=0.06)
    ((start, stop),) = runs(found.sharp().loud)
    assert abs(start - 10_000) < 40
    assert abs(stop - 16_000) < 40


def test_a_line_is_found_to_a_fraction_of_an_ordinate(white):
    frequency, amplitude = 0.1234567, 0.05
    line = amplitude * np.sin(2 * np.pi * frequency * np.arange(SAMPLES) + 0.3)
    peak = scan(white + line, 1e-3)[0]
    sine = refine(white + line, peak, 2.0)
    assert abs(sine.frequency - frequency) < 5 * sine.frequency_deviation
    # A^2 T/(2 S) for the known frequency, S = 2: within 5 of its deviations 2 sqrt(gain).
    assert abs(sine.gain - amplitude**2 * SAMPLES / 2) < 5 * 2 * np.sqrt(sine.gain)


def test_held_rounded_and_clipped_samples_are_known(white):
    rng = np.random.default_rng(4)
    fresh = np.where(rng.random(SAMPLES) < 0.25, np.arange(SAMPLES), 0)
    held = white[np.maximum.accumulate(fresh)]
    found = sample_format(held, ((0, SAMPLES),))
    assert found.repeat is not None
    assert abs(found.repeat.samples - 4.0) < 4 * found.repeat.deviation
    rounded = sample_format(np.round(white), ((0, SAMPLES),))
    assert rounded.coarse
    assert rounded.width == pytest.approx(1.0)
    clipped = sample_format(np.clip(white, -2, 2), ((0, SAMPLES),))
    assert set(clipped.rails) == {-2.0, 2.0}
    healthy = sample_format(white, ((0, SAMPLES),))
    assert (healthy.repeat, healthy.coarse, healthy.rails) == (None, False, ())


def test_codes_of_an_angle_are_told_from_codes_of_a_rate():
    """Differences of a rounded angle are coarse, and Q says all there is to say."""
    rng = np.random.default_rng(9)
    x, code = rng.standard_normal(SAMPLES), 0.8
    power = np.array([code**2 / 12, 1.0, 0.0, 0.0])
    for values, named in (
        (np.diff(np.round(np.cumsum(x) / code) * code), []),
        (np.round(x / code) * code, ["output_rounding"]),
    ):
        state = begin(values, ((0, values.size),), "point", power, 8e-4)
        assert state.format.coarse
        about_format(state)
        assert [finding.name for finding in state.findings] == named
        # N is the noise without its rounding, within five of its deviations.
        assert np.exp(state.model.theta[1]) == pytest.approx(1.0, abs=5 * np.sqrt(2 / SAMPLES))


@pytest.mark.parametrize("code", [1e-4, 0.05, 0.4])
def test_repeats_are_counted_less_those_of_rounding(code):
    """Of a share p held, 1/(1 - p) samples a value: the mean of 40 records, within 4 deviations."""
    rng, p, count = np.random.default_rng(8), 0.18, 20_000
    scores = []
    for _ in range(40):
        x = np.round(rng.standard_normal(count) / code) * code
        fresh = np.where(rng.random(count) >= p, np.arange(count), 0)
        found = sample_format(x[np.maximum.accumulate(fresh)], ((0, count),)).repeat
        assert found is not None
        scores.append((found.samples - 1 / (1 - p)) / found.deviation)
    assert abs(np.mean(scores)) < 4 / np.sqrt(40)
    # Of 40 normal ones the deviation is within 0.6 to 1.5 but for chances of 1e-5.
    assert 0.6 < np.std(scores) < 1.5


def test_uncorrelated_samples_that_are_not_independent_hide_no_change():
    """Uniform errors through an all-pass: the mean squares of windows scatter less than white ones.

    Half as much in variance, so that noise that is a little louder for a third of the time shows.
    """
    rng, size = np.random.default_rng(7), 100_000
    kernel = rng.standard_normal(300) * np.exp(-np.arange(300) / 5)
    phase = np.fft.rfft(kernel, size)
    louder = 1 + 0.025 * (np.arange(size) % 50_000 < 17_000)
    chances = []
    for _ in range(20):
        errors = rng.uniform(-(3**0.5), 3**0.5, size)
        white = np.fft.irfft(np.fft.rfft(errors) * phase / np.abs(phase))
        assert uneven(white)[0] > 1e-3
        chances.append(uneven(louder * white)[0])
    assert np.median(chances) < 1e-3


def test_where_noise_is_a_little_louder_is_told():
    """By 6 % in variance, in two stretches: 6.5 standard deviations in all."""
    rng, size = np.random.default_rng(8), 100_000
    loud = np.zeros(size, bool)
    loud[10_000:30_000] = loud[55_000:75_000] = True
    right, ratios = [], []
    for seed in range(20):
        found = modulation(np.where(loud, 1.06**0.5, 1.0) * rng.standard_normal(size), seed)
        right.append(np.mean(found.loud == loud))
        ratios.append(found.ratio)
    assert np.median(right) > 0.85
    assert np.min(right) > 0.5
    np.testing.assert_allclose(np.median(ratios), 1.06**0.5, atol=0.01)
