"""Simulation-based calibration: is the truth's rank among the posterior's draws uniform?

    python -m benchmarks.ranks                  # 1000 records, a quarter of an hour
    python -m benchmarks.ranks --records 100

Draws devices from a population, each coefficient log-uniform from invisible to dominant; simulates
a time series of each with generators that share no code with the model; and ranks the truth
(Talts et al. 2018, arXiv:1804.06788). Twice: with the population for a prior, where ranks are
uniform if likelihood and sampler are right, and with the prior that allanfit ships, where they
show how well that prior serves this population.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.stats import chisquare

import allanfit
from allanfit.curves import unit_scale
from allanfit.identify._ensemble import ensemble
from allanfit.identify._estimate import target
from allanfit.identify._likelihood import log_likelihood
from allanfit.report import write_json

from ._records import record_options
from .generators import record

SAMPLES, RATE_HZ = 30_000, 50.0
# Logarithms of the smallest and the largest of Q, N, B, K; at the lower ends of Q, B and K a
# record of ten minutes shows nothing of them, at the upper ends N is the one that is hard to see.
POPULATION = np.log([[3e-6, 2e-4], [4e-3, 6e-3], [2e-4, 1e-2], [2e-5, 3e-3]])
_BATCH, _WALKERS, _RANKS = 20, 32, 10


@eqx.filter_jit
@eqx.filter_vmap(in_axes=(0, 0, None, None))
def population_posterior(key, found, layout, scale):
    """Draws of the logarithms with the population for a prior, shape (draws, 4)."""
    data = target(found, layout)
    low, high = jnp.asarray(POPULATION.T)

    def log_density(x):
        inside = jnp.all((x > low) & (x < high))
        power = (jnp.exp(x) / (scale * data.unit)) ** 2
        value = log_likelihood(power, data.density, data.expected, data.shape)
        return jnp.where(inside, value, -jnp.inf)

    start_key, chain_key = jax.random.split(key)
    start = low + (high - low) * jax.random.uniform(start_key, (_WALKERS, 4))
    chain, _ = ensemble(
        chain_key, log_density, log_density, start, burn_in=3000, draws=200, thin=20
    )
    return chain.reshape(-1, 4)


def ranks(draws, truth):
    """Fraction of draws below the truth, shape (records, 4)."""
    return np.mean(np.asarray(draws) < truth[:, None], axis=1)


def main(arguments=None):
    options = record_options(__doc__, 1000, arguments)
    scale = unit_scale(1 / RATE_HZ)[:4]
    found = {"population": [], "shipped": []}
    blocks = range(0, options.records, _BATCH)
    for first in track(blocks, "sampling", console=Console(stderr=True)):
        rng = np.random.default_rng((5, first))
        truth = rng.uniform(*POPULATION.T, (_BATCH, 4))
        data = np.stack(
            [
                record(rng, SAMPLES, 1 / RATE_HZ, dict(zip("QNBK", np.exp(one), strict=True)))
                for one in truth
            ]
        )
        fits = allanfit.fit_many(data, RATE_HZ, seed=first)
        keys = jax.random.split(jax.random.key(first), _BATCH)
        draws = population_posterior(keys, fits.estimate.statistics, fits.design, scale)
        found["population"].append(ranks(draws, truth))
        found["shipped"].append(ranks(jnp.log(fits.estimate.draws[..., :4]), truth))
    document = {"records": options.records}
    print("| prior | term | " + " | ".join(f"{k / _RANKS:.1f}" for k in range(_RANKS)), end="")
    print(" | chi-square p |\n|" + "---|" * (_RANKS + 3))
    for prior, parts in found.items():
        for symbol, rank in zip("QNBK", np.concatenate(parts).T, strict=True):
            count, _ = np.histogram(rank, _RANKS, (0, 1))
            p_value = float(chisquare(count).pvalue)
            document[f"{prior} {symbol}"] = {"counts": count.tolist(), "p_value": p_value}
            print(f"| {prior} | {symbol} | {' | '.join(map(str, count))} | {p_value:.3f} |")
    options.output.mkdir(parents=True, exist_ok=True)
    write_json(document, str(options.output / "ranks.json"))


if __name__ == "__main__":
    main()
