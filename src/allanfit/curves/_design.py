"""What each standard term is expected to put into each statistic of a record of given lengths.

The statistics of both curves are quadratic forms of the samples, so that their expectations are
linear in the squared coefficients. The matrix of that linear map depends on nothing but the
lengths of the stretches between gaps and how the sensor samples; it is computed once, in float64
on the host, for a sampling interval of one. `unit_scale` carries coefficients to the real one.
"""

from functools import lru_cache, partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..physics import (
    STANDARD_TERMS,
    AbstractNoiseTerm,
    AngleCodes,
    QuantizationNoise,
    RateRamp,
    Sampling,
    check_sampling,
)
from ._bins import logarithmic_edges
from ._cluster_sizes import cluster_sizes
from ._spectrum import RampProjection, ramp_coefficients

NOISE_TERMS: tuple[type[AbstractNoiseTerm], ...] = STANDARD_TERMS[:-1]
BINS_PER_DECADE = 16
# The ramp's share of the odd coefficients falls as the fourth power of their order: what lies
# beyond the first 32 of them holds less than 1e-5 of what can be known of it.
RAMP_MODES = 32
# Above this order the ends of a record matter to no term (5e-5 of the density of flicker).
_LOW_MODES = 4096
_CHUNK = 16384
# Up to this order each ordinate is computed, beyond their mean over a bin by so many nodes.
_EXACT, _NODES = 65_536, 12


# NumPy when made, traced when inside jit.
_Array = np.ndarray | Array


class Design(eqx.Module):
    """Expectations for a sampling interval of one; see the fields. All are NumPy when made.

    Fields with an axis of terms run over Q, N, B, K, squared; that of the Allan variance has R too.
    """

    lengths: tuple[int, ...] = eqx.field(static=True)
    sampling: Sampling = eqx.field(static=True)
    #: What takes the ramp out of each stretch.
    projection: tuple[RampProjection, ...]
    #: Bin of each spectral ordinate, one array a stretch, shape (length - 2,).
    bin_index: tuple[_Array, ...]
    #: Ordinates in each bin, shape (bins,), and their mean frequency in cycles per sample.
    ordinates: _Array
    frequency: _Array
    #: Expected density in each bin, shape (bins, 4).
    density: _Array
    #: The ramp's odd coefficients and their variances, shapes (stretches, modes) and
    #: (stretches, modes, 4); zero and one where a short stretch has no such mode.
    ramp: _Array
    ramp_variance: _Array
    #: Cluster sizes, number of overlapping differences, expected Allan variance (sizes, 5).
    cluster_sizes: _Array
    differences: _Array
    allan: _Array


def unit_scale(dt: float | Float[Array, ""]) -> Float[Array, " terms"]:
    """Factor from a coefficient for dt = 1 to one in seconds, for Q, N, B, K, R: shape (5,)."""
    return jnp.stack([dt**term.seconds_power * jnp.ones(()) for term in STANDARD_TERMS])


@lru_cache(maxsize=32)
def design(
    lengths: tuple[int, ...], sampling: Sampling = "point", codes: AngleCodes | None = None
) -> Design:
    """The design of a record with stretches of these lengths, each of at least 16 samples.

    With `codes` of an angle its quantization is not white, and Q is that of their errors.

    **Raises:** `ValueError` for another sampling.
    """
    check_sampling(sampling)
    # From order 2: the first coefficient goes with the ramp.
    spacing = 1 / (2 * max(lengths))
    edges = logarithmic_edges(2 * spacing, spacing, BINS_PER_DECADE)
    # Constants also where a user traces the fit.
    with jax.ensure_compile_time_eval(), jax.enable_x64(True):
        return _design(lengths, sampling, edges, codes)


def _design(
    lengths: tuple[int, ...],
    sampling: Sampling,
    edges: np.ndarray,
    codes: AngleCodes | None = None,
) -> Design:
    bins = len(edges) - 1
    ordinates, frequency = np.zeros(bins), np.zeros(bins)
    density = np.zeros((bins, len(NOISE_TERMS)))
    ramp = np.zeros((len(lengths), RAMP_MODES))
    ramp_variance = np.ones((len(lengths), RAMP_MODES, len(NOISE_TERMS)))
    bin_index, projections = [], []
    for stretch, length in enumerate(lengths):
        # Edges lie between ordinates of the longest stretch, and may meet those of another.
        ends = np.ceil(np.round(edges * 2 * length, 6)).astype(int).clip(2, length)
        ends[0], ends[-1] = 2, length
        count = np.diff(ends)
        bin_index.append(np.repeat(np.arange(bins, dtype=np.int32), count))
        ordinates += count
        # The mean of consecutive orders is that of the first and the last.
        frequency += count * (ends[:-1] + ends[1:] - 1) / (4 * length)
        projection = RampProjection(length)
        projections.append(projection)
        odd = slice(0, 2 * RAMP_MODES, 2)
        order = np.arange(1, min(length, _EXACT + 1), dtype=np.float64)
        modes = len(order[odd])
        ramp[stretch, :modes] = ramp_coefficients(length, len(order))[odd]
        index = bin_index[-1][: len(order) - 1]
        for column, term in enumerate(NOISE_TERMS):
            expected = expected_ordinates(term, length, order / (2 * length), sampling, codes)
            # An ordinate is 2 dt c^2, so c has half its variance.
            ramp_variance[stretch, :modes, column] = expected[odd] / 2
            density[:, column] += np.bincount(
                index, projection.expectation(expected), minlength=bins
            )
            density[:, column] += _beyond(term, length, ends, sampling, codes)
    used = ordinates > 0
    count = np.maximum(ordinates, 1)
    renumber = np.cumsum(used) - 1
    sizes = cluster_sizes(max(lengths))
    return Design(
        lengths=lengths,
        sampling=sampling,
        projection=tuple(projections),
        bin_index=tuple(renumber[index].astype(np.int32) for index in bin_index),
        ordinates=ordinates[used],
        frequency=(frequency / count)[used],
        density=(density / count[:, None])[used],
        ramp=ramp,
        ramp_variance=ramp_variance,
        cluster_sizes=sizes,
        differences=np.sum([np.maximum(length - 2 * sizes + 1, 0) for length in lengths], axis=0),
        allan=expected_allan(sizes, sampling, codes),
    )


