"""The posterior by emcee, with the diagnostics that say whether to believe it."""

from dataclasses import dataclass
from typing import Any

import emcee
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray
from threadpoolctl import threadpool_limits

from ..curves import unit_scale
from ..physics import SYMBOLS
from ._diagnostics import effective_sample_size, r_hat
from ._estimate import prepare
from ._fit import Fit
from ._kernels import kernel_move, kernels
from ._posterior import Coordinates, Target, coordinates, log_posterior, starting_points
from ._ramp import RampData, draw_ramps

_WALKERS = 32
_BURN_IN = 100
_ROUND = 1000
_MOST_ROUNDS = 12
# Differential evolution finds what the draws of the fit, where the others go, may have missed.
_TO_DRAWS, _ALONG = 0.7, 0.3
_WANTED_R_HAT = 1.02
_WANTED_SAMPLES = 1000


@dataclass(frozen=True)
class Posterior:
    """Draws from the posterior of one sensor's coefficients, and whether to believe them."""

    #: Shape (walkers, steps, 5) for Q, N, B, K, R in the unit of the fitted data, the ramp signed.
    draws: Float[np.ndarray, "walkers steps terms"]
    #: Split R-hat and effective sample size of each coefficient.
    r_hat: dict[str, float]
    effective_sample_size: dict[str, float]
    acceptance_fraction: float
    seed: int

    @property
    def converged(self) -> bool:
        """Whether R-hat is below 1.02 and 1000 independent draws stand behind each coefficient.

        If not, the intervals are rough: sample again with more rounds.
        """
        return (
            max(self.r_hat.values()) < _WANTED_R_HAT
            and min(self.effective_sample_size.values()) >= _WANTED_SAMPLES
        )

    def to_dict(self) -> dict[str, Any]:
        """The `posterior` of the fit JSON."""
        return {
            "sampler": "emcee",
            "draws": self.draws.shape[0] * self.draws.shape[1],
            "effective_sample_size": {
                symbol: round(value) for symbol, value in self.effective_sample_size.items()
            },
            "r_hat": self.r_hat,
            "acceptance_fraction": self.acceptance_fraction,
            "converged": self.converged,
            "seed": self.seed,
        }


# Compiled once for all channels of a recording: what differs between them are arguments.
_log_posteriors = jax.jit(jax.vmap(log_posterior, (0, None, None)))


@jax.jit
def _begin(
    key: PRNGKeyArray,
    data: Target,
    least_squares: Float[Array, " terms"],
    draws: Float[Array, "draws terms"],
) -> tuple[Coordinates, Float[Array, "walkers noise_terms"], Float[Array, "draws noise_terms"]]:
    """Coordinates, where walkers start, and where the draws of a fit are; all for dt = 1."""
    power = least_squares[:-1] ** 2
    space = coordinates(data, power)
    positions = jax.vmap(space.position)(draws[:, :-1] ** 2)
    return space, starting_points(key, power, space, _WALKERS), positions


@jax.jit
def _with_ramps(
    key: PRNGKeyArray,
    positions: Float[Array, "draws noise_terms"],
    space: Coordinates,
    ramp: RampData,
) -> Float[Array, "draws terms"]:
    """Coefficients for dt = 1 at a sampler's positions, with a ramp drawn for each."""
    powers = jax.vmap(space.power)(positions)
    ramps, _ = draw_ramps(key, ramp, powers)
    return jnp.concatenate([jnp.sqrt(powers), ramps[:, None]], axis=1)


# Of threads for small matrices each waits for the others.
@threadpool_limits.wrap(limits=1, user_api="blas")
def sample(
    fit: Fit, *, seed: int = 0, most_rounds: int = _MOST_ROUNDS, progress: bool = False
) -> Posterior:
    """Sample the posterior of one fitted sensor with emcee (Foreman-Mackey et al. 2013).

    Samples the likelihood of the least-squares fit, with the prior of `_posterior`, in rounds of
    1000 steps of 32 walkers until R-hat is below 1.02 and the effective sample size of every
    coefficient at least 1000, or until `most_rounds` are done; `Posterior.converged` says which.
    Most moves are proposed from the draws of the fit, which have nearly the same posterior, and
    accepted or not so that what is drawn is this one; walkers start apart from these draws.

    **Arguments:**

    - `fit`: one sensor's fit, from `allanfit.fit`.
    - `seed`: the same seed gives the same draws.
    - `most_rounds`: at least 1.
    - `progress`: show a progress bar.

    **Raises:** `ValueError` for less than one round, a fit of several sensors, or one that did not
    converge.
    """
    if most_rounds < 1:
        raise ValueError(f"most_rounds must be at least 1; got {most_rounds}")
    if fit.estimate.statistics.density.ndim > 1:
        raise ValueError("sample takes the fit of one sensor: fit one series of the batch alone")
    if not bool(fit.converged):
        raise ValueError(
            "this fit did not converge, and has no posterior: look for NaN in its data"
        )
    data, ramp = prepare(fit.estimate.statistics, fit.design)
    scale = np.asarray(unit_scale(1 / fit.rate_hz)) * np.asarray(data.unit)
    start_key, ramp_key = jax.random.split(jax.random.key(seed))
    estimate = fit.estimate
    space, start, near = _begin(
        start_key, data, estimate.least_squares / scale, estimate.draws / scale
    )

    def log_density(x: Float[np.ndarray, "walkers dim"]) -> Float[np.ndarray, " walkers"]:
        density = np.asarray(_log_posteriors(x.astype(start.dtype), data, space), np.float64)
        # The posterior is even, and its walkers stay on one side of zero.
        return np.where(np.all(x > 0, axis=1), density, -np.inf)

    sampler = emcee.EnsembleSampler(
        _WALKERS,
        start.shape[1],
        log_density,
        vectorize=True,
        moves=[
            (kernel_move(kernels(np.asarray(near, np.float64))), _TO_DRAWS),
            (emcee.moves.DEMove(), _ALONG),
        ],
    )
    random_state = np.random.RandomState(seed).get_state()
    state = emcee.State(np.asarray(start, np.float64), random_state=random_state)
    state = sampler.run_mcmc(state, _BURN_IN, progress=progress)
    sampler.reset()
    rounds = []
    for index in range(most_rounds):
        state = sampler.run_mcmc(state, _ROUND, progress=progress)
        chain = np.asarray(sampler.get_chain())[-_ROUND:]
        flat = jnp.asarray(chain.reshape(-1, start.shape[1]), start.dtype)
        key = jax.random.fold_in(ramp_key, index)
        coefficients = _with_ramps(key, flat, space, ramp)
        rounds.append(np.asarray(coefficients).reshape(*chain.shape[:2], -1) * scale)
        draws = np.concatenate(rounds).swapaxes(0, 1)
        posterior = Posterior(
            draws=draws,
            r_hat={s: r_hat(draws[..., i]) for i, s in enumerate(SYMBOLS)},
            effective_sample_size={
                s: effective_sample_size(draws[..., i]) for i, s in enumerate(SYMBOLS)
            },
            acceptance_fraction=float(np.mean(sampler.acceptance_fraction)),
            seed=seed,
        )
        if posterior.converged:
            break
    return posterior
