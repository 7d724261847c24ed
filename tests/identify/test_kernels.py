"""emcee's move to where other draws are: the posterior is that of the target, not of the draws."""

import emcee
import numpy as np
import pytest

from allanfit.identify._kernels import kernel_move, kernels

_STEPS = 4000


def _chain(log_density, draws, start, seed):
    sampler = emcee.EnsembleSampler(
        len(start), start.shape[1], log_density, vectorize=True, moves=kernel_move(kernels(draws))
    )
    state = emcee.State(start, random_state=np.random.RandomState(seed).get_state())
    state = sampler.run_mcmc(state, 200)
    sampler.reset()
    sampler.run_mcmc(state, _STEPS)
    return sampler


@pytest.mark.parametrize(("shift", "spread"), [(0.0, 1.0), (0.4, 1.1), (-0.5, 1.6)])
def test_draws_of_another_distribution_leave_the_posterior_as_it_is(shift, spread):
    """Mean and covariance of a correlated normal target, by closed form.

    Some tens of thousands of independent draws stand behind each: 0.06 is over five of their
    standard errors.
    """
    rng = np.random.default_rng(1)
    covariance = np.array([[1.0, 0.8, 0.0], [0.8, 2.0, -0.5], [0.0, -0.5, 1.0]])
    inverse = np.linalg.inv(covariance)
    draws = shift + spread * rng.multivariate_normal(np.zeros(3), np.eye(3), size=2000)

    def log_density(x):
        return -0.5 * np.einsum("wi,ij,wj->w", x, inverse, x)

    sampler = _chain(log_density, draws, rng.normal(size=(16, 3)), seed=2)
    flat = sampler.get_chain(flat=True)
    assert np.abs(flat.mean(axis=0)).max() < 0.06
    assert np.abs(np.cov(flat.T) - covariance).max() < 0.06 * 2


def test_most_proposals_are_taken_where_the_draws_are_of_the_posterior():
    """Of a skewed target that is no normal one: two exponential variates."""
    rng = np.random.default_rng(3)
    draws = rng.exponential(size=(3000, 2))

    def log_density(x):
        return np.where(np.all(x > 0, axis=1), -x.sum(axis=1), -np.inf)

    sampler = _chain(log_density, draws, rng.exponential(size=(16, 2)), seed=4)
    assert np.mean(sampler.acceptance_fraction) > 0.4
    # Of 64,000 draws; the quantiles are -ln(1 - p).
    found = np.quantile(sampler.get_chain(flat=True), [0.025, 0.5, 0.975], axis=0)
    truth = -np.log1p(-np.array([0.025, 0.5, 0.975]))[:, None]
    assert np.abs(found / truth - 1).max() < 0.08


def test_kernels_are_a_density_and_their_draws_are_of_it():
    """The integral over a plane is one, and so is the mean of a ratio of densities over draws."""
    rng = np.random.default_rng(5)
    along = rng.normal(size=2000)
    bent = np.stack([along, along**2 + 0.2 * rng.normal(size=2000)], axis=1)
    found = kernels(bent)
    axes = np.linspace(-12, 12, 601), np.linspace(-15, 30, 901)
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    step = (axes[0][1] - axes[0][0]) * (axes[1][1] - axes[1][0])
    assert np.exp(found.log_density(grid)).sum() * step == pytest.approx(1, abs=0.01)
    # The mean of q/p over draws of p is one for any other density q that is nowhere beyond p.
    points = found.draw(40_000, np.random.RandomState(6))
    normal = -0.5 * np.sum((points - [0.0, 0.5]) ** 2, axis=1) / 0.04 - np.log(2 * np.pi * 0.04)
    ratio = np.exp(normal - found.log_density(points))
    assert ratio.mean() == pytest.approx(1, abs=5 * ratio.std() / 200)
    assert ratio.std() < 20
    # And they follow the bend, where a normal distribution would not.
    assert np.mean(np.abs(points[:, 1] - points[:, 0] ** 2) < 1) > 0.8
