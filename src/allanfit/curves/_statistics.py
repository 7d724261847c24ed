"""The numbers that a record leaves behind: both curves, and what tells of a ramp."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ._allan import overlapping_sums
from ._design import RAMP_MODES, Design
from ._spectrum import RampProjection, cosine_coefficients


class Statistics(NamedTuple):
    """Both curves of one record, for a sampling interval of one (density per cycle per sample)."""

    #: Mean mirror-spectrum ordinate of each bin, shape (bins,) [u^2].
    density: Float[Array, " bins"]
    #: Overlapping Allan variance, shape (sizes,) [u^2].
    allan: Float[Array, " sizes"]
    #: First odd cosine coefficients of each stretch, where a ramp shows [u].
    odd_modes: Float[Array, "stretches modes"]


def statistics(stretches: tuple[Float[Array, " _"], ...], design: Design) -> Statistics:
    """Both curves of a record, whose `stretches` between gaps are independent pieces.

    No stretch knows of another: nothing is interpolated and no difference bridges a gap.
    """
    density = jnp.zeros(len(design.ordinates), stretches[0].dtype)
    allan = jnp.zeros(len(design.cluster_sizes), stretches[0].dtype)
    odd_modes = []
    for x, index in zip(stretches, design.bin_index, strict=True):
        coefficients = cosine_coefficients(x)
        ordinates = 2 * RampProjection(x.shape[0])(coefficients)
        density += jax.ops.segment_sum(
            ordinates, index, num_segments=len(density), indices_are_sorted=True
        )
        odd = coefficients[: 2 * RAMP_MODES : 2]
        odd_modes.append(jnp.pad(odd, (0, RAMP_MODES - len(odd))))
        sizes = design.cluster_sizes[2 * design.cluster_sizes <= x.shape[0]]
        allan = allan.at[: len(sizes)].add(overlapping_sums(x, jnp.asarray(sizes)))
    return Statistics(
        density / design.ordinates.astype(density.dtype),
        allan / design.differences.astype(allan.dtype),
        jnp.stack(odd_modes),
    )
