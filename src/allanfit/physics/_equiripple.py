"""Elliptic filters: ripple in the pass band, lobes of one height in the stop band.

|H|^2 = 1/(1 + eps^2 R_n(x)^2) at x = frequency over the edge of the pass band, with the elliptic
rational function R_n (Orfanidis, Lecture Notes on Elliptic Filter Design, 2006). Without lobes
they are Chebyshev's filters, without ripple his inverse ones, and without either Butterworth's.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float

#: Poles at most.
MOST_POLES = 10
_PAIRS = np.arange(MOST_POLES // 2)
# Powers of the nome in the theta functions; it is below 0.65, and the next is lost in rounding.
_POWERS = np.arange(9.0)
# Nothing is passed at a zero and there is no ripple at another: neither has a logarithm.
_LEAST = 1e-18
# Halvings that find the cut-off; a step of Newton after them gives its slopes.
_HALVINGS = 40


def equiripple_gain(
    frequency: Float[Array, "*shape"],
    cutoff: Float[Array, ""],
    order: Float[Array, ""],
    ripple: Float[Array, ""],
    attenuation: Float[Array, ""],
) -> Float[Array, "*shape"]:
    """|H|^2 over that at zero, with half of it at the cut-off; frequencies in any unit.

    Of a whole order up to `MOST_POLES`, a ripple [dB] of 3 at most and an attenuation [dB] of 15 at
    least. (With more ripple half of the power is left in the pass band already.)
    """
    strength = jnp.log(jnp.expm1(ripple * np.log(10) / 10))
    nome = _nome(strength - jnp.log(jnp.expm1(attenuation * np.log(10) / 10))) / order
    zeros, stretch = _zeros(nome, order)

    def rational(log_x: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        return strength + _log_square(log_x, zeros, stretch, order)

    # Of an even order the gain at zero is that of a valley of the ripple.
    even = 1 - order % 2
    half = jnp.log1p(2 * even * jnp.exp(strength))
    edge = _where(rational, half, -jnp.log(stretch) / 2)
    still = 1 + even * jnp.exp(strength)
    log_x = jnp.log(jnp.maximum(frequency / cutoff, _LEAST)) + edge
    return still * jax.nn.sigmoid(-rational(log_x))


def _nome(log_m: Float[Array, ""]) -> Float[Array, ""]:
    """Logarithm of the nome of a parameter m that is small (DLMF 19.5.5)."""
    y = jnp.exp(log_m) / 16
    return log_m - np.log(16) + jnp.log1p(y * (8 + y * (84 + y * 992)))


def _zeros(
    log_nome: Float[Array, ""], order: Float[Array, ""]
) -> tuple[Float[Array, " pairs"], Float[Array, ""]]:
    """Zeros x_i = cd((2i - 1)K/n, k) of R_n, and k^2, by theta functions (DLMF 22.2.4, 22.2.2)."""
    turn = np.pi / 2 * (2 * _PAIRS + 1) / order
    odd = jnp.exp(log_nome * _POWERS * (_POWERS + 1))
    even = jnp.exp(log_nome * _POWERS**2) * np.where(_POWERS > 0, 2, 1)
    second = odd @ jnp.cos((2 * _POWERS[:, None] + 1) * turn)
    third = even @ jnp.cos(2 * _POWERS[:, None] * turn)
    zeros = second / odd.sum() * even.sum() / third
    # k = (theta_2/theta_3)^2, and theta_2 is 2 q^(1/4) times the sum.
    squared = 16 * jnp.exp(log_nome) * (odd.sum() / even.sum()) ** 4
    return zeros, squared


def _log_square(log_x, zeros, stretch, order):
    """Logarithm of R_n(x)^2, which is one at x = 1."""
    x = jnp.exp(2 * jnp.minimum(log_x, 40.0))[..., None]
    zero = jnp.square(zeros)
    there = order // 2 > _PAIRS

    def factor(at):
        up, down = jnp.square(at - zero), jnp.square(1 - stretch * zero * at)
        return jnp.log(up + _LEAST) - jnp.log(down + _LEAST)

    factors = jnp.where(there, factor(x) - factor(jnp.ones(())), 0.0)
    return factors.sum(axis=-1) + order % 2 * 2 * log_x


def _where(rational, goal, highest):
    """Where log x reaches a goal, between the edges of the pass band and of the stop band."""
    fixed = lax.stop_gradient

    def halve(_, ends):
        low, high = ends
        middle = (low + high) / 2
        below = fixed(rational(middle)) < fixed(goal)
        return jnp.where(below, middle, low), jnp.where(below, high, middle)

    ends = jnp.zeros_like(highest), fixed(highest)
    low, high = lax.fori_loop(0, _HALVINGS, halve, ends)
    middle = (low + high) / 2
    slope = fixed(jax.grad(rational)(middle))
    return middle - (rational(middle) - goal) / slope
