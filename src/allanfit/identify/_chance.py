"""How far shares stray by chance in a record that follows the fitted model throughout."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from ._shares import noise_expectation, noise_parts

_SIMULATIONS = 1000
# Points of the record that stands in for the real one: 17 in each of 60 pieces.
_POINTS = 1024
_RUN_LENGTHS = (1, 2, 4, 8, 16)
# Runs of a term that may stand out, taken in order of distance.
_MOST_RUNS = 8


class Bins(NamedTuple):
    """What the bins of the spectrum add to each squared coefficient, by expectation."""

    #: w_j E c_j^2 of one ordinate of each bin, shape (4, bins).
    ordinates: Float[Array, "terms bins"]
    #: Mean frequency [cycles per sample] and number of ordinates, shape (bins,).
    frequency: Float[Array, " bins"]
    count: Float[Array, " bins"]

    def padded(self, bins: int) -> "Bins":
        """The same with empty bins at the end, up to so many."""
        more = (0, bins - len(self.count))
        return Bins(
            jnp.pad(self.ordinates, ((0, 0), more)),
            jnp.pad(self.frequency, more, constant_values=jnp.inf),
            jnp.pad(self.count, more),
        )


def stand_in_points(samples: int) -> int:
    """How many points the record has that stands in for one of so many samples."""
    return min(samples, _POINTS)


def noise_deviations(
    key: PRNGKeyArray,
    bins: Bins,
    samples: Float[Array, ""],
    points: int,
    edges: Float[Array, " edges"],
) -> Float[Array, "simulations terms pieces"]:
    """Parts of theta^2 less their expectation in simulated records, given the sum of the parts.

    A stand-in of so many `points`, without gaps, has the low orders of the record. Its high
    orders, with many waves in every piece, only add a Gaussian amount of known variance to each.
    `edges` are fractions of the samples used.
    """
    ordinates, frequency, count = bins
    order = np.arange(2, points)
    between = jnp.sqrt(frequency[1:] * frequency[:-1])
    index = jnp.searchsorted(between, jnp.asarray(order, samples.dtype) / (2 * samples))
    beyond = jnp.where(frequency > points / (2 * samples), count, 0.0)
    variance = 2 * ordinates**2 @ beyond

    whole = jnp.rint(edges * points).astype(int)
    fraction = jnp.diff(whole) / points
    expected = noise_expectation(ordinates, index, whole / points)
    expected += (ordinates @ beyond)[:, None] * fraction
    total = jnp.sum(expected, axis=1, keepdims=True)
    expected = expected / jnp.where(total > 0, total, 1.0)

    numbers = (_SIMULATIONS, len(order) + len(fraction))
    draws = jax.random.normal(key, numbers, samples.dtype)
    low, high = draws[:, : len(order)], draws[:, len(order) :]
    parts = jax.vmap(noise_parts, (0, None, None, None))(low, ordinates, index, whole)
    parts += jnp.sqrt(variance[:, None] * fraction) * high[:, None]
    return parts - expected * jnp.sum(parts, axis=-1, keepdims=True)


def ramp_deviations(
    key: PRNGKeyArray,
    covariance: Float[Array, "pieces pieces"],
    expected: Float[Array, " pieces"],
) -> Float[Array, "simulations pieces"]:
    """Parts of the ramp less their expectation in records of noise, given the sum of the parts."""
    values, vectors = jnp.linalg.eigh(covariance)
    draws = jax.random.normal(key, (_SIMULATIONS, len(values)), covariance.dtype)
    parts = draws * jnp.sqrt(jnp.maximum(values, 0.0)) @ vectors.T
    return parts - expected * jnp.sum(parts, axis=1, keepdims=True)


def beyond_chance(
    deviation: Float[Array, "terms pieces"],
    simulated: Float[Array, "simulations terms pieces"],
    expected: Float[Array, "terms pieces"],
    resolved: Bool[Array, " terms"],
    false_alarm: float,
) -> Bool[Array, "terms pieces"]:
    """Pieces in runs whose deviation exceeds what chance brings to any run of a resolved term.

    A run is compared with the median piece, lest one that holds much of a term makes all others
    look poor. Runs of 1, 2, 4, 8 and 16 pieces are scanned, since a walk is seen no sharper than
    its own time scale and a warm-up lasts, each length by the tail that its own runs have; of
    runs that overlap, the one furthest away counts. Terms share the `false_alarm` probability
    alike.
    """
    scanned = _runs(deviation.shape[-1])
    runs = jnp.asarray(scanned, deviation.dtype)

    def of_runs(
        deviation: Float[Array, "*draws terms pieces"],
    ) -> Float[Array, "*draws terms runs"]:
        relative = jnp.where(expected > 0, deviation / expected, jnp.nan)
        typical = jnp.nanmedian(relative, axis=-1, keepdims=True)
        return (deviation - expected * typical) @ runs.T

    together = of_runs(jnp.concatenate([deviation[None], simulated]))
    spread = jnp.std(together[1:], axis=0)
    known = (spread > 0) & resolved[:, None]
    together = jnp.abs(together) / jnp.where(known, spread, jnp.inf)
    level = 1 - false_alarm / jnp.maximum(jnp.sum(resolved), 1)
    lengths, which = np.unique(scanned.sum(axis=1), return_inverse=True)
    largest = [jnp.max(together[1:, :, which == i], axis=-1) for i in range(len(lengths))]
    tails = jnp.quantile(jnp.stack(largest, axis=-1), level, axis=0)
    together = together / jnp.where(tails > 0, tails, 1.0)[:, which]
    distance = together[0]
    limit = jnp.quantile(jnp.max(together[1:], axis=-1), level, axis=0)

    def mark(distance: Float[Array, " runs"], limit: Float[Array, ""]) -> Bool[Array, " pieces"]:
        def take(left: Float[Array, " runs"], _: None) -> tuple[Array, Array]:
            run = runs[jnp.argmax(left)]
            return jnp.where(runs @ run > 0, 0.0, left), (run > 0) & (jnp.max(left) > limit)

        return jnp.any(jax.lax.scan(take, distance, length=_MOST_RUNS)[1], axis=0)

    return jax.vmap(mark)(distance, limit)


def _runs(pieces: int) -> Float[np.ndarray, "runs pieces"]:
    """One row a run, with ones at its pieces."""
    piece = np.arange(pieces)
    rows = [
        (piece >= first) & (piece < first + length)
        for length in _RUN_LENGTHS
        if length <= pieces // 2
        for first in range(pieces - length + 1)
    ]
    return np.array(rows, float)
