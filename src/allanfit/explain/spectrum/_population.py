"""Draws from a posterior of bent and narrow ridges: population Monte Carlo, then emcee.

Where a filter trades its corner for quantization noise, or a power law its exponent for all other
terms, walkers that know nothing but each other creep: after more than a thousand steps intervals
were still those of another seed's by a standard deviation. So kernels are fitted to weighted
draws, some rounds of which find the ridges and how wide they are (Cappé et al. 2008, Stat. Comput.
18:447), and walkers that begin there take the rest of the way by emcee.
"""

from collections.abc import Callable

import emcee
import numpy as np
from jaxtyping import Float

from ...identify._kernels import kernel_move, kernels

# Draws of a round, and rounds.
_DRAWS, _ROUNDS = 1024, 8
# Kernels are fitted to the posterior to the power of one over this, lest they end before it does.
_WIDER = 3.0
# Until so many in effect stand behind them, weights are flattened.
_FEWEST, _FLATTEST = 300.0, 1e-3
_RESAMPLED = 3000
# Turns of the walkers, each of twice as many steps as the one before, until 95 % intervals and
# medians of two in a row are within such a part of a standard deviation.
_WALKERS, _TURNS, _STEPS = 64, 4, 60
_LEVELS, _SETTLED = (0.025, 0.5, 0.975), 0.2
_DRAWN = 4800
# Points that are evaluated together.
_TOGETHER = 64

_LogDensity = Callable[[Float[np.ndarray, "points dim"]], Float[np.ndarray, " points"]]


def draw(
    log_density: _LogDensity,
    about: Float[np.ndarray, "start dim"],
    seed: int,
    *,
    quick: bool = False,
) -> Float[np.ndarray, "draws dim"]:
    """Draws from a posterior, from some that are roughly where it is; `quick` is rough itself."""
    random = np.random.RandomState(seed)

    def in_parts(x: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, " points"]:
        parts = np.split(x, range(_TOGETHER, len(x), _TOGETHER))
        return np.concatenate([log_density(part) for part in parts])

    rounds = _ROUNDS // (2 if quick else 1)
    likely, last = _population(in_parts, about, random, rounds)
    walkers = max(_WALKERS, 2 * about.shape[1])
    start, wide = likely[:walkers], kernel_move(last)
    along = emcee.moves.DEMove()
    # emcee draws from NumPy's global state unless it is given its own.
    state = emcee.State(start, random_state=random.get_state())
    moves, chain = [(wide, 0.7), (along, 0.3)], start
    for doublings in range(_TURNS // (2 if quick else 1)):
        sampler = emcee.EnsembleSampler(
            walkers, about.shape[1], in_parts, vectorize=True, moves=moves
        )
        state = sampler.run_mcmc(state, _STEPS * 2**doublings, skip_initial_state_check=True)
        before, chain = chain, np.asarray(sampler.get_chain(flat=True))
        if doublings > 0 and _apart(before, chain) < _SETTLED:
            break
        # What the walkers have found so far tells where they may go next.
        own = kernel_move(kernels(chain[:: max(len(chain) // _RESAMPLED, 1)]))
        moves = [(own, 0.5), (wide, 0.2), (along, 0.3)]
    return chain[:: max(len(chain) // _DRAWN, 1)]


def _apart(before: Float[np.ndarray, "draws dim"], after: Float[np.ndarray, "more dim"]) -> float:
    """Largest distance of quantiles, in standard deviations."""
    distance = np.quantile(before, _LEVELS, axis=0) - np.quantile(after, _LEVELS, axis=0)
    return float(np.max(np.abs(distance) / after.std(axis=0)))


def _population(log_density, about, random, rounds):
    """Points as often as they are likely, and kernels that are wider, after some rounds.

    Each draws from kernels about the points of those before.
    """
    mixtures = [kernels(about)]
    points, heights, drawn_from = np.zeros((0, about.shape[1])), np.zeros(0), np.zeros(0)
    for _ in range(rounds):
        fresh = mixtures[-1].draw(_DRAWS, random)
        # As draws of all mixtures together: none is the heavier for lying off its own.
        drawn_from = np.concatenate(
            [
                np.logaddexp(drawn_from, mixtures[-1].log_density(points)),
                np.logaddexp.reduce([each.log_density(fresh) for each in mixtures]),
            ]
        )
        points = np.concatenate([points, fresh])
        heights = np.concatenate([heights, log_density(fresh)])
        mixtures.append(kernels(_resampled(points, heights / _WIDER, drawn_from, random)))
    return _resampled(points, heights, drawn_from, random), mixtures[-1]


def _resampled(points, heights, drawn_from, random) -> Float[np.ndarray, "resampled dim"]:
    """As many as are needed, each as often as its weight says or a root of that."""
    weighted = _flattened(heights - drawn_from)
    return points[random.choice(len(points), size=_RESAMPLED, p=weighted)]


def _flattened(log_weights: Float[np.ndarray, " points"]) -> Float[np.ndarray, " points"]:
    """Weights, or a root of them that leaves enough in effect; alike where none is possible."""
    highest = np.max(log_weights)
    log_weights = log_weights - highest if np.isfinite(highest) else np.zeros(log_weights.shape)
    power = 1.0
    while True:
        weights = np.exp(power * log_weights)
        if weights.sum() ** 2 / np.sum(weights**2) >= _FEWEST or power < _FLATTEST:
            return weights / weights.sum()
        power *= 0.8
