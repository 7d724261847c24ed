"""Does least squares ever stop at a wrong optimum?

    python -m benchmarks.optima                 # 10,000 fits, some minutes
    python -m benchmarks.optima --fits 500

Draws spectra of sensors of every kind (each coefficient from invisible to dominant, or absent),
and of no sensor at all (a power law with a bump), fits them, and searches each again from sixteen
random starts on random faces of the positive orthant. A wrong optimum is a fit whose sum of
squares another search betters by more than 0.001.
"""

import argparse

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from rich.console import Console
from rich.progress import track

from allanfit.curves import design
from allanfit.identify._least_squares import least_squares
from allanfit.identify._likelihood import deviance_residuals

_BATCH = 250
_STARTS = 16
_SEARCH_STEPS = 400
_BETTER = 1e-3


def spectra(rng, layout, count):
    """Binned spectra, shape (count, bins): half of sensors, half of none."""
    frequency, shape = np.asarray(layout.frequency), np.asarray(layout.ordinates) / 2
    unit = np.asarray(layout.density)
    # Each term between a hundredth of and ten thousand times white noise where it is strongest.
    strongest = unit.max(axis=0) / unit[:, 1].max()
    power = 10 ** rng.uniform(-2, 4, (count, 4)) / strongest
    power *= rng.random((count, 4)) < 0.7
    power[:, 1] = np.maximum(power[:, 1], 1e-3)
    mean = power @ unit.T
    slope, center = rng.uniform(-3, 2, (count, 1)), rng.uniform(-4, -0.5, (count, 1))
    height = 10 ** rng.uniform(-1, 2, (count, 1))
    distance = (np.log10(frequency) - center) / 0.1
    odd = (frequency / frequency[-1]) ** slope * (1 + height * np.exp(-(distance**2) / 2))
    mean[1::2] = odd[1::2]
    return mean * rng.gamma(shape, size=mean.shape) / shape


def best_of_many_starts(key, density, expected, shape):
    """Smallest sum of squares that multiplicative updates find from random starts.

    Expectation maximisation of a sum of Gamma components (Fevotte et al. 2009, Neural Comput.
    21:793, section 4.1): slow, simple, never uphill, and no relation of Fisher scoring.
    """
    keys = jax.random.split(key, _STARTS)
    level = jnp.median(density / jnp.max(expected, axis=1))

    def one(key):
        size, face = jax.random.split(key)
        start = level * 10 ** jax.random.uniform(size, (4,), density.dtype, -4, 4)
        start = start * (jax.random.uniform(face, (4,)) < 0.75).at[1].set(True)

        def step(power, _):
            mean = expected @ power
            ascent = expected.T @ (shape * density / mean**2)
            descent = expected.T @ (shape / mean)
            return power * jnp.sqrt(ascent / descent), None

        power = jax.lax.scan(step, start, None, length=_SEARCH_STEPS)[0]
        return jnp.sum(deviance_residuals(power, density, expected, shape) ** 2)

    return jnp.min(jax.vmap(one)(keys))


@eqx.filter_jit
@eqx.filter_vmap(in_axes=(0, 0, None, None))
def compare(key, density, expected, shape):
    """Deviance of the fit, and of the best other search."""
    solution = least_squares(density, expected, shape)
    return solution.deviance, best_of_many_starts(key, density, expected, shape)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fits", type=int, default=10_000)
    parser.add_argument("--samples", type=int, default=100_000)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    layout = design((options.samples,), "point")
    expected, shape = jnp.asarray(layout.density), jnp.asarray(layout.ordinates) / 2
    margins = []
    batches = range(0, options.fits, _BATCH)
    for first in track(batches, "fitting", console=Console(stderr=True)):
        density = spectra(np.random.default_rng((3, first)), layout, _BATCH)
        keys = jax.random.split(jax.random.key(first), _BATCH)
        fitted, searched = compare(keys, jnp.asarray(density), expected, shape)
        margins.append(np.asarray(fitted - searched))
    margin = np.concatenate(margins)
    wrong = int(np.sum(~(margin <= _BETTER)))
    print(f"{len(margin)} fits, {wrong} at a wrong optimum; largest gain of any other search:")
    print(f"{margin.max():.2g} in the sum of squares; smallest {margin.min():.2g}")
    return wrong


if __name__ == "__main__":
    raise SystemExit(main() > 0)
