"""Power, mean frequency and width of a line that wanders, by the moments of its band.

A line that is at one frequency at a time has the spectrum of where it was, which is no normal
distribution unless it was everywhere often. Its power is there all the same, and its moments are
those of its course (Woodward's theorem), while a fit of a normal peak is led by the shape.
"""

import numpy as np
from jaxtyping import Float

from .._state import Investigation
from ..spectrum._narrow import Narrow, beside, density_of
from ._tracked import Followed, Moments

# Standard deviations of its frequency, as the fit has it, within which it was all the time.
_REACH = 6.0


def moments(state: Investigation, line: Narrow) -> Moments | None:
    """Moments of a line in the longest stretch; None where they drown, or the band is cut."""
    low, high = line.middle - _REACH * line.width, line.middle + _REACH * line.width
    if low <= 0 or high >= 0.5:
        return None
    spectrum = state.ordinates_of(state.calm[slice(*state.longest)])
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


def in_the_long_run(
    size: Float[np.ndarray, " draws"],
    mean: Float[np.ndarray, " draws"],
    width: Float[np.ndarray, " draws"],
    followed: Followed,
    seed: int,
) -> tuple[Float[np.ndarray, " draws"], ...]:
    """Draws of a line's amplitude, mean frequency and width, as it wanders in the long run.

    By its moments, where these know better than a fit of its peak. A record in which the frequency
    seldom changes tells as much of where it will be as so many independent values do: of a process
    that forgets as exp(-t/T) the mean over a time L has the variance 2 T/L of one value, and the
    mean square that of L/T values.
    """
    rng = np.random.default_rng(seed)
    noise, lasts = rng.standard_normal((5, mean.size)), followed.lasts
    if followed.moments is not None:
        square, middle, spread = followed.moments
        # A fit is led by the shape: moments are better even where noise moves them as far as the
        # few turns do.
        of_mean, of_width = np.array([np.sqrt(2 * lasts), np.sqrt(lasts / 2)]) * np.median(width)
        if square[1] < 2 * np.std(np.log(size)) * square[0]:
            size = np.sqrt(np.maximum(square[0] + square[1] * noise[0], 0.0))
        if middle[1] < max(np.std(mean), of_mean):
            mean = middle[0] + middle[1] * noise[1]
        if spread[1] < max(np.std(width), of_width):
            width = np.maximum(spread[0] + spread[1] * noise[2], 0.0)
    wider = width * np.exp(np.sqrt(lasts / 2) * noise[3])
    return size, mean + width * np.sqrt(2 * lasts) * noise[4], wider
