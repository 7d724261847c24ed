"""The discrete cosine transform by one real Fourier transform of the same length.

Makhoul (1980), A fast cosine transform in one and two dimensions, IEEE Trans. ASSP 28:27. JAX's
own transform goes by complex numbers throughout, which takes twice the memory and the time.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int


def dct(x: Float[Array, " samples"]) -> Float[Array, " samples"]:
    """The orthonormal transform of type II."""
    count = x.shape[0]
    # Samples of even place, then those of odd place from the end back.
    folded = jnp.concatenate([x[::2], x[1::2][::-1]])
    turned = jnp.fft.rfft(folded) * _turn(count, -1, x.dtype)
    # Orders up to the half are the real part, those beyond the imaginary part from the end back.
    upper = -turned.imag[1 : (count - 1) // 2 + 1][::-1]
    plain = jnp.concatenate([turned.real, upper]) * (2 / count) ** 0.5
    return plain.at[0].multiply(0.5**0.5)


def idct(coefficients: Float[Array, " samples"]) -> Float[Array, " samples"]:
    """The inverse of `dct`."""
    count = coefficients.shape[0]
    folded = idct_folded(coefficients)
    x = jnp.zeros(count, folded.dtype)
    return x.at[::2].set(folded[: (count + 1) // 2]).at[1::2].set(folded[: -(count // 2) - 1 : -1])


def idct_folded(coefficients: Float[Array, " samples"]) -> Float[Array, " samples"]:
    """The inverse of `dct`, in the order of the transform: see `folded_sums`."""
    count = coefficients.shape[0]
    half = count // 2 + 1
    plain = (coefficients * (count / 2) ** 0.5).at[0].multiply(2**0.5)
    mirrored = jnp.concatenate([jnp.zeros(1, plain.dtype), plain[: count - half : -1]])
    turned = (plain[:half] - 1j * mirrored) * _turn(count, 1, plain.dtype)
    return jnp.fft.irfft(turned, count)


def folded_sums(
    folded: Float[Array, " samples"], edges: Int[Array, " edges"]
) -> Float[Array, " pieces"]:
    """Sums between samples `edges` of what stands in the order of `idct_folded`.

    Samples of even place come first, then those of odd place from the end back, so that a long
    record need not be put in order for its sums.
    """
    total = jnp.pad(jnp.cumsum(folded), (1, 0))
    before = total[(edges + 1) // 2] + total[-1] - total[folded.shape[0] - edges // 2]
    return jnp.diff(before)


def _turn(count: int, sign: int, dtype) -> Array:
    """exp(i sign pi k/(2 count)) for the orders of a real Fourier transform."""
    order = jnp.arange(count // 2 + 1, dtype=dtype)
    angle = order * (sign * np.pi / (2 * count))
    return jnp.cos(angle) + 1j * jnp.sin(angle)
