"""Intervals of time, as several effects have them."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


def inside(
    time: Float[Array, " samples"], intervals: Float[Array, "intervals 2"]
) -> Bool[Array, " samples"]:
    """Which times lie in any of the intervals, starts included and ends not; all in s."""
    started = jnp.searchsorted(jnp.sort(intervals[:, 0]), time, side="right")
    ended = jnp.searchsorted(jnp.sort(intervals[:, 1]), time, side="right")
    return started > ended


def backwards(intervals: Float[Array, "intervals 2"]) -> str:
    """What is wrong where an interval ends before it starts, "" where none does."""
    for start, stop in intervals.tolist():
        if not start <= stop:
            return f"has an interval from {start:g} to {stop:g} s, which ends before it starts"
    return ""
