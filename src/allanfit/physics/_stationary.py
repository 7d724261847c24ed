"""Exact drawing of a stationary Gaussian sequence from its autocovariance."""

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
    size = 2 * samples - 2
    real_key, imaginary_key = jax.random.split(key)
    real = jax.random.normal(real_key, eigenvalues.shape)
    imaginary = jax.random.normal(imaginary_key, eigenvalues.shape)
    # The first and last coefficients of a real sequence are real, with the whole variance.
    ends = np.zeros(len(eigenvalues), bool)
    ends[[0, -1]] = True
    spectrum = jnp.where(ends, real, (real + 1j * imaginary) * np.sqrt(0.5))
    spectrum = spectrum * np.sqrt(np.maximum(eigenvalues, 0) * size)
    return jnp.fft.irfft(spectrum, size)[:samples]
