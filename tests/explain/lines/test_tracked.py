"""A line that wanders against normal noise of its spectrum, by its phase."""

from itertools import groupby, pairwise, product

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import i0, ive

from allanfit.explain._investigate import investigate
from allanfit.explain.lines._moments import moments
from allanfit.explain.lines._tracked import narrow_band, normal_likelihood, tracked
from allanfit.explain.spectrum._narrow import narrow_noises

# Samples of a band; a line's width is a seventh of it.
BAND = 700
MIDDLE, WIDTH = 0.5, 1 / 7


def white(rng: np.random.Generator, size: int = BAND) -> np.ndarray:
    return (rng.standard_normal(size) + 1j * rng.standard_normal(size)) / np.sqrt(2)


def excess_of(power: float) -> np.ndarray:
    """A line's spectrum, as if it were noise."""
    about = (np.arange(BAND) / BAND - MIDDLE) / WIDTH
    return power * np.exp(-(about**2) / 2) / np.sqrt(2 * np.pi) / WIDTH


def likelihood(band: np.ndarray, middle: float, width: float, power: float) -> float:
    return tracked(band, middle, width, power).log_likelihood


def gain(band: np.ndarray, power: float) -> float:
    return likelihood(band, MIDDLE, WIDTH, power) - normal_likelihood(band, excess_of(power))


def test_a_frequency_that_stays_is_a_coherent_sum():
    """Known but for its phase: exp(-n p) I0(2 sqrt(p) |sum|) (Rice 1945, Bell Syst. Tech. J.)."""
    z = white(np.random.default_rng(1), 40)
    frequency, power = 12 / 32, 0.3
    total = np.abs(np.sum(z * np.exp(-2j * np.pi * frequency * np.arange(z.size))))
    expected = np.log(i0(2 * np.sqrt(power) * total)) - z.size * power
    np.testing.assert_allclose(likelihood(z, frequency, 1e-6, power), expected, rtol=1e-7)


def test_a_line_may_be_a_thousand_times_as_strong_as_the_noise():
    """As a coherent sum again; its phase at each of 32 steps costs part of so strong a line."""
    frequency, power = 12 / 32, 1e6
    z = white(np.random.default_rng(5), 40)
    z += np.sqrt(power) * np.exp(2j * np.pi * frequency * np.arange(z.size))
    total = 2 * np.sqrt(power) * np.abs(np.sum(z * np.exp(-2j * np.pi * frequency * np.arange(40))))
    expected = total + np.log(ive(0, total)) - z.size * power
    np.testing.assert_allclose(likelihood(z, frequency, 1e-6, power), expected, rtol=1e-4)


def test_a_line_that_is_switched_is_the_sum_over_all_times_at_which_it_may_be():
    """On one frequency, of each of 2^9 courses: a coherent sum of each time on, and their odds."""
    z = white(np.random.default_rng(6), 9)
    frequency, power, part = 12 / 32, 0.7, 0.25
    turned = z * np.exp(-2j * np.pi * frequency * np.arange(z.size))
    goes, comes = min(4 / z.size / part, 0.5), min(4 / z.size / (1 - part), 0.5)
    odds = {(1, 1): 1 - goes, (1, 0): goes, (0, 1): comes, (0, 0): 1 - comes}
    expected = 0.0
    for course in product((0, 1), repeat=z.size):
        likelihood = part if course[0] else 1 - part
        for step in pairwise(course):
            likelihood *= odds[step]
        for on, times in groupby(range(z.size), key=lambda at: course[at]):
            if on:
                values = turned[list(times)]
                squared = power / part
                coherent = i0(2 * np.sqrt(squared) * np.abs(values.sum()))
                likelihood *= np.exp(-values.size * squared) * coherent
        expected += likelihood
    found = tracked(z, frequency, 1e-6, power, on=(part,), changes=8.0).log_likelihood
    np.testing.assert_allclose(found, np.log(expected), rtol=1e-6)


def test_on_average_white_noise_is_no_likelier_to_be_a_line():
    """The mean of a likelihood ratio is one under the other hypothesis; false alarm .003."""
    rng = np.random.default_rng(2)
    ratios = [np.exp(likelihood(white(rng, 60), 0.5, 0.1, 0.02)) for _ in range(300)]
    assert abs(np.mean(ratios) - 1) < 3 * np.std(ratios) / np.sqrt(300)


