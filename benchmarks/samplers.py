"""Are the intervals that `fit_many` draws in JAX those that emcee draws?

    python -m benchmarks.samplers                # 12 records of four sensors, ten minutes
    python -m benchmarks.samplers --records 3

Prints, for each coefficient, how far the ends of both samplers' 95 % intervals are apart in units
of the interval's half-width, root mean square and largest, and whether emcee has settled.
"""

import argparse

import jax
import numpy as np
from rich.console import Console
from rich.progress import track

import allanfit

from .generators import record
from .truth import SCENARIOS

NAMES = (
    "consumer gyro, 10 min",
    "old MEMS gyro, large Q, 10 min",
    "no flicker, 1 h",
    "white noise only, 10 min",
)


def apart(fit, posterior):
    """Distance between the ends of both 95 % intervals, in half-widths of emcee's, shape (5,)."""
    slow = fit.with_draws(posterior.draws.reshape(-1, 5))
    distance = []
    for symbol in "QNBKR":
        ends, others = np.asarray(slow.intervals[symbol]), np.asarray(fit.intervals[symbol])
        distance.append(np.abs(ends - others).max() / (np.diff(ends)[0] / 2))
    return distance


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=12)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    print("| scenario | | Q | N | B | K | R | settled |\n|" + "---|" * 8)
    for name in NAMES:
        duration_s, rate_hz, coefficients, generator = SCENARIOS[name]
        distances, settled = [], 0
        for i in track(range(options.records), name, console=Console(stderr=True)):
            rng = np.random.default_rng((9, i))
            x = record(rng, duration_s * rate_hz, 1 / rate_hz, coefficients, **generator)
            fit = allanfit.fit(x, float(rate_hz), seed=i)
            posterior = allanfit.sample(fit, seed=i)
            distances.append(apart(fit, posterior))
            settled += posterior.converged
        square = np.sqrt(np.mean(np.square(distances), axis=0))
        for label, values in (("r.m.s.", square), ("largest", np.max(distances, axis=0))):
            cells = " | ".join(f"{value:.2f}" for value in values)
            print(f"| {name} | {label} | {cells} | {settled} of {options.records} |")


if __name__ == "__main__":
    main()
