"""Whether a spectrum falls toward the Nyquist frequency: `nyquist_score`."""

import numpy as np
from jaxtyping import Bool, Float
from numpy.lib.stride_tricks import sliding_window_view
from scipy.special import gammaincc

from ._estimate import solve, target
from ._fit import Fit
from ._goodness import score

# Bins to either side of one that are looked at: a line or a narrow resonance fills fewer.
_BESIDE = 4
# A bin higher by chance than its neighbours is met in one of 10,000 spectra.
_CHANCE = 1e-6


def nyquist_score(fit: Fit) -> float:
    """Standard deviations by which Q^2 is above zero, whatever lines there are; of one sensor.

    Negative where the spectrum falls short of the other terms as it nears the Nyquist frequency.
    It also falls short of a level that a line has lifted: without the bins that stand above their
    neighbours, the others are fitted again, and the score is the higher one.
    """
    plain = float(fit.estimate.quantization_score)
    found = fit.estimate.statistics
    shape = np.asarray(fit.design.ordinates, float) / 2
    lines = _above_neighbours(np.asarray(found.density, float), shape)
    if plain >= 0 or not lines.any():
        return plain
    data = target(found, fit.design)
    # Of no weight, as the bins that fill it up.
    data = data._replace(shape=data.shape.at[np.flatnonzero(lines)].set(0.0))
    return max(plain, float(score(solve(data).power, data.density, data.expected, data.shape)[0]))


def _above_neighbours(
    density: Float[np.ndarray, " bins"], shape: Float[np.ndarray, " bins"]
) -> Bool[np.ndarray, " bins"]:
    """Bins that are higher than chance allows beside the median of those around them."""
    above = np.zeros(density.shape, bool)
    while True:
        # A strong line has a foot, which stands out when its top is left out.
        left = np.flatnonzero(~above)
        # With its ends repeated, a spectrum that falls throughout is its own median.
        around = sliding_window_view(np.pad(density[left], _BESIDE, mode="edge"), 2 * _BESIDE + 1)
        ratio = density[left] / np.median(around, axis=1)
        more = gammaincc(shape[left], shape[left] * ratio) < _CHANCE
        if not more.any():
            return above
        above[left[more]] = True
