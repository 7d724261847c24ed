"""Least squares against a dense search, finite differences and itself."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import digamma, polygamma
from scipy.stats import chi2, gamma

from allanfit.curves import design
from allanfit.identify._goodness import goodness_of_fit, score
from allanfit.identify._least_squares import least_squares
from allanfit.identify._likelihood import deviance_residuals, fisher_information, log_likelihood

LAYOUT = design((4096,))
EXPECTED = jnp.asarray(LAYOUT.density)
SHAPE = jnp.asarray(LAYOUT.ordinates / 2)
LEVEL = np.exp(np.mean(np.log(LAYOUT.density), axis=0))


# Compiled once for all tests: one spectrum, and a thousand.
solve = jax.jit(least_squares)
solve_many = jax.jit(jax.vmap(least_squares, (0, None, None)))
residuals = jax.jit(deviance_residuals)


def spectra(power, records, seed=0):
    mean, shape = np.asarray(power) @ LAYOUT.density.T, LAYOUT.ordinates / 2
    random = np.random.default_rng(seed)
    return jnp.asarray(random.gamma(shape, mean / shape, (records, len(shape))))


def test_sum_of_squares_is_twice_the_log_likelihood_ratio():
    power, density = jnp.array([0.1, 1.0, 0.3, 0.01]), spectra([0.1, 1.0, 0.3, 0.01], 1)[0]
    squares = np.square(residuals(power, density, EXPECTED, SHAPE))
    mean = np.asarray(EXPECTED @ power)
    a, y = np.asarray(SHAPE), np.asarray(density)
    perfect = gamma.logpdf(y, a, scale=y / a)
    np.testing.assert_allclose(squares, 2 * (perfect - gamma.logpdf(y, a, scale=mean / a)), 1e-8)


def test_residuals_are_smooth_through_the_perfect_fit():
    mean = jnp.array([1.0])

    def residual(y):
        return deviance_residuals(jnp.array([1.0]), jnp.array([y]), mean[:, None], jnp.array([2.0]))

    y = jnp.linspace(0.9, 1.1, 2001)
    values = np.asarray(jax.jit(jax.vmap(lambda v: residual(v)[0]))(y))
    assert np.abs(np.diff(values, 2)).max() < 1e-7  # no jump where the series hands over


def test_fisher_information_is_the_expected_curvature():
    power = jnp.array([0.2, 1.0, 0.3, 0.01]) / LEVEL
    mean = EXPECTED @ power
    hessian = jax.jit(jax.hessian(lambda p: -log_likelihood(p, mean, EXPECTED, SHAPE)))(power)
    np.testing.assert_allclose(fisher_information(power, EXPECTED, SHAPE), hessian, rtol=1e-6)


@jax.jit
@jax.value_and_grad
def deviance_and_slope(power, density, expected):
    return jnp.sum(deviance_residuals(power, density, expected, SHAPE) ** 2)


@pytest.mark.parametrize("seed", range(3))
def test_no_search_from_many_starts_does_better(seed):
    """Wrong optima would show as a lower value found by L-BFGS-B from some of 12 starts."""
    rng = np.random.default_rng(seed)
    power = 10.0 ** rng.uniform(-6, 0, 4) * rng.integers(0, 2, 4)
    power[1] += 1e-2
    density = spectra(power / LEVEL, 1, seed)[0]
    scaled = EXPECTED / LEVEL
    found = solve(density, scaled, SHAPE)
    best = min(
        minimize(
            lambda p: tuple(np.asarray(v, float) for v in deviance_and_slope(p, density, scaled)),
            10.0 ** rng.uniform(-6, 1, 4),
            jac=True,
            method="L-BFGS-B",
            bounds=[(1e-12, None)] * 4,
        ).fun
        for _ in range(12)
    )
    assert bool(found.converged)
    assert float(found.deviance) <= best + 1e-4


def test_a_thousand_odd_spectra_end_at_their_optimum():
    """At the optimum no coefficient wants to move: zero ones have a non-positive score."""
    random = np.random.default_rng(3)
    power = 10 ** random.uniform(-7, 0, (1000, 4)) * random.binomial(1, 0.6, (1000, 4))
    power[:, 1] += 1e-4
    density = spectra(power / LEVEL, 1000, seed=4)
    found = solve_many(density, EXPECTED, SHAPE)
    scores_of = jax.jit(jax.vmap(score, (0, 0, None, None)))
    scores = np.asarray(scores_of(found.power, density, EXPECTED, SHAPE))
    assert np.all(found.converged)
    zero = np.asarray(found.power) == 0
    assert np.max(scores, where=zero, initial=-np.inf) < 1e-3
    assert np.max(np.abs(scores), where=~zero, initial=0.0) < 1e-3


def test_derivative_equals_finite_differences():
    density = spectra(np.array([0.0, 1.0, 0.1, 0.01]) / LEVEL, 1, seed=5)[0]

    def power(y):
        return solve(y, EXPECTED, SHAPE).power

    jacobian = jax.jit(jax.jacrev(power))(density)
    for b in (5, 20, len(density) - 1):
        step = 1e-2 * density[b]
        difference = (power(density.at[b].add(step)) - power(density.at[b].add(-step))) / (2 * step)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(jacobian[:, b], difference, atol=1e-3 * scale)


def test_goodness_of_fit_is_uniform_under_the_model():
    """KS over 1000 spectra at N = 4096; false alarm 0.001, seeded."""
    density = spectra(np.array([0.0, 1.0, 0.3, 0.03]) / LEVEL, 1000, seed=6)
    found = solve_many(density, EXPECTED, SHAPE)
    fitted = np.sum(np.asarray(found.power) > 0, axis=1).astype(float)
    p = jax.vmap(goodness_of_fit, (0, None, 0))(found.deviance, SHAPE, fitted)
    distance = np.abs(np.sort(p) - (np.arange(1000) + 0.5) / 1000).max()
    assert distance < 1.95 / np.sqrt(1000)


def test_goodness_of_fit_keeps_its_digits_in_float32():
    """At shapes whose logarithm has none left for the difference to the digamma function."""
    shape = np.geomspace(0.5, 1e6, 60)
    mean = np.sum(2 * shape * (np.log(shape) - digamma(shape))) - 4
    variance = np.sum(4 * shape**2 * (polygamma(1, shape) - 1 / shape)) - 8
    expected = chi2.sf(2 * mean / variance * 70, 2 * mean**2 / variance)
    with jax.enable_x64(False):
        found = goodness_of_fit(
            jnp.asarray(70.0, jnp.float32), jnp.asarray(shape, jnp.float32), jnp.float32(4.0)
        )
    np.testing.assert_allclose(found, expected, rtol=1e-3)
