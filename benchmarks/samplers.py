"""Are the intervals that `fit_many` draws in JAX those that emcee draws?

    python -m benchmarks.samplers                # 12 records of eight sensors, half an hour
    python -m benchmarks.samplers --records 3

Prints, for each coefficient, how far the ends of both samplers' 95 % intervals are apart in units
of the interval's half-width, root mean square and largest; the same for the quantiles at 2.5 %,
50 % and 97.5 % together in standard deviations of the posterior; the smallest p-value of the
Kolmogorov-Smirnov test of one against the other, each thinned to about independent draws; and
whether emcee has settled.
"""

import argparse

import jax
import numpy as np
from rich.console import Console
from rich.progress import track
from scipy.stats import ks_2samp

import allanfit
from allanfit.identify._diagnostics import effective_sample_size

from .generators import record
from .truth import SCENARIOS

NAMES = (
    "consumer gyro, 10 min",
    "old MEMS gyro, large Q, 10 min",
    "no flicker, 1 h",
    "white noise only, 10 min",
    "very large Q, N far below, 10 min",
    "no walk, 1 h",
    "ramp without walk, 1 h",
)
SHORT = {"short, 100 s": (100, 50, {"N": 5e-3, "B": 5e-3, "K": 2e-3}, {})}
LEVELS = (0.025, 0.5, 0.975)


def quantiles_apart(fit, posterior):
    """Root mean square distance of three quantiles in standard deviations, shape (5,)."""
    fast, slow = np.abs(fit.estimate.draws), np.abs(posterior.draws.reshape(-1, 5))
    distance = np.quantile(fast, LEVELS, axis=0) - np.quantile(slow, LEVELS, axis=0)
    return np.sqrt(np.mean(distance**2, axis=0)) / np.std(slow, axis=0)


def independent(draws):
    """About independent draws of one coefficient, from shape (walkers, steps)."""
    each = max(int(np.ceil(draws.size / effective_sample_size(draws))), 1)
    return np.abs(draws[:, ::each].ravel())


def kolmogorov_smirnov(fit, posterior):
    """p-values of the two samplers having one distribution, shape (5,)."""
    walkers = fit.estimate.draws.reshape(-1, 32, 5).swapaxes(0, 1)
    return [
        ks_2samp(
            independent(np.asarray(walkers[..., i])), independent(posterior.draws[..., i])
        ).pvalue
        for i in range(5)
    ]


def apart(fit, posterior):
    """Distance between the ends of both 95 % intervals, in half-widths of emcee's, shape (5,)."""
    slow = fit.with_draws(posterior.draws.reshape(-1, 5))
    distance = []
    for symbol in "QNBKR":
        ends, others = np.asarray(slow.intervals[symbol]), np.asarray(fit.intervals[symbol])
        distance.append(np.abs(ends - others).max() / (np.diff(ends)[0] / 2))
    return distance


def root_mean_square(rows):
    return np.sqrt(np.mean(np.square(rows), axis=0))


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=12)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    print("| scenario | | Q | N | B | K | R | settled |\n|" + "---|" * 8)
    for name in (*NAMES, *SHORT):
        duration_s, rate_hz, coefficients, generator = (SCENARIOS | SHORT)[name]
        distances, deviations, p_values, settled = [], [], [], 0
        for i in track(range(options.records), name, console=Console(stderr=True)):
            rng = np.random.default_rng((9, i))
            x = record(rng, duration_s * rate_hz, 1 / rate_hz, coefficients, **generator)
            fit = allanfit.fit(x, float(rate_hz), seed=i)
            posterior = allanfit.sample(fit, seed=i)
            distances.append(apart(fit, posterior))
            deviations.append(quantiles_apart(fit, posterior))
            p_values.append(kolmogorov_smirnov(fit, posterior))
            settled += posterior.converged
        rows = {
            "ends, r.m.s.": root_mean_square(distances),
            "ends, largest": np.max(distances, axis=0),
            "quantiles, r.m.s.": root_mean_square(deviations),
            "KS, smallest p": np.min(p_values, axis=0),
        }
        for label, values in rows.items():
            cells = " | ".join(f"{value:.3f}" for value in values)
            print(f"| {name} | {label} | {cells} | {settled} of {options.records} |")


if __name__ == "__main__":
    main()
