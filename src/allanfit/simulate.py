"""Draw recordings from a noise model."""

import math
from collections.abc import Mapping, Sequence

import jax
from jaxtyping import Array, Float

from .physics import AbstractEffect, Sampling, check_sampling, draw_recording, standard_model

# More than fits the memory of any machine that this runs on.
_MOST_SAMPLES = 1e11
# What JAX makes a key of.
_SEED_BITS = 63


def simulate(
    coefficients: Mapping[str, float],
    *,
    duration_s: float,
    rate_hz: float,
    seed: int,
    sampling: Sampling = "point",
    bias: float = 0.0,
    effects: Sequence[AbstractEffect] = (),
) -> Float[Array, " samples"]:
    """A record with the five terms, exact in law: no filter or sum of relaxations stands in.

    **Arguments:**

    - `coefficients`: by symbol Q, N, B, K, R, in the unit u of the record and seconds; what is
      not named is zero.
    - `duration_s`, `rate_hz`: length and samples per second.
    - `seed`: the same seed gives the same record; below 2^63.
    - `sampling`: "point" or "averaged", see `allanfit.physics`.
    - `bias`: constant added [u].
    - `effects`: from `allanfit.physics`, beside the five terms; in whatever order they are given,
      they act in that of a sensor (`allanfit.physics.draw_recording`).

    **Returns:** samples [u], shape (round(duration_s rate_hz),).

    **Raises:** `ValueError` for an unknown symbol, a coefficient that is negative or infinite, a
    bias that is no finite number, another sampling, a seed of more than 63 bits, and too short or
    long a record.

    >>> simulate({"N": 1e-3}, duration_s=10, rate_hz=100, seed=0).shape
    (1000,)
    """
    if not (0 < rate_hz < math.inf and 0 < duration_s * rate_hz <= _MOST_SAMPLES):
        raise ValueError(
            f"duration and rate must be positive and make at most {_MOST_SAMPLES:g} samples; got "
            f"{duration_s:g} s at {rate_hz:g} Hz."
        )
    check_sampling(sampling)
    samples = round(duration_s * rate_hz)
    if samples < 2:
        raise ValueError(f"{duration_s:g} s at {rate_hz:g} Hz are {samples} samples; 2 are needed.")
    for symbol, value in coefficients.items():
        if not 0 <= value < math.inf:
            raise ValueError(f"coefficient {symbol} must be zero or more, and finite; got {value}.")
    if not math.isfinite(bias):
        raise ValueError(f"bias must be a finite number; got {bias}.")
    if not abs(seed) < 2**_SEED_BITS:
        raise ValueError(f"seed must be below 2^{_SEED_BITS}; got {seed}.")
    model = standard_model(coefficients)
    key = jax.random.key(seed)
    return draw_recording(key, model, effects, samples, 1 / rate_hz, sampling, bias)