def _beyond(
    term: type[AbstractNoiseTerm],
    length: int,
    ends: Int[np.ndarray, " edges"],
    sampling: Sampling,
    codes: AngleCodes | None,
) -> Float[np.ndarray, " bins"]:
    """Sums of expected ordinates over each bin's orders above `_EXACT`, per unit power.

    There the ends of the record and the ramp matter no more, and a sum over thousands of orders is
    an integral to 1e-9 (Euler and Maclaurin), which Gauss and Legendre's nodes give exactly.
    """
    low = np.maximum(ends[:-1], _EXACT + 1) - 0.5
    width = np.maximum(ends[1:] - 0.5 - low, 0.0)
    if not width.any():
        return width
    place, weight = np.polynomial.legendre.leggauss(_NODES)
    order = low[:, None] + width[:, None] * (1 + place) / 2
    frequency = np.minimum(order.ravel() / (2 * length), 0.5)
    values = expected_ordinates(term, length, frequency, sampling, codes, low_modes=False)
    return width * (values.reshape(order.shape) @ weight) / 2


@lru_cache(maxsize=32)
def mode_variances(
    length: int, modes: int, sampling: Sampling = "point", codes: AngleCodes | None = None
) -> Float[np.ndarray, "modes terms"]:
    """Variances of the cosine coefficients 1 to `modes` of a stretch, per unit power.

    Of Q, N, B and K along the axis of terms, for a sampling interval of one. `modes` is less than
    the `length` of the stretch in samples; `codes` are as in `design`.
    """
    frequency = np.arange(1, modes + 1) / (2 * length)
    # Constants also where a user traces the fit.
    with jax.ensure_compile_time_eval(), jax.enable_x64(True):
        columns = [
            expected_ordinates(term, length, frequency, sampling, codes) for term in NOISE_TERMS
        ]
    # An ordinate is 2 dt c^2, so c has half its variance.
    return np.stack(columns, axis=-1) / 2


def expected_allan(
    sizes: Int[np.ndarray, " sizes"], sampling: Sampling, codes: AngleCodes | None = None
) -> Float[np.ndarray, "sizes terms"]:
    """Allan variances per unit power of Q, N, B, K and R; under x64."""
    columns = [
        np.asarray(_allan_variance(unit_term(term), sampling, jnp.asarray(sizes, float)))
        for term in (*NOISE_TERMS, RateRamp)
    ]
    if codes is not None:
        # The second difference of three errors, 1, 2, 1 times each and a cluster apart.
        alike = codes.correlation(np.stack([sizes, 2 * sizes]))
        columns[0] = (3 - 4 * alike[0] + alike[1]) / sizes**2
    return np.stack(columns, axis=-1)


def expected_ordinates(
    term: type[AbstractNoiseTerm],
    samples: int,
    frequency: np.ndarray,
    sampling: Sampling,
    codes: AngleCodes | None = None,
    *,
    low_modes: bool = True,
) -> np.ndarray:
    """Those of orders 1 and up of a record of so many samples, per unit power; under x64.

    In chunks of one size, so that all lengths share one compilation. Without `low_modes` the
    frequencies are any at which the ends of the record do not matter.
    """
    padded = np.pad(frequency, (0, -len(frequency) % _CHUNK), constant_values=0.25)
    chunks = [
        np.asarray(_density(unit_term(term), sampling, jnp.asarray(chunk)))
        for chunk in padded.reshape(-1, _CHUNK)
    ]
    expected = np.concatenate(chunks)[: len(frequency)]
    # Errors that are alike cancel less; the first and the last cancel with none anyway.
    coloured = 0.0
    if codes is not None and term is QuantizationNoise:
        coloured = expected * (codes.density_ratio(frequency) - 1)
    if not low_modes:
        return expected + coloured
    order = np.arange(1.0, _LOW_MODES + 1)
    low = np.asarray(_low_mode_ratio(unit_term(term), order, jnp.asarray(samples)))
    expected[:_LOW_MODES] *= low[: len(expected)]
    return expected + coloured


# Terms and orders are arguments: constants would be computed one operation at a time here.
@partial(jax.jit, static_argnums=1)
def _density(
    term: AbstractNoiseTerm, sampling: Sampling, frequency: Float[Array, " chunk"]
) -> Float[Array, " chunk"]:
    return term.density(frequency, 1.0, sampling)


@jax.jit
def _low_mode_ratio(
    term: AbstractNoiseTerm, order: Float[Array, " modes"], samples: Int[Array, ""]
) -> Float[Array, " modes"]:
    return term.low_mode_ratio(order, samples)


@partial(jax.jit, static_argnums=1)
def _allan_variance(
    term: AbstractNoiseTerm, sampling: Sampling, sizes: Float[Array, " sizes"]
) -> Float[Array, " sizes"]:
    return term.allan_variance(sizes, 1.0, sampling)


def unit_term(term: type[AbstractNoiseTerm]) -> AbstractNoiseTerm:
    """The term with a coefficient of one."""
    return term(jnp.asarray(1.0))  # pyright: ignore[reportCallIssue]  (every term has this one field)
