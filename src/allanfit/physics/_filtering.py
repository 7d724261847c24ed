"""Filters in the frequency domain, and the split of a record into slow and fast."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float


def filtered(
    samples: Float[Array, " samples"],
    gain: Callable[[Float[Array, " bins"]], Float[Array, " bins"]],
    dt: float,
) -> Float[Array, " samples"]:
    """Samples whose density is multiplied by `gain(frequency)`, without a shift of phase.

    The record goes on as its mirror image, which has no jump at the ends, and its mean passes.
    """
    mean = samples.mean()
    mirrored = jnp.concatenate([samples, samples[::-1]]) - mean
    bins = jnp.arange(samples.shape[0] + 1) / (mirrored.shape[0] * dt)
    spectrum = jnp.fft.rfft(mirrored) * jnp.sqrt(gain(bins))
    return mean + jnp.fft.irfft(spectrum, mirrored.shape[0])[: samples.shape[0]]


def running_mean(samples: Float[Array, " samples"], dt: float) -> Float[Array, " samples"]:
    """Mean over a second, or over 15 samples if that is longer; over what there is at the ends."""
    count = samples.shape[0]
    half = min(max(round(0.5 / dt), 7), count - 1)
    centre = samples.mean()  # kept out of the sum for the sake of its digits
    total = jnp.concatenate([jnp.zeros(1, samples.dtype), jnp.cumsum(samples - centre)])
    index = jnp.arange(count)
    first, last = jnp.maximum(index - half, 0), jnp.minimum(index + half + 1, count)
    return centre + (total[last] - total[first]) / (last - first)
