"""How much the means of stretches of noise scatter, and differences between them.

The mean over T is the increment of the integrated noise over T, divided by T. For noise whose
increments are stationary everything follows from one even function, the generalised variance
V(T) of that increment:

- N: N^2 T;
- B: -(B^2/pi) T^2 (ln T - 3/2), from the covariance -(B^2/pi) ln|t| of flicker noise;
- K: -K^2 T^3/6, from the covariance -K^2 |t|/2 of a random walk.

The covariance of the means of [s, s + a] and [u, u + b] is

    (V(u + b - s) - V(u - s) - V(u + b - s - a) + V(u - s - a)) / (2 a b),

and it holds in every sum whose weights add up to zero: only differences of a wandering bias have
a variance. Two means of neighbouring stretches of T differ with variance N^2 (2/T),
B^2 (4 ln 2/pi), K^2 (2T/3): twice the Allan variance at T, as they must.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float


def white_weights(
    lengths_s: Sequence[float], weights: Sequence[float]
) -> Float[np.ndarray, " terms"]:
    """What Q^2, N^2, B^2, K^2 and R^2 add to the variance of a weighted sum of means: Q, N alone.

    The means are over separate recordings of these lengths [s]. A mean holds the difference of
    two rounding errors of its integral, one at either end: 2 Q^2/T^2, and N^2/T.
    """
    length, weight = np.asarray(lengths_s, float), np.asarray(weights, float)
    quantization, white = 2 * weight**2 / length**2, weight**2 / length
    return np.array([quantization.sum(), white.sum(), 0.0, 0.0, 0.0])


def drift_weights(
    starts_s: Sequence[float], lengths_s: Sequence[float], weights: Sequence[float]
) -> Float[np.ndarray, " terms"]:
    """The same for the bias that wanders under the white noise: B, K and the ramp R.

    **Arguments:** when each stretch starts [s], how long it is [s], and its weight; the weights
    add up to zero.

    **Raises:** `ValueError` for weights that do not, since the variance is then infinite.
    """
    start, length, weight = (np.asarray(each, float) for each in (starts_s, lengths_s, weights))
    if not abs(weight.sum()) < 1e-9 * np.abs(weight).sum():
        raise ValueError(f"weights of a drift's means must add up to zero; got {list(weight)}")
    stop = start + length
    outer = weight[:, None] * weight / (2 * length[:, None] * length)
    ramp = float(weight @ (start + stop) / 2) ** 2

    def total(variance) -> float:
        pair = variance(stop - start[:, None]) - variance(start - start[:, None])
        pair += variance(start - stop[:, None]) - variance(stop - stop[:, None])
        return float((outer * pair).sum())

    return np.array([0.0, 0.0, total(_flicker), total(_walk), ramp])


def _flicker(time_s: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """V for B = 1; at 0 its limit, 0."""
    size = np.abs(time_s)
    return -(size**2) * (np.log(np.where(size > 0, size, 1.0)) - 1.5) / np.pi


def _walk(time_s: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """V for K = 1."""
    return -(np.abs(time_s) ** 3) / 6
