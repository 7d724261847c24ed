"""The classical reading of an Allan deviation plot, for comparison with a fit."""

import math

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..physics import ALLAN_FLOOR
from ._allan import allan_variance
from ._input import as_series

# In the order in which the lines stand along tau.
_SLOPES = {"Q": -1.0, "N": -0.5, "B": 0.0, "K": 0.5, "R": 1.0}
# What to multiply sigma(tau) by: each term's line is read where the standards read it, Q at
# tau = sqrt(3) s, N at 1 s, K at 3 s, R at sqrt(2) s, and B as the flat level over 0.664.
_FACTORS = {
    "Q": 1 / math.sqrt(3),
    "N": 1.0,
    "B": 1 / math.sqrt(ALLAN_FLOOR),
    "K": math.sqrt(3),
    "R": math.sqrt(2),
}
# A part of the curve counts as a term's line when its slope is as near as this.
_NEAR = 0.25
# Beyond a tenth of the record fewer than ten differences of clusters are independent.
_LONGEST = 10
_FEWEST_OCTAVES = 3


def slope_reading(
    data: Float[Array, "*sensors samples"] | np.ndarray, rate_hz: float
) -> dict[str, Float[Array, "*sensors"]]:
    """Q, N, B, K, R as they are read off an Allan deviation plot with a ruler.

    A line of each term's slope is laid through the octave of tau, up to a tenth of the record,
    where the local log-log slope is closest to it. The lines keep the order of their slopes along
    tau, Q left of N and N left of B, K and R, since such a slope elsewhere is another's doing.
    They are read where IEEE Std 952-1997 (annex C) and IEEE Std 1293 do: N on the slope -1/2 at
    1 s, Q on the slope -1 at sqrt(3) s, B at the flat part over sqrt(2 ln 2/pi) = 0.664, K on the
    slope +1/2 at 3 s, R on the slope +1 at sqrt(2) s.

    **It has no uncertainty and is biased**: terms overlap, so that each line carries some of its
    neighbours, and one octave of the curve stands for all. It is here to show what many tools
    report. Use `allanfit.fit` for the coefficients themselves.

    **Arguments:**

    - `data`: samples [u] of one sensor, shape (samples,), or of several, (sensors, samples);
      at least 40.
    - `rate_hz`: samples per second.

    **Returns:** by symbol, in u and seconds as `Fit.coefficients`; NaN for a term whose slope no
    part of the curve that is in order comes within 0.25 of.

    **Raises:** `ValueError` for too few samples, a wrong shape or a rate that is not positive.

    >>> slope_reading(samples, rate_hz=100.0)["N"]
    """
    series = as_series(data, rate_hz, single=True)
    sizes = octaves(series.shape[-1])
    variance = allan_variance(series, rate_hz, sizes)
    return read_slopes(jnp.asarray(sizes / rate_hz, variance.dtype), jnp.sqrt(variance))


def octaves(samples: int) -> np.ndarray:
    """The cluster sizes that a slope reading looks at: 1, 2, 4, ... up to a tenth of a record.

    **Raises:** `ValueError` for fewer than 40 samples, since two octaves make no slope.
    """
    fewest = _LONGEST * 2 ** (_FEWEST_OCTAVES - 1)
    if samples < fewest:
        raise ValueError(f"a slope reading needs at least {fewest} samples; got {samples}")
    return 2 ** np.arange(int(math.log2(samples // _LONGEST)) + 1)


def read_slopes(
    tau_s: Float[Array, " octaves"], deviation: Float[Array, "*sensors octaves"]
) -> dict[str, Float[Array, "*sensors"]]:
    """`slope_reading` of an Allan deviation [u] at averaging times an octave apart [s]."""
    # JAX sorts what it compiles by name.
    found = _read_slopes(tau_s, deviation)
    return {symbol: found[symbol] for symbol in _SLOPES}


@jax.jit
def _read_slopes(
    tau_s: Float[Array, " octaves"], deviation: Float[Array, "*sensors octaves"]
) -> dict[str, Float[Array, "*sensors"]]:
    slope = jnp.asarray(jnp.gradient(jnp.log2(deviation), axis=-1))
    near = {symbol: _NEAR - jnp.abs(slope - wanted) for symbol, wanted in _SLOPES.items()}
    # The curve of a dead channel has no slope anywhere.
    near = {s: jnp.where(jnp.isfinite(each), each, 0.0).clip(0.0) for s, each in near.items()}
    places = dict(zip("NBKR", _in_order([near[symbol] for symbol in "NBKR"]), strict=True))
    # Q comes last: taken together with the others, a fall at the far end, where chance rules, could
    # be read as Q and have N read even farther out.
    left = jnp.arange(slope.shape[-1]) < jnp.stack([*places.values()]).min(axis=0)
    (places["Q"],) = _in_order([jnp.where(left, near["Q"], 0.0)])

    def read(symbol: str) -> Float[Array, "*sensors"]:
        line = _FACTORS[symbol] * deviation * tau_s ** -_SLOPES[symbol]
        return jnp.take_along_axis(_and_beyond(line, jnp.nan), places[symbol], axis=-1)[..., 0]

    return {symbol: read(symbol) for symbol in _SLOPES}


def _in_order(near: list[Float[Array, "*sensors octaves"]]) -> list[Int[Array, "*sensors 1"]]:
    """The octave of each term, left of those of the terms after it; beyond the last if it has none.

    Of all such choices the one whose sum of `near` is largest, where only positive ones count: each
    term's own largest, if these are in order.
    """
    octaves = near[0].shape[-1]
    # The largest sums that the terms from each on can have, in the octaves from each on.
    sums = [_and_beyond(jnp.zeros_like(near[0]), 0.0)]
    for each in reversed(near):
        with_it = jnp.maximum(each + sums[0][..., 1:], sums[0][..., :-1])
        sums.insert(0, _and_beyond(jax.lax.cummax(with_it, with_it.ndim - 1, reverse=True), 0.0))
    places, start = [], jnp.zeros_like(near[0][..., :1], int)
    for each, later in zip(near, sums[1:], strict=True):
        allowed = (each > 0) & (jnp.arange(octaves) >= start)
        with_it = jnp.where(allowed, each + later[..., 1:], -1.0)
        place = jnp.argmax(with_it, axis=-1, keepdims=True)
        read = jnp.max(with_it, axis=-1, keepdims=True) >= jnp.take_along_axis(later, start, -1)
        places.append(jnp.where(read, place, octaves))
        start = jnp.where(read, place + 1, start)
    return places


def _and_beyond(
    values: Float[Array, "*sensors octaves"], beyond: float
) -> Float[Array, "*sensors more_octaves"]:
    """One value more, for what lies beyond the last octave."""
    widths = [(0, 0)] * (values.ndim - 1) + [(0, 1)]
    return jnp.pad(values, widths, constant_values=beyond)
