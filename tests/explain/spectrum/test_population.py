"""Draws of bent and narrow posteriors, against closed forms."""

import numpy as np
import pytest
from scipy.stats import norm

from allanfit.explain.spectrum._population import draw

# 4800 draws, of which a hundred at least count as independent: a quantile at 2.5 % of so many is
# within half a standard deviation, at 50 % within a quarter.
_LEVELS, _WITHIN = (0.025, 0.5, 0.975), np.array([0.5, 0.25, 0.5])


def _start(dimension, seed):
    """Points about the mode, a quarter as wide as the posterior is: it has to be found."""
    return 0.25 * np.random.default_rng(seed).normal(size=(1500, dimension))


def _apart(found, truth):
    """Of quantiles, in standard deviations."""
    return np.abs(np.quantile(found, _LEVELS) - truth) / (truth[2] - truth[0]) * 3.92


@pytest.mark.parametrize("seed", range(3))
def test_a_bent_ridge_is_followed_to_its_ends(seed):
    """The first coordinate is normal; the second follows its exponential within a third."""

    def log_density(x):
        return -0.5 * (x[:, 0] ** 2 + ((x[:, 1] - np.exp(x[:, 0]) + 1) / 0.3) ** 2)

    found = draw(log_density, _start(2, seed), seed)
    truth = norm.ppf(_LEVELS)
    assert np.all(_apart(found[:, 0], truth) < _WITHIN)
    # It is there, too, that the second belongs.
    assert np.std(found[:, 1] - np.exp(found[:, 0]) + 1) == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize("seed", range(3))
def test_wide_and_narrow_directions_of_eight(seed):
    """A correlated normal posterior whose widths are from a hundredth to thirty."""
    widths = np.geomspace(0.01, 30, 8)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(8, 8)))[0]

    def log_density(x):
        return -0.5 * np.sum((x @ turn / widths) ** 2, axis=1)

    # As wide as the posterior along each direction, within a factor.
    start = np.random.default_rng(seed).normal(size=(1500, 8)) * widths * 0.6 @ turn.T
    along = draw(log_density, start, seed) @ turn / widths
    for each in along.T:
        assert np.all(_apart(each, norm.ppf(_LEVELS)) < _WITHIN)


def test_the_same_seed_gives_the_same_draws():
    def log_density(x):
        return -0.5 * np.sum(x**2, axis=1)

    one, two, other = (draw(log_density, _start(3, 0), seed, quick=True) for seed in (1, 1, 2))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)
