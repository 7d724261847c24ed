"""Which stretches of a recording its coefficients come from."""

from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from ..curves import Design, as_series, unit_scale
from ..curves._spectrum import cosine_coefficients
from ._chance import Bins, beyond_chance, noise_deviations, ramp_deviations, stand_in_points
from ._estimate import as_design_dtype, padded_bins
from ._fit import Fit
from ._shares import (
    noise_expectation,
    noise_parts,
    ramp_matrix,
    ramp_rows,
    spectral_weights,
)

# Nominal probability that a recording that is the same throughout has a piece that stands out.
# At 0.01, 12 of 1000 simulated ones had: the weights follow the data, as in no simulation.
_FALSE_ALARM = 0.007
_FEWEST_SAMPLES = 4
# Shares are of the squares of Q, N, B, K, and of R itself.
EXPONENTS = (0.5, 0.5, 0.5, 0.5, 1.0)


class Influence(eqx.Module):
    """The share of each coefficient that each piece of a recording holds.

    Axes of terms run over Q, N, B, K, R. A term that the fit puts at zero has NaN shares.
    """

    #: Ends of the pieces, from the start of the recording [s], shape (pieces + 1,).
    time_s: Float[Array, " edges"]
    #: Shares, shape (5, pieces); each term's sum to one. A negative share pulls its term down.
    share: Float[Array, "terms pieces"]
    #: What a recording that is the same throughout is expected to have there.
    expected: Float[Array, "terms pieces"]
    #: Whether a piece's share is further from its expectation than chance allows.
    stands_out: Bool[Array, "terms pieces"]

    @property
    def change(self) -> Float[Array, "terms pieces"]:
        """Factor by which each coefficient would change without the piece, predicted.

        With the weights of the fit held fixed, theta'^2/theta^2 = (1 - share)/(1 - expected).
        Against fits of disturbed records without each of 20 pieces in turn, the correlation was
        0.999 for N, 0.83 for B and 0.99 for K, with slopes of 1.0, 0.9 and 1.06.
        """
        exponents = jnp.asarray(EXPONENTS, self.share.dtype)[:, None]
        return change(self.share, self.expected, exponents)


def change(
    share: float | Float[Array, "..."],
    expected: float | Float[Array, "..."],
    exponent: float | Float[Array, "..."],
) -> Float[Array, "..."]:
    """Factor on a coefficient without samples that hold a `share`: its fair share of the rest."""
    return (jnp.maximum(1 - jnp.asarray(share), 0.0) / (1 - jnp.asarray(expected))) ** exponent


def influence(
    fit: Fit,
    data: Float[Array, " samples"] | np.ndarray,
    stretches: tuple[tuple[int, int], ...] | None = None,
    *,
    pieces: int = 60,
    seed: int = 0,
) -> Influence:
    """Which pieces of the record drive each least-squares coefficient.

    The shares are exact parts of the coefficient (Parseval's theorem, see `_shares`). A piece
    stands out where its share is one that fewer than 1 % of recordings that follow the fitted
    model throughout would have anywhere, in any resolved term: 1000 such are simulated.

    **Arguments:**

    - `fit`: one sensor's fit, from `allanfit.fit`.
    - `data`, `stretches`: the samples that were fitted, and the stretches if they had gaps.
    - `pieces`: how many pieces of equal length the recording is cut into, gaps included.
    - `seed`: of the simulations.

    **Raises:** `ValueError` if the data are not those of the fit, or there are too many pieces.
    """
    series = as_series(data, 1.0)
    stretches = ((0, series.shape[-1]),) if stretches is None else tuple(stretches)
    lengths = tuple(stop - start for start, stop in stretches)
    if series.ndim != 1 or lengths != fit.design.lengths or stretches[-1][1] > series.shape[0]:
        raise ValueError(
            f"influence needs the one series that was fitted, in stretches of "
            f"{list(fit.design.lengths)} samples; got shape {series.shape} in {list(lengths)}"
        )
    if not 2 <= pieces <= sum(lengths) // _FEWEST_SAMPLES:
        raise ValueError(
            f"pieces must be between 2 and {sum(lengths) // _FEWEST_SAMPLES}, a quarter of the "
            f"samples; got {pieces}"
        )
    edges = np.rint(np.linspace(stretches[0][0], stretches[-1][1], pieces + 1)).astype(int)
    inside = np.stack([np.clip(edges - start, 0, stop - start) for start, stop in stretches])
    found = _shares(
        tuple(series[start:stop] for start, stop in stretches),
        fit.design,
        jnp.asarray(inside),
        fit.estimate.least_squares / unit_scale(1 / fit.rate_hz),
    )
    stands_out = _stands_out(
        found,
        jnp.asarray(inside.sum(axis=0) / sum(lengths), found.share.dtype),
        jnp.asarray(sum(lengths), found.share.dtype),
        fit.estimate.resolved,
        jax.random.key(seed),
        points=stand_in_points(sum(lengths)),
    )
    time_s = jnp.asarray(edges / fit.rate_hz, found.share.dtype)
    return Influence(time_s, found.share, found.expected, stands_out)


