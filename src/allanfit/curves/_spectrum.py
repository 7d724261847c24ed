"""The mirror spectrum: the PSD that loses nothing of a record, whatever its noise.

A record reflected at its ends has no jump for a random walk to leak through, which the plain
periodogram has (it doubles a random walk's density) and which a taper removes at the price of
half the information at low frequency. The Fourier series of the reflected record is the discrete
cosine transform, type II: an orthogonal transform of the samples whose coefficients are exactly
uncorrelated for white noise and for a random walk, and nearly so for flicker noise and angle
quantization. Each of the N - 1 ordinates 2 dt c_j^2 is a chi-square with one degree of freedom
about the density at f_j = j/(2 T).

A rate ramp is a mean and not a density. It fills the odd low coefficients, and is projected out
of them before they are squared, so that what is left knows nothing of it.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ._cosine import dct, idct

# Up to this coefficient the ramp is fitted as if a random walk were the noise, beyond as if the
# noise were white; either way the loss is a few per cent of one degree of freedom.
_WALK_MODES = 8


def cosine_coefficients(x: Float[Array, " samples"]) -> Float[Array, " modes"]:
    """c_1 to c_{N-1} of the orthonormal DCT-II [u], without the mean c_0."""
    return dct(x - jnp.mean(x))[1:]


def slow_part(x: Float[Array, " samples"], modes: int) -> Float[Array, " samples"]:
    """What the coefficients c_1 to c_`modes` say of x: smooth, and without the mean [u]."""
    coefficients = cosine_coefficients(x)
    kept = jnp.where(jnp.arange(1, x.shape[0]) <= modes, coefficients, 0.0)
    return idct(jnp.pad(kept, (1, 0)))


def ramp_coefficients(samples: int, modes: int | None = None) -> Float[np.ndarray, " modes"]:
    """The first cosine coefficients of the ramp x_k = k, all by default: zero for even orders."""
    ramp = np.zeros(samples - 1 if modes is None else modes)
    ramp[::2] = _odd_ramp(samples, np.arange(1, len(ramp) + 1, 2))
    return ramp


def _odd_ramp(
    samples: int, order: Int[np.ndarray, " odd_modes"]
) -> Float[np.ndarray, " odd_modes"]:
    half_angle = np.pi * order / (2 * samples)
    return -np.sqrt(2 / samples) * np.cos(half_angle) / (2 * np.sin(half_angle) ** 2)


class RampProjection(eqx.Module):
    """Replaces odd coefficients by as many less one that no ramp can change.

    With weights w_l that make coefficients of a plausible noise alike, z = w c holds the ramp
    along a unit vector g. A Householder reflection turns g onto the first axis, which is dropped:
    z'_i = z_i - g_i sum_l h_l z_l. At even orders g and h are zero.

    It works on the first `modes` coefficients of a record, all of them by default.
    """

    modes: int = eqx.field(static=True)
    #: g at the odd orders: the others are zero, and a long record has no room for them.
    odd_direction: Float[Array, " odd_modes"] | Float[np.ndarray, " odd_modes"]

    def __init__(self, samples: int, modes: int | None = None):
        self.modes = samples - 1 if modes is None else modes
        odd = np.arange(1, self.modes + 1, 2)
        ramp = _odd_ramp(samples, odd) * _weight(odd)
        # The sign is that of the first coefficient, so that the reflection is well conditioned.
        self.odd_direction = -ramp / np.linalg.norm(ramp)

    @property
    def weight(self) -> Float[np.ndarray, " modes"]:
        """w, in float64 on the host."""
        return _weight(np.arange(1, self.modes + 1))

    @property
    def direction(self) -> Float[Array, " modes"] | Float[np.ndarray, " modes"]:
        """g; on the host if this was made there."""
        return _among_zeros(self.odd_direction, self.modes)

    @property
    def mix(self) -> Float[Array, " modes"] | Float[np.ndarray, " modes"]:
        """h; on the host if this was made there."""
        first = np.arange(self.modes) == 0
        direction = self.direction
        of = jnp if isinstance(direction, jax.Array) else np
        return of.where(first, 1.0, direction / (1 + direction[0]))

    def project(
        self, coefficients: Float[Array, " some"] | Float[np.ndarray, " some"]
    ) -> Float[Array, " rest"] | Float[np.ndarray, " rest"]:
        """Coefficients of order 2 and up that no ramp can change [u]; linear in its argument.

        On the host if the coefficients are there. Fewer are the first, where the others are zero.
        """
        of = jnp if isinstance(coefficients, jax.Array) else np
        modes = coefficients.shape[0]
        # All is at the odd orders.
        weight = _weight(of.arange(1, modes + 1, 2).astype(coefficients.dtype))
        odd = coefficients[::2] * weight
        direction = of.asarray(self.odd_direction[: odd.shape[0]], coefficients.dtype)
        mixed = odd[0] + of.sum(odd[1:] * direction[1:]) / (1 + direction[0])
        return coefficients[1:] - _among_zeros(direction * mixed / weight, modes)[1:]

    def __call__(
        self, coefficients: Float[Array, " modes"] | Float[np.ndarray, " modes"]
    ) -> Float[Array, " rest"] | Float[np.ndarray, " rest"]:
        """Squares of the projected coefficients of order 2 and up [u^2]."""
        return self.project(coefficients) ** 2

    def expectation(
        self, variance: Float[Array, " some"] | Float[np.ndarray, " some"]
    ) -> Float[Array, " rest"] | Float[np.ndarray, " rest"]:
        """What `__call__` expects when the coefficients are independent with these variances.

        Fewer variances are those of the first coefficients, where the others are zero.
        """
        weight, direction, mix = (
            array[: variance.shape[0]] for array in (self.weight, self.direction, self.mix)
        )
        weighted = variance * weight**2
        leaked = direction**2 * (mix**2 * weighted).sum()
        rest = weighted * (1 - 2 * direction * mix) + leaked
        return rest[1:] / weight[1:] ** 2


def _among_zeros(odd, modes: int):
    """Values at the odd orders, with zeros at the even ones."""
    if isinstance(odd, jax.Array):
        # Zeros after the last of them too, where the last order is even.
        after = modes - (2 * len(odd) - 1)
        return jax.lax.pad(odd, jnp.zeros((), odd.dtype), [(0, after, 1)])
    whole = np.zeros(modes, odd.dtype)
    whole[::2] = odd
    return whole


def _weight(order):
    return 1 / (1 / order**2 + 1 / _WALK_MODES**2) ** 0.5