def test_on_average_white_noise_is_no_likelier_to_be_a_resonance():
    rng = np.random.default_rng(3)
    excess = np.full(60, 0.05)
    ratios = [np.exp(normal_likelihood(white(rng, 60), excess)) for _ in range(300)]
    assert abs(np.mean(ratios) - 1) < 3 * np.std(ratios) / np.sqrt(300)


def test_a_line_is_told_from_noise_of_its_spectrum():
    """At a quarter of the white noise's power: each of 10 by more than chance, seeds fixed."""
    rng, power = np.random.default_rng(4), 0.25
    kept = np.exp(-1 / 60)
    for _ in range(10):
        drift = lfilter([np.sqrt(1 - kept**2)], [1, -kept], rng.standard_normal(BAND + 500))[500:]
        frequency = MIDDLE + WIDTH * drift
        line = np.sqrt(power) * np.exp(2j * np.pi * (np.cumsum(frequency) + rng.random()))
        assert gain(line + white(rng), power) > 3
        # Normal noise of that spectrum, by its coefficients.
        noise = np.fft.ifft(np.sqrt(excess_of(power) * BAND) * white(rng))
        assert gain(noise + white(rng), power) < -1


def test_a_line_that_is_switched_is_told_from_lines_that_stay_and_from_noise():
    """On for four times of ten, with a phase of its own each; ten of each, seeds fixed."""
    rng, power = np.random.default_rng(8), 0.4
    kept = np.exp(-1 / 60)

    def switched(band: np.ndarray) -> float:
        on = (0.25, 0.5, 0.75)
        found = tracked(band, MIDDLE, WIDTH, power, on=on, changes=8.0).log_likelihood
        normal = normal_likelihood(band, excess_of(power))
        leaps = tracked(band, MIDDLE, WIDTH, power, changes=8.0).log_likelihood
        return found - max(normal, leaps, likelihood(band, MIDDLE, WIDTH, power))

    time = np.arange(BAND)
    for _ in range(10):
        drift = lfilter([np.sqrt(1 - kept**2)], [1, -kept], rng.standard_normal(BAND + 500))[500:]
        turned = np.exp(2j * np.pi * np.cumsum(MIDDLE + WIDTH * drift))
        on = (time % 250 > 60) & (time % 250 < 160)
        phases = np.exp(2j * np.pi * rng.random(3))[time // 250]
        assert switched(np.sqrt(power / on.mean()) * on * phases * turned + white(rng)) > 3
        # What is told as one is nineteen times as likely.
        assert switched(np.sqrt(power) * turned + white(rng)) < np.log(19)
        noise = np.fft.ifft(np.sqrt(excess_of(power) * BAND) * white(rng))
        assert switched(noise + white(rng)) < 0


def test_a_band_is_white_and_its_lines_stand_where_they_are():
    x = np.random.default_rng(5).standard_normal(100_000)
    band = narrow_band(x, 0.2, 0.22)
    # Of 2000 exponential variates the mean is one within four times 1/sqrt(2000).
    assert abs(np.mean(np.abs(band) ** 2) - 1) < 4 / np.sqrt(band.size)
    turned = narrow_band(np.cos(2 * np.pi * 0.205 * np.arange(100_000)), 0.2, 0.22)
    assert np.argmax(np.abs(np.fft.fft(turned))) == round(0.25 * turned.size)


def test_explain_tells_lines_from_resonances_of_one_spectrum():
    """Two records whose spectra are alike: of width .0004 about a tenth of the rate."""
    rng, samples = np.random.default_rng(9), 60_000
    noise = rng.standard_normal((2, samples))
    kept = np.exp(-1 / 3000)
    drift = lfilter([np.sqrt(1 - kept**2)], [1, -kept], rng.standard_normal(2 * samples))[samples:]
    frequency = 0.1 + 0.0004 * drift
    line = 0.13 * np.cos(2 * np.pi * np.cumsum(frequency))
    # A pole whose half-width is that of the line's core.
    pole = np.exp(-2 * np.pi * 0.0004 + 2j * np.pi * 0.1)
    ringing = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], noise[1])
    ringing *= 0.13 / np.sqrt(2) / np.std(ringing)
    for signal, name in ((line, "drifting_line"), (ringing, "resonance")):
        values = noise[0] + signal
        state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 0.0]))
        assert state.model.kinds.added == (name,)
        assert state.findings[0].name == name


