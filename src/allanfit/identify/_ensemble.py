"""An affine-invariant ensemble sampler in JAX, for batches of sensors."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray


def ensemble(
    key: PRNGKeyArray,
    log_density: Callable[[Float[Array, " dim"]], Float[Array, ""]],
    start: Float[Array, "walkers dim"],
    *,
    burn_in: int,
    draws: int,
    thin: int,
) -> tuple[Float[Array, "draws walkers dim"], Float[Array, ""]]:
    """Moves of two half-ensembles in turn, each walker by means of the other half.

    One in four is a stretch (Goodman and Weare 2010, CAMCoS 5:65), the others steps along the
    difference of two walkers (ter Braak 2006, Stat. Comput. 16:239), a full difference now and
    then. The same moves as emcee makes, without leaving JAX, so that `vmap` runs a chain a sensor.

    **Returns:** the draws after `burn_in` steps, one in `thin`, and the accepted fraction.
    """
    half, dimension = start.shape[0] // 2, start.shape[1]
    density = jax.vmap(log_density)
    usual_step = 2.38 / (2 * dimension) ** 0.5

    def move(key, movers, movers_density, others):
        # One call, because every one compiles to a hundred operations.
        partner, apart, uniform, kind, accept = jax.random.uniform(key, (5, half), start.dtype)
        first = (half * partner).astype(int)
        second = (first + 1 + ((half - 1) * apart).astype(int)) % half
        # Density of the stretch z proportional to 1/sqrt(z) on [1/2, 2].
        stretch = (1 + uniform) ** 2 / 2
        stretched = others[first] + stretch[:, None] * (movers - others[first])
        length = jnp.where(kind < 0.35, 1.0, usual_step)
        # A hundredth of a step at random keeps walkers off a lattice.
        length = length * (0.99 + 0.02 * uniform)
        shifted = movers + length[:, None] * (others[first] - others[second])
        stretching = kind < 0.25
        proposal = jnp.where(stretching[:, None], stretched, shifted)
        proposal_density = density(proposal)
        volume = jnp.where(stretching, (dimension - 1) * jnp.log(stretch), 0.0)
        log_ratio = volume + proposal_density - movers_density
        accept = jnp.log(accept) < log_ratio
        return (
            jnp.where(accept[:, None], proposal, movers),
            jnp.where(accept, proposal_density, movers_density),
            jnp.mean(accept),
        )

    def half_step(state, key):
        # The halves change places, so that one compiled move serves both.
        movers, movers_density, others, others_density = state
        movers, movers_density, rate = move(key, movers, movers_density, others)
        return (others, others_density, movers, movers_density), rate

    def thinned(state, keys):
        state, rates = jax.lax.scan(half_step, state, keys)
        return state, (jnp.concatenate([state[0], state[2]]), jnp.mean(rates))

    warm_up = -(-burn_in // thin)
    keys = jax.random.split(key, (warm_up + draws, 2 * thin))
    first, second = start[:half], start[half:]
    state = (first, density(first), second, density(second))
    _, (chain, rates) = jax.lax.scan(thinned, state, keys)
    return chain[warm_up:], jnp.mean(rates[warm_up:])
