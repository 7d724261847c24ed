"""Spikes among noise, and those of which only the ones beyond some reach are told."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import expit
from scipy.stats import norm, t

from allanfit.explain.values._contamination import (
    LAWS,
    _densities,
    _spike_slopes,
    beyond,
    contamination,
    in_units,
    log_body,
    unseen,
)

SAMPLES = 300_000


def drawn(seed: int, fraction: float, size: float, reach: float, samples: int = SAMPLES):
    rng = np.random.default_rng(seed)
    hit = rng.random(samples) < fraction
    values = np.abs(rng.standard_normal(samples) + hit * size * rng.standard_normal(samples))
    return values[values > reach], values[values <= reach]


def test_those_within_are_counted_by_those_beyond():
    """Of 40 sets 95 % intervals hold 34 times at least: fewer by chance of .01 or less."""
    held = np.zeros(2, int)
    for seed in range(40):
        far, _ = drawn(seed, 2e-3, 5.0, 5.5)
        found = beyond(far, 5.5, SAMPLES, seed)
        low, high = np.quantile(found.draws[:, :2], [0.025, 0.975], axis=0)
        held += (low < [2e-3, 5.0]) & (high > [2e-3, 5.0])
    assert held.min() >= 34


def test_what_is_unseen_is_the_variance_that_they_add_within():
    far, near = drawn(1, 2e-3, 5.0, 5.5, 3_000_000)
    found = beyond(far, 5.5, 3_000_000, 0)
    # The mean square of so many is known to .0008, and the spikes to some per cent.
    added = float(np.mean(near**2)) - 1
    assert unseen(found) == pytest.approx(added, abs=0.003)
    assert added > 0.006


def test_units():
    far, _ = drawn(2, 2e-3, 5.0, 5.5)
    found = beyond(far, 5.5, SAMPLES, 0)
    other = in_units(found, 4.0)
    assert other.amplitude == pytest.approx(found.amplitude / 4)
    assert other.threshold == pytest.approx(5.5 / 4)
    assert unseen(other) == pytest.approx(unseen(found) / 16, rel=1e-3)


def normal_body(x, width):
    return norm.pdf(x, scale=width)


def rounded_body(x, width):
    """Of a normal value and one uniform within 1.4 of the sum's deviations, of which it has .65."""
    half, rest = 1.4 * width, width * np.sqrt(1 - 1.4**2 / 3)
    return (norm.cdf((x + half) / rest) - norm.cdf((x - half) / rest)) / (2 * half)


@pytest.mark.parametrize("body", [normal_body, rounded_body])
@pytest.mark.parametrize("heavy", [False, True])
def test_they_are_the_likeliest(body, heavy):
    """Against a search without derivatives, on the values themselves and with SciPy's densities."""
    rng, samples = np.random.default_rng(3), 20_000
    boxes = () if body is normal_body else (1.4,)
    values = rng.standard_normal(samples)
    if boxes:
        values *= np.sqrt(1 - 1.4**2 / 3)
        values += rng.uniform(-1.4, 1.4, samples)
    hit = rng.random(samples) < 0.01
    values[hit] += 6.0 * (rng.standard_t(2, hit.sum()) if heavy else rng.standard_normal(hit.sum()))

    def negative(three):
        fraction, size, core = expit(three[0]), np.exp(three[1]), np.exp(three[2])
        wide = np.hypot(size, core)
        spike = t.pdf(values, 2, scale=wide) if heavy else norm.pdf(values, scale=wide)
        return -np.log((1 - fraction) * body(values, core) + fraction * spike).sum()

    start = np.log([0.01, 6.0, 1.0])
    best = minimize(negative, start, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-6})
    found = contamination(values, 0, boxes)
    assert (found.heavy, found.boxes) == (heavy, boxes)
    expected = expit(best.x[0]), np.exp(best.x[1]), np.exp(best.x[2])
    # Of what the data leave open the bins of the body take a tenth at most.
    margin = found.draws.std(axis=0) / 10
    assert np.all(np.abs(np.array(found[:3]) - expected) < margin), (found[:3], expected, margin)


def flipped(seed: int, fraction: float, size: float):
    """Normal values of which some are off by about the same, up or down."""
    rng = np.random.default_rng(seed)
    values, hit = rng.standard_normal(SAMPLES), rng.random(SAMPLES) < fraction
    sign = rng.choice([-1.0, 1.0], hit.sum())
    values[hit] += size * sign * rng.uniform(0.85, 1.15, hit.sum())
    return values, float(hit.mean())


def test_spikes_that_are_alike_leave_none_within_the_noise():
    """Of 40 sets 95 % intervals hold 34 times at least: fewer by chance of .01 or less.

    Of normal spikes of that size more than half would be within the reach.
    """
    held = np.zeros((2, 2), int)
    for seed in range(40):
        values, _ = flipped(seed, 3e-4, 7.0)
        far = np.abs(values[np.abs(values) > 5.5])
        for i, found in enumerate((contamination(values, seed), beyond(far, 5.5, SAMPLES, seed))):
            assert found.law == "alike"
            low, high = np.quantile(found.draws[:, :2], [0.025, 0.975], axis=0)
            held[i] += (low < [3e-4, 7.0]) & (high > [3e-4, 7.0])
    assert held.min() >= 34


@pytest.mark.parametrize("law", ["normal", "alike"])
def test_a_law_is_told_by_some_tens(law):
    rng = np.random.default_rng(7)
    for seed in range(10):
        values, _ = flipped(seed, 3e-4 * (law == "alike"), 8.0)
        if law == "normal":
            hit = rng.random(SAMPLES) < 3e-4
            values[hit] += 8.0 * rng.standard_normal(hit.sum())
        assert contamination(values, seed).law == law


@pytest.mark.parametrize("law", LAWS)
def test_slopes_are_those_of_the_density(law):
    at, small = np.linspace(0.1, 20.0, 200), 1e-5
    size, core = np.full(2, 7.0), np.full(2, 1.1)
    for i, slope in enumerate(_spike_slopes((1e-3, 7.0, 1.1), law, at)):
        change = np.exp([small, -small])
        sizes, cores = (size * change, core) if i == 0 else (size, core * change)
        up, down = (
            np.log(_densities((1e-3, *each), law, (), at)[1])
            for each in zip(sizes, cores, strict=True)
        )
        np.testing.assert_allclose(slope, (up - down) / (2 * small), atol=1e-6)


def test_few_spikes_leave_open_whether_they_are_alike():
    """Of some thirty normal ones ten are seen. Five of 40 or more miss by chance of .05."""
    held, open_ones, named = np.zeros(2, int), 0, 0
    for seed in range(40):
        rng = np.random.default_rng((9, seed))
        values, hit = rng.standard_normal(SAMPLES), rng.random(SAMPLES) < 1e-4
        values[hit] += 4 * rng.standard_normal(hit.sum())
        found = contamination(values, seed)
        if found.p_value < 1e-3:
            named += 1
            low, high = np.quantile(found.draws[:, :2], [0.025, 0.975], axis=0)
            held += (low < [1e-4, 4.0]) & (high > [1e-4, 4.0])
            open_ones += len(np.unique(found.drawn_by)) == 2
    assert held.min() >= named - 4
    assert open_ones > 10


def test_a_body_of_no_width_explains_nothing():
    """Beyond the grid of a body that is partly uniform there is nothing, however narrow it is."""
    values = np.random.default_rng(5).standard_normal(1000)
    boxes = (1.0, 0.5)
    assert np.all(log_body(values, 1e-131, boxes) < log_body(values, 1.0, boxes))
