"""The posterior by emcee, with the diagnostics that say whether to believe it."""

from dataclasses import dataclass
from typing import Any

import emcee
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..curves import unit_scale
from ..physics import SYMBOLS
from ._diagnostics import effective_sample_size, r_hat
from ._estimate import as_design_dtype, solve
from ._fit import Fit
from ._posterior import coordinates, log_posterior, starting_points
from ._ramp import draw_ramps

_WALKERS = 32
_BURN_IN = 500
_ROUND = 2000
_MOST_ROUNDS = 6
# Where two terms trade off, differential evolution mixes twice as fast as stretch moves alone.
_MOVES = [
    (emcee.moves.DEMove(), 0.7),
    (emcee.moves.DESnookerMove(), 0.1),
    (emcee.moves.StretchMove(), 0.2),
]
_WANTED_R_HAT = 1.02
_WANTED_SAMPLES = 1000


@dataclass(frozen=True)
class Posterior:
    """Draws from the posterior of one sensor's coefficients, and whether to believe them."""

    #: Shape (walkers, steps, 5) for Q, N, B, K, R; SI, the ramp signed.
    draws: Float[np.ndarray, "walkers steps terms"]
    #: Split R-hat and effective sample size of each coefficient's logarithm (the ramp: itself).
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


def sample(
    fit: Fit, *, seed: int = 0, most_rounds: int = _MOST_ROUNDS, progress: bool = False
) -> Posterior:
    """Sample the posterior of one fitted sensor with emcee (Foreman-Mackey et al. 2013).

    Samples the likelihood of the least-squares fit, with the prior of `_posterior`, in rounds of
    2000 steps of 32 walkers until R-hat is below 1.02 and the effective sample size of every
    coefficient at least 1000, or until `most_rounds` are done; `Posterior.converged` says which.

    **Arguments:**

    - `fit`: one sensor's fit, from `allanfit.fit`.
    - `seed`: the same seed gives the same draws.
    - `progress`: show a progress bar.
    """
    design = as_design_dtype(fit.design, fit.estimate.statistics.density.dtype)
    solution, data = solve(fit.estimate.statistics, design)
    space, deviation = coordinates(data, solution.power)
    start_key, ramp_key = jax.random.split(jax.random.key(seed))
    start = starting_points(start_key, solution.power, deviation, space, _WALKERS)
    log_probability = jax.jit(jax.vmap(lambda x: log_posterior(x, data, space)))

    sampler = emcee.EnsembleSampler(
        _WALKERS,
        start.shape[1],
        lambda x: np.asarray(log_probability(jnp.asarray(x, start.dtype)), np.float64),
        vectorize=True,
        moves=_MOVES,
    )
    random_state = np.random.RandomState(seed).get_state()
    state = emcee.State(np.asarray(start, np.float64), random_state=random_state)
    state = sampler.run_mcmc(state, _BURN_IN, progress=progress)
    sampler.reset()
    to_powers = jax.jit(jax.vmap(space.power))
    scale = np.asarray(unit_scale(1 / fit.rate_hz))
    for _ in range(most_rounds):
        state = sampler.run_mcmc(state, _ROUND, progress=progress)
        chain = np.asarray(sampler.get_chain())
        powers = to_powers(jnp.asarray(chain.reshape(-1, start.shape[1]), start.dtype))
        ramps, _ = draw_ramps(ramp_key, fit.estimate.statistics.odd_modes, powers, design)
        draws = np.concatenate([np.sqrt(powers), np.asarray(ramps)[:, None]], axis=1) * scale
        draws = draws.reshape(*chain.shape[:2], -1).swapaxes(0, 1)
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
