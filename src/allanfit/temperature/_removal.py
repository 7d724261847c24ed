"""The noise of a record whose temperature may have moved it, whatever the sensitivity.

What a regression leaves knows nothing of the slopes. It also has fewer degrees of freedom, in the
modes where temperature changes, and less power than the noise had there: read as noise, it would
make K too small and every interval that follows too short. So each ordinate of the spectrum of
the residuals keeps the degrees of freedom that are left to it, 1 - h_j with h_j its leverage, and
has the expectation that the regression gives it, linear in the noise powers as before. With
weights that whiten the noise this is restricted maximum likelihood (Patterson and Thompson 1971,
Biometrika 58:545); with others it is unbiased all the same.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..curves import Design, Statistics, cosine_coefficients, statistics
from ..curves._design import RAMP_MODES
from ..identify._estimate import as_design_dtype

_Stretches = tuple[Float[Array, " _"], ...]
# A bin with less than this much of an ordinate left says nothing.
_LEAST_ORDINATES = 0.02


class Removal(eqx.Module):
    """A record without what temperature explains, ready to be fitted."""

    #: The slopes that were taken out [u per unit of the column].
    slopes: Float[Array, " two"]
    statistics: Statistics
    #: What the noise is expected to leave in them.
    design: Design


@eqx.filter_jit
def remove(
    stretches: _Stretches,
    columns: tuple[Float[Array, "_ two"], ...],
    variances: tuple[Float[Array, "_ terms"], ...],
    design: Design,
    power: Float[Array, " terms"],
) -> Removal:
    """Take two slow columns out of a record by least squares with weights for noise of `power`.

    **Arguments:**

    - `stretches`: the samples between gaps [u].
    - `columns`: the temperature and its square at each sample, with no modes beyond those of
      `variances`.
    - `variances`: of the slow modes of each stretch, per unit power of each term.
    - `design`: of the record as it is.
    """
    dtype = stretches[0].dtype
    design = as_design_dtype(design, dtype)
    response, regressors, expected, index = [], [], [], []
    for i, (x, column, variance) in enumerate(zip(stretches, columns, variances, strict=True)):
        projection, modes = design.projection[i], variance.shape[0]
        project = lambda c, p=projection, m=modes: p.project(c)[: m - 1]  # noqa: E731
        response.append(project(cosine_coefficients(x)))
        regressors.append(jax.vmap(project, 1, 1)(_coefficients(column)))
        expected.append(jax.vmap(projection.expectation, 1, 1)(variance))
        index.append(jnp.asarray(design.bin_index[i])[: modes - 1])
    response, regressors, variance, index = (
        jnp.concatenate(parts) for parts in (response, regressors, expected, index)
    )
    deviation = jnp.sqrt(variance @ power)
    basis, factor = jnp.linalg.qr(regressors / deviation[:, None])
    slopes = jnp.linalg.solve(factor, basis.T @ (response / deviation))

    rest = tuple(x - column @ slopes for x, column in zip(stretches, columns, strict=True))
    found = statistics(rest, design)
    leverage = jnp.sum(basis**2, axis=1)
    bins = len(design.ordinates)
    ordinates = design.ordinates - jax.ops.segment_sum(leverage, index, bins)
    left = ordinates > _LEAST_ORDINATES
    ordinates = jnp.where(left, ordinates, _LEAST_ORDINATES)
    change = jax.ops.segment_sum(_change(basis, leverage, deviation, variance), index, bins)
    count = design.ordinates[:, None]
    density = (design.density * count + 2 * change) / ordinates[:, None]
    odd_modes, ramp = _ramp_without(found.odd_modes, columns, design, power)
    return Removal(
        slopes,
        found._replace(
            density=jnp.where(
                left, found.density * design.ordinates / ordinates, design.density @ power
            ),
            odd_modes=odd_modes,
        ),
        eqx.tree_at(
            lambda tree: (tree.ordinates, tree.density, tree.ramp),
            design,
            (ordinates, jnp.where(left[:, None], density, design.density), ramp),
        ),
    )


def _coefficients(column: Float[Array, "samples two"]) -> Float[Array, "modes two"]:
    return jax.vmap(cosine_coefficients, 1, 1)(column)


def _change(
    basis: Float[Array, "modes two"],
    leverage: Float[Array, " modes"],
    deviation: Float[Array, " modes"],
    variance: Float[Array, "modes terms"],
) -> Float[Array, "modes terms"]:
    """What the regression adds to the expected square of each coefficient, per unit power.

    The whitened residual is r = z - G G' z, hence E r_i^2 = v_i (1 - 2 h_i) + g_i' (G' v G) g_i.
    """
    whitened = variance / deviation[:, None] ** 2
    inner = jnp.einsum("ia,it,ib->tab", basis, whitened, basis)
    mixed = jnp.einsum("ia,tab,ib->it", basis, inner, basis)
    return (mixed - 2 * leverage[:, None] * whitened) * deviation[:, None] ** 2


def _ramp_without(
    odd_modes: Float[Array, "stretches modes"],
    columns: tuple[Float[Array, "_ two"], ...],
    design: Design,
    power: Float[Array, " terms"],
) -> tuple[Float[Array, "stretches modes"], Float[Array, "stretches modes"]]:
    """The odd modes and the ramp without what of them temperature could make.

    A slope in time is then known only by what it does that the temperature does not (Frisch and
    Waugh 1933, Econometrica 1:387).
    """
    odd = []
    for column in columns:
        modes = _coefficients(column)[: 2 * RAMP_MODES : 2]
        odd.append(jnp.pad(modes, ((0, RAMP_MODES - len(modes)), (0, 0))))
    deviation = jnp.sqrt(jnp.asarray(design.ramp_variance) @ power)
    basis, _ = jnp.linalg.qr((jnp.stack(odd) / deviation[..., None]).reshape(-1, 2))

    def without(modes: Float[Array, "stretches modes"]) -> Float[Array, "stretches modes"]:
        whitened = (modes / deviation).ravel()
        return (whitened - basis @ (basis.T @ whitened)).reshape(modes.shape) * deviation

    return without(odd_modes), without(jnp.asarray(design.ramp))