@pytest.mark.parametrize("lasts", [10.0, 100.0])
def test_how_long_a_frequency_lasts(lasts):
    """Of a clear line, on average of 8 and within a factor of two: memories are three apart."""
    rng, kept = np.random.default_rng(11), np.exp(-1 / lasts)
    logs = []
    for _ in range(8):
        drive = rng.standard_normal(BAND + 2000)
        drift = lfilter([np.sqrt(1 - kept**2)], [1, -kept], drive)[2000:]
        line = np.exp(2j * np.pi * np.cumsum(MIDDLE + WIDTH * drift))
        logs.append(np.log(tracked(line + white(rng), MIDDLE, WIDTH, 1.0).memory / lasts))
    assert abs(np.mean(logs)) < np.log(2)


def test_moments_are_those_of_where_a_line_was():
    """On one frequency for two thirds of the time and on another for the rest, going over slowly.

    No normal distribution: its peak, fitted, is led by the shape. Moments know it to a per cent.
    """
    rng, samples = np.random.default_rng(12), 60_000
    there = np.clip((np.arange(samples) - 38_000) / 4_000, 0, 1)
    frequency = 0.1 + 0.0008 * there + 5e-5 * np.sin(np.arange(samples) / 2_000)
    values = rng.standard_normal(samples) + 0.5 * np.sin(2 * np.pi * np.cumsum(frequency))
    state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 0.0]))
    (line,) = narrow_noises(state.model, float(samples))
    found = moments(state, line)
    assert found.square[0] == pytest.approx(0.5**2, rel=0.02)
    assert found.mean[0] == pytest.approx(frequency.mean(), abs=2e-5)
    assert found.width[0] == pytest.approx(frequency.std(), rel=0.03)
    for told, error in zip(found, (0.02, 2e-5, 0.03 * frequency.std()), strict=True):
        assert told[1] < error


def test_a_line_that_wanders_is_no_knock_where_it_seldom_is():
    """Ten times as strong as its mean spectrum there, for some seconds: 2 records, seeds fixed."""
    kept, samples = np.exp(-1 / 5000), 60_000
    for seed in (2, 6):
        rng = np.random.default_rng((22, seed))
        drive = np.sqrt(1 - kept**2) * rng.standard_normal(2 * samples)
        drift = lfilter([1.0], [1.0, -kept], drive)[samples:]
        values = rng.standard_normal(samples)
        values += 1.5 * np.sin(2 * np.pi * np.cumsum(0.15 + 0.0008 * drift))
        state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 1e-9]))
        assert not state.knocks
        assert {finding.name for finding in state.findings} == {"drifting_line"}


def test_knocks_beside_a_line_that_wanders_are_those_that_were():
    """Two knocks that ring for 200 samples, and a line that seldom is where it is for 4000."""
    kept, samples = np.exp(-1 / 5000), 100_000
    rng = np.random.default_rng((79, 5))
    drive = np.sqrt(1 - kept**2) * rng.standard_normal(2 * samples)
    drift = lfilter([1.0], [1.0, -kept], drive)[samples:]
    values = rng.standard_normal(samples)
    values += 1.5 * np.sin(2 * np.pi * np.cumsum(0.15 + 0.0008 * drift))
    ringing = 12 * np.exp(-np.arange(2000) / 200)
    for at, frequency in ((30_000, 0.3), (70_000, 0.38)):
        values[at : at + 2000] += ringing * np.sin(2 * np.pi * frequency * np.arange(2000))
    state = investigate(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 1e-9]))
    assert {finding.name for finding in state.findings} == {"disturbance", "drifting_line"}
    assert [(a < 30_200 < b, a < 70_200 < b) for a, b in state.knocks] == [
        (True, False),
        (False, True),
    ]
