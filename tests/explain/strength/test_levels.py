"""Two levels of noise that last, by all that they may be."""

import itertools

import numpy as np
import pytest

from allanfit.explain.strength import _levels
from allanfit.explain.strength._levels import levels_that_last, log_mean_ratio
from allanfit.explain.strength._modulation import modulation, uneven


def test_all_paths_between_two_levels_are_counted(monkeypatch):
    """By the sum over all 1024 of them, for each of the levels that may be."""
    monkeypatch.setattr(_levels, "_LASTING", (1 / 8, 1 / 2))
    monkeypatch.setattr(_levels, "_APART", (2.0, 5.0))
    windows, weight = 10, 50.0
    rng = np.random.default_rng(4)
    power = rng.chisquare(weight, windows) / weight * np.where(np.arange(windows) > 5, 1.3, 1.0)
    ratio, loud = log_mean_ratio(power, weight)

    normal = (power / power.mean()) ** (1 / 3) * 3 * np.sqrt(weight / 2)
    normal -= normal.mean()
    paths = np.array(list(itertools.product([0, 1], repeat=windows)))
    total, each = 0.0, np.zeros(windows)
    for louder, quieter, apart in itertools.product((1.25, 5.0), (1.25, 5.0), (2.0, 5.0)):
        share = louder / (louder + quieter)
        change = apart / np.sqrt(windows * share * (1 - share))
        stay = np.exp([-1 / quieter, -1 / louder])
        prior = np.where(paths[:, 0] == 1, share, 1 - share)
        for before, after in itertools.pairwise(paths.T):
            prior = prior * np.where(before == after, stay[before], 1 - stay[before])
        mean = np.where(paths == 1, (1 - share) * change, -share * change)
        odds = prior * np.exp(np.sum(mean * normal - mean**2 / 2, axis=1))
        total += odds.sum()
        each += odds @ paths
    assert ratio == pytest.approx(np.log(total / 8))
    np.testing.assert_allclose(loud, each / total)


@pytest.mark.parametrize(("windows", "freedom"), [(64, 32), (256, 1000)])
def test_chance_makes_levels_as_rarely_as_stated(windows, freedom):
    """Of 1500 records 15 may be odder than one in a hundred, and 29 are three deviations more."""
    rng = np.random.default_rng(8)
    power = rng.chisquare(freedom, (1500, windows)) / freedom
    chances = np.array([levels_that_last(each, float(freedom)).p_value for each in power])
    assert np.sum(chances < 0.01) < 27
    # It is not without use either.
    assert np.sum(chances < 0.1) > 75


def test_levels_are_found_that_windows_do_not_show():
    """One tenth of the record, five standard deviations louder to one who knew when."""
    samples, rng = 100_000, np.random.default_rng(11)
    by_windows, by_either, right = 0, 0, []
    for _ in range(60):
        begin = rng.integers(samples * 9 // 10)
        course = np.zeros(samples)
        course[begin : begin + samples // 10] = 1.0
        excess = np.sqrt(50 / (samples * np.var(course)))
        white = rng.standard_normal(samples) * np.sqrt(1 + excess * course)
        white /= white.std()
        told = modulation(white, 0)
        by_windows += uneven(white)[0] < 0.0008
        if told.p_value < 0.0008:
            by_either += 1
            right.append(np.mean(course[told.loud]))
    assert by_windows <= 24
    assert by_either >= by_windows + 4
    # What is said to be loud mostly is.
    assert np.median(right) > 0.75


def test_too_few_samples_have_no_levels():
    white = np.random.default_rng(3).standard_normal(2000)
    assert modulation(white, 0).p_value == min(1.0, 4 * uneven(white)[0])
