"""Allan variance of one series, overlapping or cluster by cluster."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float, Int

from ._cluster_sizes import cluster_sizes as default_cluster_sizes
from ._input import as_series

# Sums in one row, and rows of differences that are added before they go there: what is read for
# them fills a core's first cache.
_BLOCK, _ROWS = 1024, 4
_STEP = _BLOCK * _ROWS
# Steps in a tile, which fills half of a core's second cache.
_TILE = 32
# A triangle of ones this wide costs as much to multiply by as its products to read.
_TRIANGLE = 32


def allan_variance(
    data: Float[Array, "*sensors samples"] | np.ndarray | Sequence,
    rate_hz: float,
    cluster_sizes: Sequence[int] | np.ndarray | None = None,
    *,
    overlapping: bool = True,
) -> Float[Array, "*sensors sizes"]:
    """Allan variance [u^2] of samples [u] at cluster sizes n, that is at tau = n/rate_hz.

    Overlapping: half the mean square of the difference of adjacent cluster means over all
    N - 2n + 1 positions (NIST SP 1065, eq. 11). Otherwise the cluster estimator, with means of
    consecutive clusters, the last one of what is left.

    **Arguments:**

    - `data`: one sensor, shape (samples,), or several, shape (sensors, samples).
    - `rate_hz`: samples per second. The value does not depend on it; it is checked because a
      sampling interval given for a rate is the likeliest mistake.
    - `cluster_sizes`: increasing integers from 1 to half the record; octaves and three sizes
      between by default (`allanfit.cluster_sizes`).

    **Returns:** a value a size; NaN throughout for a sensor that holds NaN, for which the others
    of a batch do not suffer.

    **Raises:** `ValueError` for a size out of range, fewer than 3 samples, or data that is not
    one or two axes of real numbers.
    """
    series = as_series(data, rate_hz, single=True)
    samples = series.shape[-1]
    sizes = default_cluster_sizes(samples) if cluster_sizes is None else np.asarray(cluster_sizes)
    if sizes.ndim != 1 or not np.issubdtype(sizes.dtype, np.integer):
        raise ValueError(f"cluster_sizes must be a list of integers; got {cluster_sizes!r}")
    if len(sizes) and (sizes.min() < 1 or 2 * sizes.max() > samples):
        raise ValueError(
            f"cluster sizes must lie between 1 and half of the {samples} samples; "
            f"got {sizes.min()} to {sizes.max()}"
        )

    def single(x: Float[Array, " samples"]) -> Float[Array, " sizes"]:
        if overlapping:
            return overlapping_sums(x, jnp.asarray(sizes)) / (samples - 2 * sizes + 1)
        return jnp.stack([_cluster(x, int(n)) for n in sizes])

    return single(series) if series.ndim == 1 else each_series(single, series)


def each_series(
    single: Callable[[Float[Array, " samples"]], Float[Array, " out"]],
    series: Float[Array, "sensors samples"],
) -> Float[Array, "sensors out"]:
    """`single` of each series: at once on an accelerator, on a processor one a core.

    A core is fastest when it has one series in its cache; the cores know nothing of one another.
    """
    if isinstance(series, Tracer) or any(d.platform != "cpu" for d in series.devices()):
        return jax.vmap(single)(series)
    # Taken apart and stacked by NumPy: JAX compiles programs for every number of series.
    apart = map(jnp.asarray, np.asarray(series))
    with ThreadPoolExecutor(min(os.cpu_count() or 1, max(len(series), 1))) as pool:
        return jnp.asarray(np.stack(list(pool.map(single, apart))))


@jax.custom_jvp
@jax.jit
def overlapping_sums(
    x: Float[Array, " samples"], sizes: Int[Array, " sizes"]
) -> Float[Array, " sizes"]:
    """Half the sum of squared overlapping differences [u^2]; divide by N - 2n + 1 for the variance.

    Sums and not means, because stretches between gaps add. The sizes are traced, so that one
    compilation serves them all. Differences are squared and added block by block into a vector
    that stays in the cache, and that vector is summed once. All sizes take their turn at one tile
    of the record before the next, so that what they have in common is read from memory once.
    """
    samples = x.shape[0]
    prefixes = _prefix_sums(x)
    positions = samples - 2 * sizes + 1
    whole = positions // _STEP

    def squares(step: Int[Array, ""], n: Int[Array, ""]) -> Float[Array, " block"]:
        total = jnp.zeros(_BLOCK, x.dtype)
        for row in range(_ROWS):
            total += _difference(prefixes, step * _STEP + row * _BLOCK, n, _BLOCK) ** 2
        return total

    def one_tile(tile: Int[Array, ""], sums: Float[Array, "sizes block"]):
        first = tile * _TILE

        def one_size(i: Int[Array, ""], sums: Float[Array, "sizes block"]):
            n, last = sizes[i], jnp.minimum(first + _TILE, whole[i])
            row = jax.lax.fori_loop(first, last, lambda step, row: row + squares(step, n), sums[i])
            return sums.at[i].set(row)

        return jax.lax.fori_loop(0, sizes.shape[0], one_size, sums)

    tiles = samples // (_TILE * _STEP) + 1
    sums = jnp.zeros((sizes.shape[0], _BLOCK), x.dtype)
    sums = jax.lax.fori_loop(0, tiles, one_tile, sums)
    place = jnp.arange(_STEP)

    def with_rest(i: Int[Array, ""]) -> Float[Array, ""]:
        rest = _difference(prefixes, whole[i] * _STEP, sizes[i], _STEP) ** 2
        return jnp.sum(sums[i]) + jnp.sum(
            jnp.where(place < positions[i] - whole[i] * _STEP, rest, 0.0)
        )

    return jax.lax.map(with_rest, jnp.arange(sizes.shape[0])) / (2 * sizes.astype(x.dtype) ** 2)


@overlapping_sums.defjvp
def _overlapping_slopes(primals, tangents):
    """The derivative along dx: the sum of differences of x times those of dx.

    A loop of unknown length cannot be run backwards, so here all positions are taken, and those
    that a size does not have are masked.
    """
    x, sizes = primals
    dx, _ = tangents
    samples = x.shape[0]
    prefixes, moved = (_prefix_sums(each, samples) for each in (x, dx))
    position = jnp.arange(samples)

    @jax.checkpoint
    def one_size(n: Int[Array, ""]) -> Float[Array, ""]:
        product = _difference(prefixes, 0 * n, n, samples) * _difference(moved, 0 * n, n, samples)
        product = jnp.where(position <= samples - 2 * n, product, 0.0)
        return jnp.sum(product) / n.astype(x.dtype) ** 2

    return overlapping_sums(x, sizes), jax.lax.map(one_size, sizes)


def _difference(
    prefixes: tuple[Float[Array, " padded"], ...],
    start: Int[Array, ""],
    n: Int[Array, ""],
    length: int,
) -> Float[Array, " length"]:
    """N times the difference of adjacent means of n samples, at `length` positions from `start`."""
    total = jnp.zeros(length, prefixes[0].dtype)
    for prefix in prefixes:
        first, middle, last = (
            jax.lax.dynamic_slice(prefix, (start + shift,), (length,))
            for shift in (0 * n, n, 2 * n)
        )
        total += (last - middle) - (middle - first)
    return total


def _prefix_sums(
    x: Float[Array, " samples"], beyond: int = _STEP
) -> tuple[Float[Array, " padded"], ...]:
    """Running sums of the samples less their mean, longer so that every slice stays inside.

    In float64 one sum suffices: without its mean, a record grows slowly. In float32 the sum is
    carried as an unevaluated pair (Dekker 1971), because the differences that we want can be a
    million times smaller than the sum itself.
    """
    padded = jnp.pad(x - jnp.mean(x), (1, beyond))
    if x.dtype == jnp.float64:
        return (_running_sum(padded),)

    def add(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
        total = a[0] + b[0]
        part = total - a[0]
        error = (a[0] - (total - part)) + (b[0] - part) + a[1] + b[1]
        high = total + error
        return high, error - (high - total)

    return jax.lax.associative_scan(add, (padded, jnp.zeros_like(padded)))


def _running_sum(x: Float[Array, " samples"]) -> Float[Array, " samples"]:
    """The cumulative sum by products with a triangle of ones, which compilers do well."""
    rows = -(-x.shape[0] // _TRIANGLE)
    table = jnp.pad(x, (0, rows * _TRIANGLE - x.shape[0])).reshape(rows, _TRIANGLE)
    within = table @ jnp.triu(jnp.ones((_TRIANGLE, _TRIANGLE), x.dtype))
    before = jnp.cumsum(within[:, -1]) - within[:, -1]
    return (within + before[:, None]).reshape(-1)[: x.shape[0]]


@partial(jax.jit, static_argnums=1)
def _cluster(x: Float[Array, " samples"], n: int) -> Float[Array, ""]:
    """The cluster estimator, last partial cluster included with the mean of what it has."""
    samples = x.shape[0]
    whole = samples // n
    centred = x - jnp.mean(x)
    means = jnp.mean(centred[: whole * n].reshape(whole, n), axis=1)
    if samples % n:
        means = jnp.append(means, jnp.mean(centred[whole * n :]))
    return jnp.mean(jnp.diff(means) ** 2) / 2
