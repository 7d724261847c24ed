"""Frequencies at which a filter leaves less than what the ends of the record leak there."""

import numpy as np
from jaxtyping import Float

from .._intervals import runs
from .._refit import finer_edges
from .._state import Investigation
from ._in_bins import end_leakage, shaped
from ._narrow import narrow_noises
from ._ordinates import LEAKAGE_GRID, LEAST, leakage, less_bands, points
from ._search import Candidate
from ._structure import (
    HIGH_PASS,
    MEANS,
    SHAPE,
    WINDOWED,
    shape_of,
)

# Part of the noise below which the shape of a steep edge is not known.
_EDGE = 0.003
# Share of a density that may have leaked.
_LEAKED = 0.05
# So many times what the filter leaves and the ends leak is no leakage: the filter is another.
_REFUTED = 10.0


def leave_leakage(state: Investigation) -> None:
    """Leave out what only the ends of the record leak to, beyond a filter that has been found.

    What two ends leak is no noise of its own at each frequency: it would bend the filter.
    """
    kinds, theta = state.model.kinds, state.model.theta
    four, frequency = theta[SHAPE], state.spectrum.frequency

    def passed(at: Float[np.ndarray, " frequencies"]) -> Float[np.ndarray, " frequencies"]:
        white, behind, _ = shaped(kinds.shaping, four, points(at), state.data.samples)
        return 2 * np.exp(theta[1]) * np.asarray(white if kinds.floored else behind)

    # By the filter alone: where ordinates were left out before, no bins say what is there.
    samples, density = state.spectrum.longest, passed(frequency) + float(state.data.foreign)
    leaked = leakage(passed(LEAKAGE_GRID), frequency)
    unclean = leaked > _LEAKED * samples * density
    if kinds.shaping not in MEANS:
        # Of no other kind are the side lobes known, and of an edge each window makes its own.
        least = _EDGE if kinds.shaping == WINDOWED else LEAST / samples
        unclean |= density < least * density.max()
    seen = state.left.amplitude**2
    most = _REFUTED * np.maximum(density + leaked / samples, _EDGE * density.max())
    bands = [
        (frequency[a], frequency[b - 1])
        for a, b in runs(unclean)
        if seen[a:b].mean() < most[a:b].mean()
    ]
    state.spectrum = less_bands(state.spectrum, bands)
    finer_edges(state)


def take_bump(state: Investigation, bump: Candidate) -> None:
    """The structure with what has no name, without the ordinates that are no noise behind it."""
    more = bump.model.kinds.notches > state.model.kinds.notches
    state.unexplained, state.model = bump, bump.model
    if more:
        # Bins are wider than many a notch. And bands stood out of a level that was too low, but for
        # those that the model holds.
        narrow = narrow_noises(state.model, float(state.data.samples))
        state.peaks = [
            peak
            for peak in state.peaks
            if any(abs(peak.frequency - n.middle) < peak.half_width + n.width for n in narrow)
        ]
        finer_edges(state)
    if state.model.kinds.shaping != HIGH_PASS:
        return
    samples, frequency = state.data.samples, state.spectrum.frequency
    four = state.model.theta[SHAPE]
    gain = np.asarray(shaped(HIGH_PASS, four, points(frequency), samples)[2])
    leaked = float(end_leakage(*shape_of(HIGH_PASS, four, samples))) / samples
    clean = leaked < _LEAKED * gain
    if clean.any():
        # The gain rises: what the two ends leak lies below all that is clean.
        slow = (0.0, float(frequency[np.argmax(clean)]))
        state.spectrum = state.spectrum._replace(holes=(slow, *state.spectrum.holes))
        finer_edges(state)
