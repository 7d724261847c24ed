"""Allan variance of one series, overlapping or cluster by cluster."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ._cluster_sizes import cluster_sizes as default_cluster_sizes
from ._input import as_series


def allan_variance(
    data: Float[Array, "*sensors samples"] | np.ndarray,
    rate_hz: float,
    cluster_sizes: Sequence[int] | np.ndarray | None = None,
    *,
    overlapping: bool = True,
) -> Float[Array, "*sensors sizes"]:
    """Allan variance [u^2] of samples [u] at cluster sizes n, that is at tau = n/rate_hz.

    Overlapping: half the mean square of the difference of adjacent cluster means over all
    N - 2n + 1 positions (NIST SP 1065, eq. 11). Otherwise the cluster estimator, with means of
    consecutive clusters, the last one of what is left (SEED eq. 8 has the same form).

    **Arguments:**

    - `data`: one sensor, shape (samples,), or several, shape (sensors, samples).
    - `rate_hz`: samples per second. The value does not depend on it; it is checked because a
      sampling interval given for a rate is the likeliest mistake.
    - `cluster_sizes`: increasing integers from 1 to half the record; octaves and three sizes
      between by default (`allanfit.cluster_sizes`).

    **Raises:** `ValueError` for a size out of range, fewer than 3 samples, or data that is not
    one or two axes of real numbers.
    """
    series = as_series(data, rate_hz)
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

    for _ in range(series.ndim - 1):
        single = jax.vmap(single)
    return single(series)


@jax.jit
def overlapping_sums(
    x: Float[Array, " samples"], sizes: Int[Array, " sizes"]
) -> Float[Array, " sizes"]:
    """Half the sum of squared overlapping differences [u^2]; divide by N - 2n + 1 for the variance.

    Sums and not means, because stretches between gaps add. The sizes are traced, so that one
    compilation serves them all; positions that a size does not have are masked.
    """
    samples = x.shape[0]
    high, low = _prefix_sums(x)
    position = jnp.arange(samples)

    @jax.checkpoint
    def one_size(n: Int[Array, ""]) -> Float[Array, ""]:
        def second_difference(prefix: Float[Array, " padded"]) -> Float[Array, " samples"]:
            start, middle, end = (
                jax.lax.dynamic_slice(prefix, (shift,), (samples,)) for shift in (0 * n, n, 2 * n)
            )
            return (end - middle) - (middle - start)

        difference = second_difference(high)
        if low is not None:
            difference += second_difference(low)
        difference = jnp.where(position <= samples - 2 * n, difference, 0.0)
        return jnp.sum(difference**2) / (2 * n.astype(x.dtype) ** 2)

    return jax.lax.map(one_size, sizes)


def _prefix_sums(
    x: Float[Array, " samples"],
) -> tuple[Float[Array, " padded"], Float[Array, " padded"] | None]:
    """Running sums of the samples less their mean, padded so that every slice stays inside.

    In float64 one sum suffices: without its mean, a record grows slowly. In float32 the sum is
    carried as an unevaluated pair (Dekker 1971), because the differences that we want can be a
    million times smaller than the sum itself.
    """
    centred = x - jnp.mean(x)
    pad = (1, x.shape[0] + 1)
    if x.dtype == jnp.float64:
        return jnp.pad(jnp.cumsum(centred), pad), None

    def add(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
        total = a[0] + b[0]
        part = total - a[0]
        error = (a[0] - (total - part)) + (b[0] - part) + a[1] + b[1]
        high = total + error
        return high, error - (high - total)

    high, low = jax.lax.associative_scan(add, (centred, jnp.zeros_like(centred)))
    return jnp.pad(high, pad), jnp.pad(low, pad)


def _cluster(x: Float[Array, " samples"], n: int) -> Float[Array, ""]:
    """The cluster estimator, last partial cluster included with the mean of what it has."""
    samples = x.shape[0]
    whole = samples // n
    centred = x - jnp.mean(x)
    means = jnp.mean(centred[: whole * n].reshape(whole, n), axis=1)
    if samples % n:
        means = jnp.append(means, jnp.mean(centred[whole * n :]))
    return jnp.mean(jnp.diff(means) ** 2) / 2
