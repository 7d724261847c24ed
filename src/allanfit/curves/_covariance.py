"""How all points of both curves vary together, up to the longest tau.

Every statistic is a quadratic form of the samples. For Gaussian samples, two forms x'Ax and x'Bx
have covariance 2 tr(A S B S) with S the covariance of the samples. In the cosine coefficients of
the record S is diagonal, to a good approximation for every noise term, and the matrix of an
overlapping Allan variance has a closed form, ends of the record included:

    A_jk = h_j h_k (D(j - k) - D(j + k))/(4 M),
    h_j  = -2 sqrt(2/N) sin^2(w_j n/2)/(n sin(w_j/2)),   w_j = pi j/N,
    D(i) = cos(pi i/2) sin(pi i M/(2 N))/sin(pi i/(2 N)),   M = N - 2n + 1.

A cluster much shorter than the record does not feel its ends, so that a stand-in record of 64
clusters, scaled by its number of differences, gives the same to a per cent and keeps the matrices
small whatever the length of the record. High coefficients, which only quantization needs, are
added without their small correlations.

The numbers are constants of a model, not functions of the data: they are computed in NumPy.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..physics import NoiseModel, Sampling
from ._design import Design

_CLUSTERS = 64
_MODES = 384
_TAIL_POINTS = 1024
_POINTS_PER_BIN = 48


class JointCovariance(NamedTuple):
    """Covariances [u^4], densities for a sampling interval of one; bins are uncorrelated."""

    allan: Float[Array, "sizes sizes"]
    cross: Float[Array, "sizes bins"]
    density: Float[Array, " bins"]

    def matrix(self) -> Float[Array, "statistics statistics"]:
        """All Allan points, then all bins, in one symmetric matrix."""
        return jnp.block([[self.allan, self.cross], [self.cross.T, jnp.diag(self.density)]])


def joint_covariance(model: NoiseModel, design: Design) -> JointCovariance:
    """Covariance of the statistics of a record under a noise model, coefficients for dt = 1.

    Several stretches count as independent records. Needs float64.

    **Returns:** Allan points at `design.cluster_sizes` and bins of the mirror spectrum.
    """
    mean = model.density(jnp.asarray(design.frequency), 1.0, design.sampling)
    return JointCovariance(
        _allan_covariance(model, design),
        _cross_covariance(model, design),
        2 * mean**2 / design.ordinates,
    )


def allan_variance_deviation(model: NoiseModel, design: Design) -> Float[Array, " sizes"]:
    """Standard deviation of each Allan variance [u^2]; coefficients for dt = 1."""
    variance = np.zeros(len(design.cluster_sizes))
    for rows in _octaves(design):
        variance[rows] = np.diag(_allan_block(model, design, rows, rows))
    return jnp.sqrt(jnp.asarray(variance))


def _octaves(design: Design) -> list[np.ndarray]:
    octave = np.floor(np.log2(design.cluster_sizes)).astype(int)
    return [np.flatnonzero(octave == k) for k in range(octave[-1] + 1)]


def _allan_covariance(model: NoiseModel, design: Design) -> Float[Array, "sizes sizes"]:
    sizes = len(design.cluster_sizes)
    covariance = np.zeros((sizes, sizes))
    for rows in _octaves(design):
        columns = np.arange(rows[-1] + 1)
        covariance[np.ix_(rows, columns)] = _allan_block(model, design, rows, columns)
    lower = np.tril(covariance)
    return jnp.asarray(lower + np.tril(lower, -1).T)


def _allan_block(
    model: NoiseModel, design: Design, rows: np.ndarray, columns: np.ndarray
) -> np.ndarray:
    """Covariances of some sizes (rows, of one octave) with others that are no longer."""
    sizes = np.asarray(design.cluster_sizes)[columns]
    length = int(min(max(design.lengths), _CLUSTERS * sizes[-1]))
    forms = _quadratic_forms(model, design, sizes, length).reshape(len(sizes), -1)
    chosen = np.isin(columns, rows)
    block = 2 * forms[chosen] @ forms.T
    if length - 1 > _MODES:
        tail, weight = _tail(length)
        diagonal = _diagonal(tail, sizes, length) * _mode_variance(model, design, tail, length)
        block += 2 * (diagonal[chosen] * weight) @ diagonal.T
    differences = length - 2 * sizes[chosen] + 1
    return block * (differences / design.differences[rows])[:, None]


def _tail(length: int) -> tuple[np.ndarray, np.ndarray]:
    """Orders beyond the matrices, spaced in logarithm so as to keep no step with any cluster."""
    edges = np.geomspace(_MODES + 0.5, length - 0.5, _TAIL_POINTS + 1)
    return np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)


def _quadratic_forms(
    model: NoiseModel, design: Design, sizes: np.ndarray, length: int
) -> Float[np.ndarray, "sizes modes modes"]:
    """S^1/2 A S^1/2 of each size in a record of this length, its first coefficients."""
    order = np.arange(1, min(length - 1, _MODES) + 1)
    deviation = np.sqrt(_mode_variance(model, design, order, length))
    weighted = _amplitude(order, sizes, length) * deviation
    differences = (length - 2 * sizes + 1)[:, None]
    kernel = _end_kernel(np.arange(2 * len(order) + 1), differences, length)
    minus, plus = np.abs(order[:, None] - order), order[:, None] + order
    forms = (kernel[:, minus] - kernel[:, plus]) / (4 * differences[:, :, None])
    return forms * weighted[:, :, None] * weighted[:, None, :]


def _cross_covariance(model: NoiseModel, design: Design) -> Float[Array, "sizes bins"]:
    """Cov(A_n, P_b) = 4/nu sum over the bin of A_jj V_j^2, from up to 48 ordinates of each bin.

    In the first bins, of one ordinate each, the ramp's projection mixes odd coefficients.
    """
    length = max(design.lengths)
    sizes = np.asarray(design.cluster_sizes)
    centre = 2 * length * np.asarray(design.frequency)
    width = np.maximum(np.asarray(design.ordinates) * length / sum(design.lengths), 1)
    offset = (np.arange(_POINTS_PER_BIN) + 0.5) / _POINTS_PER_BIN - 0.5
    order = np.clip(np.rint(centre[:, None] + (width[:, None] - 1) * offset), 1, length - 1)
    flat = order.ravel()
    variance = _mode_variance(model, design, flat, length)
    terms = (_diagonal(flat, sizes, length) * variance**2).reshape(len(sizes), *order.shape)
    cross = 4 * np.mean(terms, axis=-1)

    single = np.flatnonzero(design.ordinates == 1)
    projection = design.projection[int(np.argmax(design.lengths))]
    forms = _quadratic_forms(model, design, sizes, length)
    modes = forms.shape[-1]
    weight, direction = projection.weight[:modes], projection.direction[:modes]
    mix = projection.mix[:modes]
    for b in single[single < modes - 1]:
        i = b + 1  # the first coefficient is the one projected out
        row = ((np.arange(modes) == i) - direction[i] * mix) * weight / weight[i]
        row = row * np.sqrt(_mode_variance(model, design, np.arange(1, modes + 1), length))
        cross[:, b] = 4 * np.einsum("j,njk,k->n", row, forms, row)
    # Several stretches share a bin's ordinates and a size's differences alike.
    return jnp.asarray(cross * ((length - 2 * sizes + 1) / design.differences)[:, None])


def _mode_variance(
    model: NoiseModel, design: Design, order: np.ndarray, length: int
) -> Float[np.ndarray, " modes"]:
    """Variance of cosine coefficients: an ordinate is twice their square."""
    return np.asarray(_density(model, order / (2 * length), design.sampling)) / 2


@partial(jax.jit, static_argnames="sampling")
def _density(
    model: NoiseModel, frequency: Float[Array, " modes"], sampling: Sampling
) -> Float[Array, " modes"]:
    return model.density(frequency, 1.0, sampling)


def _diagonal(order: np.ndarray, sizes: np.ndarray, length: int) -> np.ndarray:
    differences = (length - 2 * sizes + 1)[:, None]
    ends = differences - _end_kernel(2 * order, differences, length)
    return _amplitude(order, sizes, length) ** 2 / (4 * differences) * ends


def _amplitude(order: np.ndarray, sizes: np.ndarray, length: int) -> np.ndarray:
    angle = np.pi * order / length
    n = sizes[:, None]
    return -2 * np.sqrt(2 / length) * np.sin(angle * n / 2) ** 2 / (n * np.sin(angle / 2))


def _end_kernel(index: np.ndarray, differences: np.ndarray, length: int) -> np.ndarray:
    """D(i) for each size; odd i vanish, as sine and cosine modes of opposite parity do not mix."""
    half = np.pi * index / (2 * length)
    sine = np.where(index % (2 * length) == 0, 1.0, np.sin(half))
    ratio = np.where(index % (2 * length) == 0, differences, np.sin(half * differences) / sine)
    return np.where(index % 2 == 0, np.cos(np.pi * index / 2) * ratio, 0.0)
