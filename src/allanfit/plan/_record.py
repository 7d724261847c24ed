"""What the fit expects of a record of any length, without an array of its ordinates.

The lowest orders are taken one by one, as `curves.design` does. Beyond them the ends of the record
matter to no term, ordinates of one bin differ by little, and the mean of a bin is that of its
density, by Gauss-Legendre quadrature. A month at a kilohertz then costs what an hour costs.
"""

from functools import lru_cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..curves._bins import logarithmic_edges
from ..curves._design import BINS_PER_DECADE, NOISE_TERMS, RAMP_MODES, unit_term
from ..curves._spectrum import RampProjection, ramp_coefficients
from ..physics import Sampling

_EXACT_ORDERS = 4096
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
# Cycles per sample from a record of 1e15 samples to the Nyquist frequency, 280 a decade: densities
# interpolated between them in log-log are good to 5e-5.
_TABLE = np.geomspace(5e-16, 0.5, 4200)


class CountedDesign(NamedTuple):
    """The part of `curves.Design` that tells how much a record knows, for one stretch and dt = 1.

    All are NumPy float64; axes of terms run over Q, N, B, K, squared.
    """

    #: Ordinates in each bin, and the mean density that is expected of them.
    ordinates: Float[np.ndarray, " bins"]
    density: Float[np.ndarray, "bins terms"]
    #: The ramp's odd coefficients, and their variances.
    ramp: Float[np.ndarray, " modes"]
    ramp_variance: Float[np.ndarray, "modes terms"]


@lru_cache(maxsize=256)
def counted_design(samples: int, sampling: Sampling) -> CountedDesign:
    """The expectations of a record of `samples`, at least 256, in one stretch."""
    order = np.arange(1, min(samples, _EXACT_ORDERS + 1))
    expected = _densities(order / (2 * samples), sampling)
    expected *= _low_mode_ratios(samples)[: len(order)]
    # What a ramp does to low orders depends on a record's length by a factor alone.
    stand_in = len(order) + 1
    projection = RampProjection(stand_in)
    projected = np.stack([projection.expectation(column) for column in expected.T], axis=-1)

    spacing = 1 / (2 * samples)
    edges = logarithmic_edges(2 * spacing, spacing, BINS_PER_DECADE) / spacing
    ordinates, total = _sums_one_by_one(order[1:], projected, edges)
    # A bin's orders lie between halves; those of the rest are counted, not listed.
    ends = np.clip(edges, stand_in - 0.5, max(samples, stand_in) - 0.5)
    ordinates += np.diff(ends)
    total += _integrals(ends, samples, sampling)
    used = ordinates > 0
    odd = slice(0, 2 * RAMP_MODES, 2)
    return CountedDesign(
        ordinates=ordinates[used],
        density=total[used] / ordinates[used, None],
        ramp=ramp_coefficients(stand_in)[odd] * (samples / stand_in) ** 1.5,
        # An ordinate is 2 dt c^2, so c has half its variance.
        ramp_variance=expected[odd] / 2,
    )


def _sums_one_by_one(
    order: np.ndarray, expected: np.ndarray, edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Number of these orders in each bin, and the sums of what is expected of them."""
    bins = len(edges) - 1
    index = np.searchsorted(edges, order, side="right") - 1
    sums = [np.bincount(index, column, minlength=bins) for column in expected.T]
    return np.bincount(index, minlength=bins).astype(float), np.stack(sums, axis=-1)


def _integrals(ends: np.ndarray, samples: int, sampling: Sampling) -> np.ndarray:
    """Sums of the density over the orders between neighbouring ends, shape (bins, 4)."""
    centre, half_width = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    nodes = centre[:, None] + half_width[:, None] * _NODES
    density = _densities(nodes / (2 * samples), sampling)
    return np.einsum("b,n,bnt->bt", half_width, _WEIGHTS, density)


def _densities(frequency: np.ndarray, sampling: Sampling) -> np.ndarray:
    """Density of each term of coefficient one [per cycle per sample], on a last axis of terms."""
    position = np.log(frequency)
    table = _density_table(sampling)
    return np.exp(np.stack([np.interp(position, np.log(_TABLE), row) for row in table], axis=-1))


@lru_cache(maxsize=2)
def _density_table(sampling: Sampling) -> np.ndarray:
    with jax.enable_x64(True):
        frequency = jnp.asarray(_TABLE)
        rows = jax.jit(
            lambda f: [unit_term(term).density(f, 1.0, sampling) for term in NOISE_TERMS]
        )
        return np.log(np.stack([np.asarray(row) for row in rows(frequency)]))


def _low_mode_ratios(samples: int) -> np.ndarray:
    """What the ends of the record do to the lowest orders, shape (orders, 4)."""
    with jax.enable_x64(True):
        order = jnp.arange(1.0, _EXACT_ORDERS + 1)
        rows = [unit_term(term).low_mode_ratio(order, samples) for term in NOISE_TERMS]
        return np.stack([np.asarray(row) for row in rows], axis=-1)