class _Shares(NamedTuple):
    """Shares and their expectations as in `Influence`, and what chance makes of them."""

    share: Float[Array, "terms pieces"]
    expected: Float[Array, "terms pieces"]
    #: The squared coefficients and the ramp itself, NaN for those at zero.
    whole: Float[Array, "terms 1"]
    bins: Bins
    #: Of the pieces' parts of the ramp.
    ramp_covariance: Float[Array, "pieces pieces"]


@eqx.filter_jit
def _shares(
    stretches: tuple[Float[Array, " _"], ...],
    design: Design,
    inside: Int[Array, "stretches edges"],
    coefficients: Float[Array, " terms"],
) -> _Shares:
    """What depends on the lengths of the stretches; coefficients for a sampling interval of 1."""
    dtype = coefficients.dtype
    design = as_design_dtype(design, dtype)
    power = coefficients[:-1] ** 2
    weights = spectral_weights(power, design)
    mean = design.density @ power
    rows, variances = ramp_rows(power, design)
    bin_index = [jnp.asarray(index) for index in design.bin_index]

    # One matrix a stretch; what depends on the stretch's length cannot be mapped so.
    lengths = jnp.asarray(design.lengths, dtype)
    fractions = inside.astype(dtype) / lengths[:, None]
    matrices = jax.vmap(ramp_matrix)(rows, fractions)
    parts, expected = [], []
    for i, (x, index) in enumerate(zip(stretches, bin_index, strict=True)):
        modes = cosine_coefficients(x)
        low = jnp.zeros(matrices.shape[2], dtype).at[: len(modes)].set(modes[: matrices.shape[2]])
        gain = 2 * weights / design.ordinates
        rest = jnp.asarray(design.projection[i].project(modes))
        noise = noise_parts(rest, gain, index, inside[i])
        parts.append(jnp.concatenate([noise, (matrices[i] @ low)[None]]))
        noise = noise_expectation(gain * mean / 2, index, fractions[i])
        ramp = coefficients[-1] * (matrices[i, :, ::2] @ design.ramp[i])
        expected.append(jnp.concatenate([noise, ramp[None]]))

    whole = jnp.append(power, coefficients[-1])[:, None]
    whole = jnp.where(whole == 0, jnp.nan, whole)
    ordinates = jnp.asarray(design.ordinates)
    bins = Bins(weights * mean / ordinates, jnp.asarray(design.frequency), ordinates)
    return _Shares(
        sum(parts) / whole,
        sum(expected) / whole,
        whole,
        bins.padded(padded_bins(len(ordinates))),
        jnp.einsum("spo,so,sqo->pq", matrices, variances, matrices),
    )


@partial(jax.jit, static_argnames="points")
def _stands_out(
    found: _Shares,
    used: Float[Array, " edges"],
    samples: Float[Array, ""],
    resolved: Bool[Array, " terms"],
    key: PRNGKeyArray,
    *,
    points: int,
) -> Bool[Array, "terms pieces"]:
    """Which pieces chance does not explain; one program for records of nearly all lengths."""
    noise_key, ramp_key = jax.random.split(key)
    noise = noise_deviations(noise_key, found.bins, samples, points, used)
    ramp = ramp_deviations(ramp_key, found.ramp_covariance, found.expected[-1])
    simulated = jnp.concatenate([noise, ramp[:, None]], axis=1) / found.whole
    deviation = found.share - found.expected
    return beyond_chance(deviation, simulated, found.expected, resolved, _FALSE_ALARM)
