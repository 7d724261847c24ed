"""The numbers that a record leaves behind: both curves, and what tells of a ramp."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import scipy.fft
from jaxtyping import Array, Float

from ._allan import overlapping_sums
from ._cluster_sizes import cluster_sizes
from ._design import RAMP_MODES, Design
from ._long import squared_differences
from ._spectrum import cosine_coefficients


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
    for x, index, project in zip(stretches, design.bin_index, design.projection, strict=True):
        coefficients = cosine_coefficients(x)
        ordinates = 2 * project(coefficients)
        density += jax.ops.segment_sum(
            ordinates, index, num_segments=len(density), indices_are_sorted=True
        )
        odd = coefficients[: 2 * RAMP_MODES : 2]
        odd_modes.append(jnp.pad(odd, (0, RAMP_MODES - len(odd))))
        # Sizes too long for this stretch come last, and it has nothing to say about them.
        reach = int(np.sum(2 * cluster_sizes(max(design.lengths)) <= x.shape[0]))
        sizes = jnp.asarray(design.cluster_sizes[:reach])
        allan = allan.at[:reach].add(overlapping_sums(x, sizes))
    return Statistics(
        density / jnp.asarray(design.ordinates, density.dtype),
        allan / jnp.asarray(design.differences, allan.dtype),
        jnp.stack(odd_modes),
    )


def statistics_on_host(
    stretches: tuple[Float[np.ndarray, " _"], ...], design: Design
) -> Statistics:
    """As `statistics`, in float64 and without compiling anything for the length of a stretch.

    A record with hundreds of gaps has hundreds of lengths.
    """
    sizes = np.asarray(design.cluster_sizes)
    density, allan, odd_modes = np.zeros(len(design.ordinates)), np.zeros(len(sizes)), []
    for x, index, project in zip(stretches, design.bin_index, design.projection, strict=True):
        centred = np.asarray(x, float) - np.mean(x, dtype=float)
        coefficients = np.asarray(scipy.fft.dct(centred, norm="ortho"))[1:]
        ordinates = 2 * np.asarray(project(coefficients))
        density += np.bincount(np.asarray(index), ordinates, minlength=len(density))
        odd = coefficients[: 2 * RAMP_MODES : 2]
        odd_modes.append(np.pad(odd, (0, RAMP_MODES - len(odd))))
        allan += squared_differences(centred, sizes) / (2.0 * sizes**2)
    found = density / design.ordinates, allan / design.differences, np.stack(odd_modes)
    return Statistics(*map(jnp.asarray, found))
