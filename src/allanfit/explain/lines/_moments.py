"""Power, mean frequency and width of a line that wanders, by the moments of its band.

A line that is at one frequency at a time has the spectrum of where it was, which is no normal
distribution unless it was everywhere often. Its power is there all the same, and its moments are
those of its course (Woodward's theorem), while a fit of a normal peak is led by the shape.
"""

import numpy as np

from .._state import Investigation
from ..spectrum._narrow import Narrow, beside, density_of
from ..spectrum._ordinates import ordinates
from ._tracked import Moments

# Standard deviations of its frequency, as the fit has it, within which it was all the time.
_REACH = 6.0


def moments(state: Investigation, line: Narrow) -> Moments | None:
    """Moments of a line in the longest stretch; None where they drown, or the band is cut."""
    low, high = line.middle - _REACH * line.width, line.middle + _REACH * line.width
    if low <= 0 or high >= 0.5:
        return None
    spectrum = ordinates((state.calm[slice(*state.longest)],), state.sampling)
    inside = slice(*np.searchsorted(spectrum.frequency, [low, high]))
    frequency = spectrum.frequency[inside]
    rest = beside(state, [line], frequency)
    excess = spectrum.amplitude[inside] ** 2 - rest
    # Of a steady line beside normal noise: (l + n)^2 varies by 2 n^4 + 4 l^2 n^2.
    variance = 2 * rest**2 + 4 * rest * np.maximum(excess, 0.0)
    total = float(excess.sum())
    if total <= 0:
        return None

    def deviation(weight) -> float:
        return float(np.sqrt(np.sum(weight**2 * variance)))

    mean = float(frequency @ excess) / total
    away = (frequency - mean) ** 2
    square = float(away @ excess) / total
    if square <= 0:
        return None
    # What a squared amplitude of one puts there, behind a filter as well.
    unit = float(density_of(state, [line], frequency).sum() / np.exp(line.three[0]))
    width = np.sqrt(square)
    return Moments(
        (total / unit, deviation(np.ones(frequency.size)) / unit),
        (mean, deviation(frequency - mean) / total),
        (width, deviation(away - square) / total / (2 * width)),
    )
