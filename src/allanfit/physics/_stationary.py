"""Drawing of a stationary Gaussian sequence from its autocovariance, or from its spectrum."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray


def sample_from_autocovariance(
    key: PRNGKeyArray, autocovariance: np.ndarray
) -> Float[Array, " samples"]:
    """Circulant embedding (Davies and Harte 1987, Biometrika 74:95).

    `autocovariance` holds lags 0 to samples - 1 [u^2]. The embedding must be non-negative, which
    it is for the increments of flicker noise; anything below zero beyond rounding is refused.
    """
    samples = len(autocovariance)
    eigenvalues = np.fft.rfft(np.concatenate([autocovariance, autocovariance[-2:0:-1]])).real
    if eigenvalues.min() < -1e-6 * eigenvalues.max():
        raise ValueError("the autocovariance has no non-negative circulant embedding")
    return sample_from_eigenvalues(key, np.maximum(eigenvalues, 0))[:samples]


def sample_from_eigenvalues(
    key: PRNGKeyArray, eigenvalues: np.ndarray | Float[Array, " half"]
) -> Float[Array, " size"]:
    """A periodic sequence whose covariance matrix has these eigenvalues [u^2], zero or more.

    They are S(f)/(2 dt) at f = k/(size dt), k from 0 to size/2, where S is its one-sided density.
    """
    half = len(eigenvalues)
    size = 2 * half - 2
    real_key, imaginary_key = jax.random.split(key)
    real = jax.random.normal(real_key, (half,))
    imaginary = jax.random.normal(imaginary_key, (half,))
    # The first and last coefficients of a real sequence are real, with the whole variance.
    ends = np.zeros(half, bool)
    ends[[0, -1]] = True
    spectrum = jnp.where(ends, real, (real + 1j * imaginary) * np.sqrt(0.5))
    return jnp.fft.irfft(spectrum * jnp.sqrt(eigenvalues * size), size)
