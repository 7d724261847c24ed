"""A coefficient as a sum over time: what each piece of the record contributes to it, exactly.

**Noise.** At the least-squares solution the squared coefficients are linear in the binned
spectrum P: the score vanishes, so that they equal their own Fisher-scoring step

    theta^2 = sum_b g_b P_b,   g = I^-1 E' diag(shape/m^2),

E being the expectations and m = E theta^2 their sum. P is a sum of squares of cosine
coefficients, hence theta^2 = sum_j w_j c_j^2: the energy of the record behind a filter of gain
sqrt|w|, counted negative at the frequencies where the fit takes off what belongs to another term.
Parseval's theorem moves that energy into time,

    theta^2 = sum_t y_t z_t,   y = sqrt|w| * x,   z = sign(w) sqrt|w| * x.

The filter whitens what it looks for, so that a step adds to the walk where it happens and nowhere
else, as sharply as the walk can be seen at all. (By Euler's theorem the sum over increments of x
times the derivative with respect to them is theta as well. But then each piece carries the white
noise of its two end samples, which swamps flicker and walk.)

**Ramp.** The ramp is linear in the lowest cosine coefficients, R = sum_j a_j c_j. Their sines are
the increments of the record, U = sum_j j c_j s_j, and R is the integral of U S with
S = sum_j (a_j/j) s_j, because sines are orthogonal.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..curves import Design
from ..curves._cosine import folded_sums, idct_folded
from ._likelihood import Powers, fisher_information

# Orders of the ramp: it fills every other one of them.
_RAMP_ORDERS = np.arange(1, 64)
_RAMP_POINTS = 4096
# How many waves are long enough for a piece to notice that the record has ends.
_SLOW_ORDERS = 128


def spectral_weights(power: Powers, design: Design) -> Float[Array, "terms bins"]:
    """The weights g of the bins; zero for a term at zero. Their sum with m is theta^2 as well."""
    expected, shape = jnp.asarray(design.density), jnp.asarray(design.ordinates) / 2
    information = fisher_information(power, expected, shape)
    unit = jnp.sqrt(jnp.diag(information))
    present = power > 0
    pairs = present[:, None] & present
    correlation = jnp.where(pairs, information / unit / unit[:, None], jnp.eye(len(power)))
    sensitivity = jnp.where(present[:, None], expected.T / unit[:, None], 0.0)
    scoring = jnp.linalg.solve(correlation, sensitivity * (shape / (expected @ power) ** 2))
    return scoring / unit[:, None]


def noise_parts(
    coefficients: Float[Array, " rest"],
    weights: Float[Array, "terms bins"],
    index: Int[Array, " rest"],
    edges: Int[Array, " edges"],
) -> Float[Array, "terms pieces"]:
    """Parts of sum_j w_j c_j^2 that lie between samples `edges` of one stretch.

    `coefficients` are those of order 2 and up, and `index` says which weight each has.
    """

    def present(weight: Float[Array, " bins"]) -> Float[Array, " pieces"]:
        first = jnp.sqrt(jnp.abs(weight))[index] * coefficients
        product = _signal(first) * _signal(jnp.sign(weight)[index] * first)
        return folded_sums(product, edges)

    def absent(_: Float[Array, " bins"]) -> Float[Array, " pieces"]:
        return jnp.zeros(len(edges) - 1, coefficients.dtype)

    def one_term(weight: Float[Array, " bins"]) -> Float[Array, " pieces"]:
        return jax.lax.cond(jnp.any(weight != 0), present, absent, weight)

    # One term after the other, so that a long record needs the memory of one.
    return jax.lax.map(one_term, weights)


def noise_expectation(
    ordinates: Float[Array, "terms bins"],
    index: Int[Array, " rest"],
    edges: Float[Array, " edges"],
) -> Float[Array, "terms pieces"]:
    """What `noise_parts` expects if each w_j c_j^2 has the mean that `ordinates` gives its bin.

    In proportion to time, but for slow waves, which are all at a crest at the ends of a record.
    `edges` are fractions of the stretch.
    """
    level = ordinates @ jnp.bincount(index, length=ordinates.shape[1]).astype(ordinates.dtype)
    slow = index[:_SLOW_ORDERS]
    order = jnp.arange(2, 2 + len(slow), dtype=ordinates.dtype)
    crests = jnp.sin(2 * jnp.pi * order * edges[:, None]) / (2 * jnp.pi * order)
    return jnp.diff(level[:, None] * edges + ordinates[:, slow] @ crests.T, axis=1)


def ramp_rows(
    power: Powers, design: Design
) -> tuple[Float[Array, "stretches odd_orders"], Float[Array, "stretches orders"]]:
    """a_1, a_3, ... of each stretch, and the variance of each of its low coefficients [u^2].

    The fit has no need of the variances at even orders: they lie between their neighbours'.
    """
    odd = jnp.where(design.ramp != 0, design.ramp_variance @ power, 0.0)
    weight = jnp.where(odd > 0, design.ramp / jnp.where(odd > 0, odd, 1.0), 0.0)
    even = jnp.sqrt(odd[:, 1:] * odd[:, :-1])
    variances = jnp.zeros((len(odd), len(_RAMP_ORDERS)), odd.dtype)
    variances = variances.at[:, ::2].set(odd).at[:, 1::2].set(even)
    return weight / jnp.sum(weight * design.ramp), variances


def ramp_matrix(
    row: Float[Array, " odd_orders"], edges: Float[Array, " edges"]
) -> Float[Array, "pieces orders"]:
    """What each piece adds to sum a_j c_j for each low coefficient, `row` being a_1, a_3, ...

    `edges` are fractions of the stretch. Each column but for a_j sums to zero.
    """
    middle = (np.arange(_RAMP_POINTS) + 0.5) / _RAMP_POINTS
    sine = jnp.asarray(np.sin(np.pi * _RAMP_ORDERS * middle[:, None]), row.dtype)
    odd = _RAMP_ORDERS[::2]
    slope = sine[:, ::2] @ (row / odd)
    product = slope[:, None] * sine * _RAMP_ORDERS * (2 / _RAMP_POINTS)
    total = jnp.pad(jnp.cumsum(product, axis=0), ((1, 0), (0, 0)))
    points = jnp.arange(_RAMP_POINTS + 1) / _RAMP_POINTS
    at_edges = jax.vmap(lambda column: jnp.interp(edges, points, column), 1, 1)(total)
    return jnp.diff(at_edges, axis=0)


def _signal(coefficients: Float[Array, " rest"]) -> Float[Array, " samples"]:
    return idct_folded(jnp.pad(coefficients, (2, 0)))
