"""Bias instability: flicker noise of the rate or acceleration."""

import math
from typing import ClassVar

import jax.numpy as jnp
import numpy as np
from jax.scipy.special import digamma, zeta
from jaxtyping import Array, Float, Int, PRNGKeyArray

from ._stationary import sample_from_autocovariance
from ._term import AbstractNoiseTerm, Names, Sampling

#: Allan variance over B^2, at all averaging times.
ALLAN_FLOOR = 2 * math.log(2) / math.pi


class BiasInstability(AbstractNoiseTerm):
    """Flicker noise of coefficient B [u]: S(f) = B^2/(pi f), an Allan deviation of 0.664 B.

    IEEE Std 952, annex C, without its cut-off frequency: B is the coefficient, not the minimum
    of the Allan curve, which holds the other terms too. A sensor that averages follows the flat
    line at every tau. A point-sampled flicker needs a rule for what lies beyond the Nyquist
    frequency; ours is fractional differencing of order one half (Kasdin 1995, Proc. IEEE 83:802),
    the one that simulators draw: S(f) = B^2 dt/sin(pi f dt).
    """

    coefficient: Float[Array, ""]
    symbol: ClassVar[str] = "B"
    names: ClassVar[Names] = Names("bias instability", "bias instability", "bias instability")
    seconds_power: ClassVar[float] = 0

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """B^2 dt/sin(pi f dt), or all aliases of sinc^2(f dt) B^2/(pi f) when averaged [u^2/Hz]."""
        cycles = frequency * dt
        sine = jnp.sin(jnp.pi * cycles)
        if sampling == "point":
            return self.coefficient**2 * dt / sine
        aliases = zeta(jnp.full_like(cycles, 3.0), cycles)
        aliases += zeta(jnp.full_like(cycles, 3.0), 1 - cycles)
        return self.coefficient**2 * dt * sine**2 / np.pi**3 * aliases

    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """(2 ln 2/pi) B^2 [u^2], more at small n when point-sampled (44 % at n = 1)."""
        if sampling == "averaged":
            return self.coefficient**2 * ALLAN_FLOOR * jnp.ones_like(cluster_size)
        difference = _doubly_summed_structure(2 * cluster_size)
        difference -= 4 * _doubly_summed_structure(cluster_size)
        return self.coefficient**2 * difference / (2 * cluster_size**2)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Sum of increments drawn from their exact autocovariance; independent of dt."""
        lag = np.arange(samples, dtype=np.float64)
        if sampling == "point":
            increments = -4 / np.pi / (4 * lag**2 - 1)
        else:
            increments = _averaged_increment_autocovariance(lag)
        return self.coefficient * jnp.cumsum(sample_from_autocovariance(key, increments))

    def low_mode_ratio(
        self, order: Float[Array, "*shape"], samples: int | Int[Array, ""]
    ) -> Float[Array, "*shape"]:
        """(2/pi) (Si(pi j) - (1 - (-1)^j)/(pi j)): what the finite record does to 1/f.

        The expectation of the squared cosine coefficient under the generalised covariance
        -(1/pi) ln|t|, an elementary integral. Si(pi j) is (pi/2) - (-1)^j f(pi j) with the
        auxiliary function f (DLMF 6.2.18).
        """
        x = jnp.pi * order
        sign = jnp.cos(x)
        sine_integral = jnp.pi / 2 - sign * _auxiliary(x)
        return 2 / jnp.pi * (sine_integral - (1 - sign) / x)


def _auxiliary(x: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    """f(x) = integral of exp(-x t)/(1 + t^2) over t > 0 (DLMF 6.7.13), for x >= pi.

    Gauss-Laguerre of order 32 in x t is good to 1e-9 at x = pi and better above.
    """
    node, weight = np.polynomial.laguerre.laggauss(32)
    t = node / x[..., None]
    return jnp.sum(weight / (1 + t**2), axis=-1) / x


def _doubly_summed_structure(n: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Sum over k < n of (n - k) D(k) for Kasdin flicker with B = 1.

    D(k) = (4/pi) (1 + 1/3 + ... + 1/(2k - 1)) is the mean square of x_k - x_0. The variance of
    a sum of n samples is minus this, in the generalised sense, so that the Allan variance is
    (G(2n) - 4 G(n))/(2 n^2).
    """
    odd_harmonic = (digamma(n - 0.5) - digamma(0.5)) / 2
    return 4 / np.pi * ((n**2 - 0.25) * odd_harmonic / 2 - n * (n - 1) / 2 + (n - 1) ** 2 / 8)


def _averaged_increment_autocovariance(lag: np.ndarray) -> np.ndarray:
    """(1/2 pi) times the fourth central difference of k^2 ln|k|, the averaged flicker's increments.

    Beyond lag 32 the difference cancels, and its expansion in derivatives takes over.
    """

    def g(k: np.ndarray) -> np.ndarray:
        return k**2 * np.log(np.maximum(np.abs(k), 1))

    near = g(lag + 2) - 4 * g(lag + 1) + 6 * g(lag) - 4 * g(lag - 1) + g(lag - 2)
    far_lag = np.maximum(lag, 32)
    far = -2 / far_lag**2 - 2 / far_lag**4 - 3 / far_lag**6
    return np.where(lag < 32, near, far) / (2 * np.pi)
