"""A record made white, so that what is left shows what no spectrum can.

The level is what the model expects, with the effects found so far, times a smoothed, robust ratio
of the data to it, so that a record is white after it whatever its noise, except where something is
narrow or does not last.
"""

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import dct, idct

from ._ordinates import Ordinates

# The lowest modes hold ramps and what a few degrees of freedom say of drift.
_DROPPED = 6
_BINS_PER_DECADE = 20
_FEWEST = 64
# Distance from the Nyquist frequency below which bins are finer [cycles per sample].
_NEAR_NYQUIST = 0.05
# The median of a chi-square with one degree of freedom over its mean.
_MEDIAN = 0.45494
# The relative standard deviation of a median of n of them, times sqrt(n).
_SCATTER = 2.33
_CLEAR = 5.0
#: Above such a share of the modes, where a filter may leave nothing, what is off by more than that
#: little would be amplified: they weigh no more than there.
HEARD = 0.9
#: Samples of a kernel that is long enough for what whitening does in time.
KERNEL = 4096
#: So many of the first and of the last samples of a stretch may hold what its ends leak.
END = 32


def level(
    spectrum: Ordinates, mean: Float[np.ndarray, " ordinates"]
) -> Float[np.ndarray, " ordinates"]:
    """Expected ordinates [u^2], smooth and deaf to lines, from a model's `mean` of them."""
    ratio = spectrum.amplitude**2 / mean
    order = np.log10(spectrum.frequency * 2 * spectrum.longest)
    index = np.floor(order * _BINS_PER_DECADE)
    # Toward the Nyquist frequency as finely in the distance to it: a digital filter has a zero.
    distance = np.maximum(0.5 - spectrum.frequency, 0.5 / spectrum.longest)
    index -= np.floor(np.minimum(np.log10(distance / _NEAR_NYQUIST), 0.0) * _BINS_PER_DECADE)
    starts = np.flatnonzero(np.diff(index, prepend=index[0] - 1))
    stops = np.append(starts[1:], index.size)
    at, values = [], []
    for start, stop in zip(starts, stops, strict=True):
        if stop - start >= _FEWEST:
            at.append(order[(start + stop) // 2])
            found = np.log(np.median(ratio[start:stop]) / _MEDIAN)
            # What the median's own scatter explains is no reason to bend the level.
            clear = abs(found) > _CLEAR * _SCATTER / np.sqrt(stop - start)
            values.append(found if clear else 0.0)
    if not at:
        return mean
    return mean * np.exp(np.interp(order, at, values))


def whitened(
    piece: Float[np.ndarray, " samples"],
    spectrum: Ordinates,
    expected: Float[np.ndarray, " ordinates"],
    notches: tuple[float, ...] = (),
    share: float = 1.0,
) -> Float[np.ndarray, " samples"]:
    """One stretch with unit variance at all frequencies; zero at `notches` [cycles per sample].

    Above a `share` of the modes, where noise is weakest, they are not amplified more than there.
    """
    gain = np.sqrt(precision(piece.size, spectrum, expected, share))
    for notch in notches:
        gain[np.abs(mode_frequency(piece.size) - notch) < 2.5 / piece.size] = 0.0
    return shaped(piece, gain)


def mode_frequency(samples: int) -> Float[np.ndarray, " samples"]:
    """Of each mode of a stretch [cycles per sample]."""
    return np.arange(samples) / (2 * samples)


def precision(
    samples: int,
    spectrum: Ordinates,
    expected: Float[np.ndarray, " ordinates"],
    share: float = 1.0,
) -> Float[np.ndarray, " samples"]:
    """One over the variance of each mode of a stretch [1/u^2], zero where none is known.

    Above a `share` of the modes, where noise is weakest, it is no more than there.
    """
    frequency = mode_frequency(samples)
    # An ordinate is 2 c^2.
    found = 2 / np.interp(frequency, spectrum.frequency, expected)
    found[:_DROPPED] = 0.0
    found[~spectrum.clean(frequency)] = 0.0
    return np.minimum(found, np.quantile(found, share)) if share < 1 else found


def kernel_density(
    spectrum: Ordinates, expected: Float[np.ndarray, " ordinates"]
) -> Float[np.ndarray, " frequencies"]:
    """Density [u^2], of white noise its variance, at the frequencies of a kernel of `KERNEL`."""
    frequency = np.arange(KERNEL // 2 + 1) / KERNEL
    # An ordinate is 2 c^2.
    return np.interp(frequency, spectrum.frequency, expected / 2)


def shaped(
    piece: Float[np.ndarray, " samples"], gain: Float[np.ndarray, " samples"]
) -> Float[np.ndarray, " samples"]:
    """One stretch with each of its modes times its `gain`."""
    coefficients = np.asarray(dct(piece - piece.mean(), norm="ortho"))
    return np.asarray(idct(coefficients * gain, norm="ortho"))


def without_ends(white: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    """Other samples in place of the first and the last.

    Where a filter leaves nothing, what the two ends of the record leak there becomes a knock at
    either end when it is made white. A record of hardly more than its ends stays as it is.
    """
    if white.size < 4 * END:
        return white
    white = white.copy()
    white[:END], white[-END:] = white[END : 2 * END], white[-2 * END : -END]
    return white


def without_bands(
    white: Float[np.ndarray, " samples"], bands: list[tuple[float, float]]
) -> Float[np.ndarray, " samples"]:
    """A white record with nothing in some bands, given by middles and half-widths."""
    spectrum = np.fft.rfft(white)
    spectrum[within(np.fft.rfftfreq(white.size), bands)] = 0.0
    return np.fft.irfft(spectrum, white.size)


def within(
    frequency: Float[np.ndarray, " frequencies"],
    bands: list[tuple[float, float]],
    beside: float = 0.0,
) -> Bool[np.ndarray, " frequencies"]:
    """Which are in one of the bands, or as near to one as `beside`."""
    inside = np.zeros(frequency.size, bool)
    for middle, half_width in bands:
        inside |= np.abs(frequency - middle) < half_width + beside
    return inside
