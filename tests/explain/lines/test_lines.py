"""Which peaks of a spectrum are sinusoids."""

import numpy as np
import pytest

from allanfit.explain._investigate import investigate
from allanfit.explain._rounds import take_one
from allanfit.explain._state import begin
from allanfit.explain.lines._lines import line_log_chance, scan
from allanfit.explain.lines._taken import line_options

SAMPLES = 16_384
ALARM = 0.0008


def lines_of(values: np.ndarray) -> tuple[list[float], int]:
    """Frequencies of the sinusoids named after two rounds, and the number of broad bands."""
    white = np.array([0.0, np.var(values), 0.0, 0.0])
    state = begin(values, ((0, values.size),), "point", white, ALARM)
    for _ in range(2):
        if not take_one(state, {}):
            break
    lines = [c.shape["frequency"] for c in state.courses if c.name == "sinusoid"]
    return lines, len(state.peaks)


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_a_strong_line_is_a_sinusoid_wherever_it_falls(offset):
    """On an ordinate and between two, where its power leaks into a dozen others."""
    frequency = (3000 + offset) / SAMPLES
    time = np.arange(SAMPLES)
    x = np.random.default_rng(1).standard_normal(SAMPLES) + np.cos(2 * np.pi * frequency * time)
    lines, bands = lines_of(x)
    assert lines == pytest.approx([frequency], abs=0.1 / SAMPLES)
    assert bands == 0


def test_a_line_that_wanders_is_no_sinusoid():
    rng = np.random.default_rng(2)
    time = np.arange(SAMPLES)
    frequency = 0.2 + 0.002 * np.sin(2 * np.pi * time / 5000)
    x = rng.standard_normal(SAMPLES) + np.cos(2 * np.pi * np.cumsum(frequency))
    lines, bands = lines_of(x)
    assert lines == []
    assert bands > 0


def test_a_line_far_above_the_noise_hides_nothing_and_makes_nothing_up():
    """What it leaks once was a knock, noise that changes and outliers. Hum with a harmonic."""
    time = np.arange(SAMPLES)
    x = np.random.default_rng(3).standard_normal(SAMPLES)
    x += 40 * np.sin(2 * np.pi * 0.123 * time + 1) + 12 * np.sin(2 * np.pi * 0.246 * time)
    power = np.array([0.0, np.var(x), 0.0, 0.0])
    state = investigate(x, ((0, SAMPLES),), "point", power)
    assert {finding.name for finding in state.findings} == {"sinusoid"}
    assert sorted(c.shape["frequency"] for c in state.courses) == pytest.approx([0.123, 0.246])
    assert np.exp(state.model.theta[1] / 2) == pytest.approx(1, abs=0.03)


def test_a_line_is_one_across_gaps_of_unknown_length():
    """Where a log is closed up its phase jumps, and it looked like a line that wanders."""
    rng = np.random.default_rng(4)
    ends = np.array([0, 5000, 9000, SAMPLES])
    phase = np.repeat(rng.uniform(0, 2 * np.pi, 3), np.diff(ends))
    x = rng.standard_normal(SAMPLES)
    x += 0.3 * np.sin(2 * np.pi * 0.123 * np.arange(SAMPLES) + phase)
    pieces = tuple(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))
    state = investigate(x, pieces, "point", np.array([0.0, np.var(x), 0.0, 0.0]))
    assert [finding.name for finding in state.findings] == ["sinusoid"]
    assert state.sized is not None
    # Four standard deviations.
    assert np.hypot(*state.sized.sizes) == pytest.approx(0.3, abs=4 * np.sqrt(2 / SAMPLES))


def test_a_line_is_one_where_samples_are_lost_at_known_places():
    """Each loss turns its phase, and it looked like a resonance."""
    rng = np.random.default_rng(5)
    time = np.delete(np.arange(SAMPLES + 60), rng.choice(SAMPLES, 60, replace=False))
    x = rng.standard_normal(SAMPLES) + 0.3 * np.sin(2 * np.pi * 0.323 * time)
    after = 1 + np.flatnonzero(np.diff(time) > 1)
    losses = [(int(at), int(time[at] - time[at - 1] - 1)) for at in after]
    white = np.array([0.0, np.var(x), 0.0, 0.0])
    state = investigate(x, ((0, SAMPLES),), "point", white, lost=60 / time[-1], losses=losses)
    assert [finding.name for finding in state.findings] == ["dropped_samples", "sinusoid"]
    assert state.sized is not None
    assert np.hypot(*state.sized.sizes) == pytest.approx(0.3, abs=4 * np.sqrt(2 / SAMPLES))
    assert state.lines[0].shape["frequency"] == pytest.approx(0.323, abs=0.1 / SAMPLES)


def test_noise_has_as_strong_a_band_as_seldom_as_said():
    """One record in ten at most: of 600 more than 78 by chance of .01."""
    rng = np.random.default_rng(5)
    peaks = [scan(rng.standard_normal(4000), 0.1) for _ in range(600)]
    seen = sum(bool(found) for found in peaks)
    assert 30 < seen <= 78


@pytest.mark.parametrize("samples", [4000, 400_000])
def test_all_frequencies_share_the_chance_of_a_false_alarm(samples):
    """Ordinates are each exponential: their chances at an alarm of p add up to p."""
    orders = np.arange(100, samples // 2 + 1)
    # 2.2 places an ordinate between them, which is what the search between ordinates costs.
    each = np.exp([line_log_chance(40.0, order / samples, samples) + 40.0 for order in orders])
    assert np.sum(2.2 / each) == pytest.approx(1, abs=0.03)


def test_a_scan_says_that_it_is_of_what_known_lines_leave():
    """White noise and a sinusoid of an eighth of its power: its own chance, then that of no more.

    The second p-value is below 1 % by chance once in 100 records; seed fixed.
    """
    rng, samples = np.random.default_rng(9), 8192
    values = rng.standard_normal(samples)
    values += 0.5 * np.sin(2 * np.pi * 0.123 * np.arange(samples) + 1.0)
    state = begin(values, ((0, samples),), "point", np.array([0.0, 1.0, 0.0, 1e-12]), 0.01)
    (option,) = line_options(state)
    (before,) = (each for each in state.witnesses if each["name"] == "lines")
    assert before["p_value"] < 1e-9
    assert before["sentence"].endswith("scanned for narrow bands.")
    option.take({})
    assert line_options(state) == []
    (after,) = (each for each in state.witnesses if each["name"] == "lines")
    assert after["p_value"] > 0.01
    assert after["sentence"].endswith("narrow bands beside those that are known already.")
