"""An affine-invariant ensemble sampler in JAX, for batches of sensors."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

# The log-density of one walker's position.
_Density = Callable[[Float[Array, " dim"]], Float[Array, ""]]


def ensemble(
    key: PRNGKeyArray,
    log_density: _Density,
    surrogate: _Density,
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

    A half makes `thin` moves by a `surrogate`, which is cheap and nearly the `log_density`; then
    each walker's way as a whole is accepted or taken back by what the two densities make of its
    ends, so that the draws are those of `log_density` (the surrogate transition of Liu 2001,
    Monte Carlo Strategies in Scientific Computing, section 9.4.3). The other half stands still
    meanwhile, without which the way back would not be as likely as the way there.

    **Returns:** the draws after `burn_in` steps, one in `thin`, and the fraction of moves that
    were accepted by the surrogate and of ways that were accepted after that, multiplied.
    """
    half, dimension = start.shape[0] // 2, start.shape[1]
    usual_step = 2.38 / (2 * dimension) ** 0.5
    exact, cheap = jax.vmap(log_density), jax.vmap(surrogate)

    def move(movers, movers_density, others, uniforms):
        partner, apart, uniform, kind, accept = uniforms
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
        proposal_density = cheap(proposal)
        volume = jnp.where(stretching, (dimension - 1) * jnp.log(stretch), 0.0)
        log_ratio = volume + proposal_density - movers_density
        accept = jnp.log(accept) < log_ratio
        return (
            jnp.where(accept[:, None], proposal, movers),
            jnp.where(accept, proposal_density, movers_density),
            jnp.mean(accept),
        )

    def half_step(state, key):
        # The halves change places, so that one compiled way serves both.
        (movers, density, guessed), others = state
        move_key, judge_key = jax.random.split(key)
        uniforms = jax.random.uniform(move_key, (thin, 5, half), start.dtype)

        def step(walkers, uniforms):
            positions, guessed, rate = move(walkers[0], walkers[1], others[0], uniforms)
            return (positions, guessed), rate

        (moved, moved_guessed), rates = jax.lax.scan(step, (movers, guessed), uniforms)
        moved_density = exact(moved)
        log_ratio = (moved_density - density) - (moved_guessed - guessed)
        accept = jnp.log(jax.random.uniform(judge_key, (half,), start.dtype)) < log_ratio
        walkers = (
            jnp.where(accept[:, None], moved, movers),
            jnp.where(accept, moved_density, density),
            jnp.where(accept, moved_guessed, guessed),
        )
        return (others, walkers), jnp.mean(rates) * jnp.mean(accept)

    def both(state, keys):
        state, rates = jax.lax.scan(half_step, state, keys)
        return state, (jnp.concatenate([state[0][0], state[1][0]]), jnp.mean(rates))

    warm_up = -(-burn_in // thin)
    keys = jax.random.split(key, (warm_up + draws, 2))
    walkers = (start, exact(start), cheap(start))
    state = tuple(tuple(part[rows] for part in walkers) for rows in np.s_[:half, half:])
    _, (chain, rates) = jax.lax.scan(both, state, keys)
    return chain[warm_up:], jnp.mean(rates[warm_up:])
