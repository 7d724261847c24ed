"""What each effect puts into each bin, or does to what is there; pure JAX.

Frequencies are in cycles per sample, and densities for a sampling interval of one.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...physics import Bump, DriftingLine, GaussMarkov, PowerLaw, Resonance, Sampling
from ._ordinates import _NODES, averaged
from ._structure import (
    ANALOGUE_EQUIRIPPLE,
    ECHO,
    FILTERS,
    FLAT,
    FLOOR,
    HIGH_PASS,
    NOTCH,
    OVERSAMPLED,
    UNNAMED,
    left_of,
    part_of,
    shape_of,
    sieve,
)

# The mean of two squared normal variates is above the exponential of this once in a hundred times.
_TWO_ENDS = 1.6


def added_density(
    name: str, three: Any, nodes: Any, samples: Any, sampling: Sampling = "point"
) -> Float[Array, " bins"]:
    """What an added noise puts into each bin [u^2]; exp(three[0]) is its scale squared.

    Of the aliases that averages have of a resonance none are counted; a line that wanders is as
    large as it is among the samples.
    """
    nodes = jnp.asarray(nodes)
    first, second = shape_of(name, three, samples)
    one = jnp.ones(())
    middle = nodes[:, 1]
    if name == "gauss_markov":
        density = GaussMarkov(one, first).density(middle, 1.0, sampling)
    elif name == "power_law":
        density = PowerLaw(first, one).density(middle, 1.0, sampling)
    else:
        # A peak narrower than a bin cannot fall between nodes: it is as broad as the bin.
        wide = breadth(nodes)

        def peak(f, b):
            if name == "resonance":
                broad = 1 / _broader(1 / second, b / first)
                return Resonance(one, first, broad).density(f, 1.0, "point")
            return DriftingLine(one, first, jnp.hypot(first * second, b / 4)).density(
                f, 1.0, "point"
            )

        density = averaged(jax.vmap(peak)(nodes, wide))
        if name == "resonance" and sampling == "averaged":
            density *= jnp.sinc(middle) ** 2
    return jnp.exp(jnp.maximum(three[0], FLOOR)) * density


def breadth(nodes: Any) -> Any:
    """Of each bin [cycles per sample]."""
    return (nodes[:, 2] - nodes[:, 0]) / (_NODES[2] - _NODES[0])


def _broader(width: Any, bin_width: Any) -> Any:
    """A sharp choice of the broader: nodes see a peak that is as broad as its bin."""
    quarter = jnp.square(jnp.square(width)) + jnp.square(jnp.square(bin_width))
    return jnp.sqrt(jnp.sqrt(quarter))


def notched(three: Any, nodes: Any, samples: Any) -> Float[Array, " bins"]:
    """The gain of a notch in each bin; one that is narrower than a bin is as shallow there."""
    nodes, lack = jnp.asarray(nodes), 1 - left_of(three)
    frequency, width = shape_of(NOTCH, three, samples)

    def at(frequencies, bin_width):
        broad = _broader(width, bin_width / frequency)
        shallow = jnp.log1p(-lack * width / broad)
        return Bump(shallow, frequency, broad, notch=True).gain(frequencies, 1.0)

    return averaged(jax.vmap(at)(nodes, breadth(nodes)))


def shaped(shaping: str | None, four: Any, nodes: Any, samples: Any) -> tuple[Any, Any, Any]:
    """What white noise is multiplied by, with aliases and a floor, |H|^2 itself, and the bump.

    One where there is none.
    """
    nodes = jnp.asarray(nodes)
    middle = nodes[:, 1]
    if shaping in FILTERS:
        found = sieve(shaping, four, samples)
        if found.after_converter:
            # Averaged over each bin: zeros are narrower than bins.
            passed = averaged(found.passed(nodes, 1.0))
            return found.raised(passed), passed, jnp.ones_like(middle)
        if shaping in (OVERSAMPLED, ANALOGUE_EQUIRIPPLE):
            # An edge may be as steep as a bin is wide, too.
            either = found.gain(nodes, 1.0), found.passed(nodes, 1.0)
            return *map(averaged, either), jnp.ones_like(middle)
        return found.gain(middle, 1.0), found.passed(middle, 1.0), jnp.ones_like(middle)
    if shaping in UNNAMED:
        high_pass = shaping == HIGH_PASS
        where = shape_of(shaping, four, samples)
        if shaping == ECHO:
            part, period = part_of(four), where[0]
            gain = Bump(part, period, jnp.ones_like(part), echo=True).gain(middle, 1.0)
            # Averaged over bins that may hold several ripples.
            gain = 1 + part**2 + (gain - 1 - part**2) * jnp.sinc(breadth(nodes) / period)
            return jnp.ones_like(middle), jnp.ones_like(middle), gain
        height, flat = jnp.tanh(four[0] / 6) * 6, shaping == FLAT
        gain = Bump(height, *where, high_pass=high_pass, flat=flat).gain(middle, 1.0)
        if high_pass:
            # Two ends leak it, and their squares are up to some times their mean.
            gain += end_leakage(*where) / samples * jnp.exp(_TWO_ENDS * jnp.tanh(four[0]))
        return jnp.ones_like(middle), jnp.ones_like(middle), gain
    return jnp.ones_like(middle), jnp.ones_like(middle), jnp.ones_like(middle)


def end_leakage(frequency: Any, width: Any) -> Any:
    """What the ends of a record behind a high-pass filter leak to frequencies near zero.

    Over the density of white noise beyond the filter, times the samples: the integral of
    |H|^2/sin^2(pi f) over all frequencies, by `_ordinates.leakage` at w = 0.
    """
    return 2 * width / (jnp.pi * frequency * jnp.sin(jnp.pi * width))
