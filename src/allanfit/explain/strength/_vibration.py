"""Vibration that comes and goes: noise of a band of its own, in loud times.

White noise that is louder at times has a place beside a spectrum that lasts; vibration has a
spectrum of its own. For the analysis alone loud times are filtered until they have the spectrum of
the quiet ones. What is slow passes, with the mean that vibration may have shifted.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import uniform_filter1d
from scipy.signal import ShortTimeFFT, oaconvolve, savgol_filter
from scipy.signal.windows import hann

from .._intervals import runs, widened
from .._refit import rebin
from .._state import Investigation, between_even_ends
from ..spectrum._ordinates import amplitudes
from ._changing import (
    TILE,
    Powers,
    loud_and_quiet,
    quiet_spectrum,
    reshaped_at_times,
    shares,
    tiles,
)
from ._modulation import Modulation

# The lowest frequencies of a tile, which pass; of vibration hardly a part may be there, beside a
# shift of the mean, which has the very lowest.
_SLOW, _SHIFT, _SLOW_PART = 5, 2, 0.25
# Where vibration has slow power its peak is at so many times these frequencies, and what is
# slower than so many tiles passes.
_FAR, _PASSES = 4, 4
# And it fills as many of a tile's frequencies: fewer are a line that comes and goes.
_BROAD = 12
# Neighbours whose excess is smoothed, and standard deviations from which on it is one.
_TOGETHER, _CLEAR = 5, 3.0
# Beside an edge their mean is so many times what is there.
_EDGE = 1.2
# By as much the variance of a mean of neighbours is larger where a window makes them alike: with
# the squared correlations 4/9 and 1/36 of a Hann window, (5 + 8 * 4/9 + 6/36) / 5.
_ALIKE = 1.75
# Of the noise, what may be left at the quietest, and what may have been taken too much; and bands
# in which evenness is told.
_LEAST, _MOST, _BANDS, _BAND = 0.95, 3.0, 9, 14
# Fits with weights, and the part of the power that is noise at least.
_FITS, _CUT = 8, 1e-3

Samples = Float[np.ndarray, " samples"]


class Vibration(NamedTuple):
    """What loud times have that the quiet ones have not."""

    #: When it is there.
    times: Modulation
    #: Its variance at loud times [u^2], how many times that it is at each sample, its middle
    #: frequency [cycles per sample] and its width in e-folds.
    variance: float
    course: Float[np.ndarray, " looked_at"]
    middle: float
    width: float
    #: The values with it [u].
    recorded: Float[np.ndarray, " samples"]


def vibration(
    state: Investigation,
    white: Float[np.ndarray, " looked_at"],
    expected: Float[np.ndarray, " ordinates"],
    changing: Modulation,
) -> tuple[Vibration, Float[np.ndarray, " frequencies"]] | None:
    """Vibration in loud times, and its power over that of the quiet times, at a tile's frequencies.

    `expected` are the ordinates that `white` was made white with. None where loud times are as
    loud by white noise, or by more of what there is, or by a line, as well; and where there is no
    telling what else is slow.
    """
    loud = changing.sharp().loud.copy()
    for start, stop in runs(loud):
        # Too brief to show a spectrum: a knock, perhaps.
        loud[start:stop] = stop - start >= 2 * TILE
    if not loud.any():
        return None
    powers, share = tiles(white), shares(loud)
    # An ordinate is twice a squared amplitude.
    at = np.arange(powers.shape[1]) / TILE
    density = np.interp(at, state.left.frequency, expected) / 2
    # More of what there is, behind a filter that is not known yet as well.
    more = quiet_spectrum(*loud_and_quiet(powers, share)) * density
    if (
        reshaped_at_times(powers, share, density, passed=more) is None
        or reshaped_at_times(powers, share, np.ones_like(density)) is None
    ):
        return None
    # Beside strong vibration quiet frequencies would have what it leaks.
    there, quiet = loud_and_quiet(tiles(white, hann(TILE, sym=False)), share)
    usual = quiet_spectrum(there, quiet)
    if changing.strength is None:
        course, excess = loud.astype(float), there.mean(axis=0) / usual - 1
    else:
        course = _course(changing)
        usual, excess = _beside(powers, shares(course))
        least = _least(usual * density, excess)
        usual = usual * (1 + least * excess)
        excess, course = excess / (1 + least * excess), np.maximum(course - least, 0.0)
    alike = _ALIKE if changing.strength is None else 1.0
    error = np.sqrt((1 / len(there) + 1 / len(quiet)) * alike)
    slow = float(excess[_SHIFT:_SLOW].mean())
    skirt = slow > _CLEAR * error / np.sqrt(_SLOW - _SHIFT)
    mean = uniform_filter1d(excess, _TOGETHER)
    clear = mean > _CLEAR * error / np.sqrt(_TOGETHER)
    # A narrow peak keeps its height; beside an edge too much is better than too little.
    smooth = np.expm1(np.asarray(savgol_filter(np.log1p(excess), _TOGETHER, 2)))
    excess = np.where(clear, np.where(mean > _EDGE * smooth, mean, np.maximum(smooth, 0.0)), 0.0)
    breadth = excess.sum() ** 2 / max(np.sum(excess**2), 1e-300)
    if breadth < _BROAD:
        return None
    # What else is slow is no vibration.
    power, at = (excess * usual * density)[_SLOW:], at[_SLOW:]
    if skirt and changing.strength is None and np.argmax(power) > _FAR * _SLOW:
        # As of a mount that is pushed, whose vibration has power down to where it stands.
        excess[:_SLOW] = slow
    elif slow <= _SLOW_PART * excess.mean():
        excess[:_SLOW] = 0.0
    else:
        return None
    middle = float(power @ at / power.sum())
    width = float(np.sqrt(power @ (at - middle) ** 2 / power.sum())) / middle
    times = changing._replace(loud=loud)
    if changing.strength is None:
        # White noise that was made so by all of it is louder by less.
        quietest = float(np.sum((usual * density)[_SLOW:]))
        times = times.louder_by(float(np.sqrt(1 + power.sum() / quietest)))
    found = Vibration(times, float(power.sum() / excess.size), course, middle, width, state.values)
    return found, excess


def _course(changing: Modulation) -> Float[np.ndarray, " looked_at"]:
    """How much vibration there is at each sample: none at the quietest, one on average if loud."""
    power = changing.deviation() ** 2
    return (power - power.min()) / (power[changing.loud].mean() - power.min())


def _beside(
    powers: Powers, course: Float[np.ndarray, " tiles"]
) -> tuple[Float[np.ndarray, " frequencies"], Float[np.ndarray, " frequencies"]]:
    """Noise without vibration, and vibration of a course of one over it.

    Powers are exponential variates of a mean that rises with `course` in a straight line, fitted by
    least squares with the weights that it says.
    """
    usual, excess = powers.mean(axis=0), np.zeros(powers.shape[1])
    for _ in range(_FITS):
        weight = 1 / (1 + course[:, None] * excess) ** 2
        ones, once, twice = (course**k @ weight for k in range(3))
        mean, slope = np.sum(weight * powers, axis=0), course @ (weight * powers)
        spread = ones * twice - once**2
        usual = np.maximum((twice * mean - once * slope) / spread, _CUT * powers.mean(axis=0))
        excess = np.maximum((ones * slope - once * mean) / spread / usual, 0.0)
    return usual, excess


def _least(
    density: Float[np.ndarray, " frequencies"], excess: Float[np.ndarray, " frequencies"]
) -> float:
    """How much vibration is left at the quietest, or how much less there is than none.

    Powers do not tell. As much as makes the `density` beside it the most even.
    """
    tried = np.linspace(-_LEAST, _MOST, 401)[:, None] / max(excess.max(), 1e-300)
    # Of broad bands, beyond chance.
    beside = (
        (density * (1 + tried * excess))[:, -_BANDS * _BAND :]
        .reshape(401, _BANDS, _BAND)
        .mean(axis=2)
    )
    rough = np.sum(np.diff(np.log(beside), axis=1) ** 2, axis=1)
    return float(tried[np.argmin(rough), 0])


def take_out(
    state: Investigation, found: Vibration, excess: Float[np.ndarray, " frequencies"]
) -> None:
    """Filter the values down to the quiet spectrum, by as much as they vibrate."""
    state.vibration = found
    values = state.values.copy()
    whole = np.zeros(values.size)
    whole[state.looked_at] = found.course
    for start, stop in state.long_pieces:
        inside = values[start:stop]
        middle = inside.mean()
        filter_out = _filtered_while if found.times.strength is None else _filtered
        inside[:] = middle + filter_out(inside - middle, whole[start:stop], excess)
    state.values = values
    if found.times.strength is None:
        # Of fast noise these times say no more than the others do.
        dilution = 1 / (1 - float(found.times.loud.mean()))
    else:
        # Where it vibrates, noise beside it is known as little as that is of all.
        power = float(np.sum(excess**2) / np.sum(excess))
        dilution = 1 / float(np.mean(1 / (1 + power * found.course) ** 2))
    parts = between_even_ends(values, state.pieces, np.exp(state.model.theta[:2]))
    state.spectrum = state.spectrum._replace(amplitude=amplitudes(parts), dilution=dilution)
    rebin(state)


def _filtered_while(
    values: Samples, course: Samples, excess: Float[np.ndarray, " frequencies"]
) -> Samples:
    """Where the course is one, and not where it is none; what is slower than some tiles passes."""
    taps = np.fft.fftshift(np.fft.irfft(1 / np.sqrt(1 + excess))) * np.hanning(TILE + 1)[:TILE]
    taps = np.append(taps * np.sqrt(1 / (1 + excess[0])) / taps.sum(), 0.0)
    slow = uniform_filter1d(values, _PASSES * TILE) if excess[0] > 0 else 0.0
    filtered = slow + oaconvolve(values - slow, taps, mode="same")
    return np.where(course > 0, filtered, values)


def _filtered(
    values: Samples, course: Samples, excess: Float[np.ndarray, " frequencies"]
) -> Samples:
    """By a gain that follows the course, in overlapping tiles."""
    transform = ShortTimeFFT(np.sqrt(hann(TILE, sym=False)), TILE // 2, 1.0)
    spectra = transform.stft(values)
    strength = np.interp(transform.t(values.size), np.arange(values.size), course)
    gain = 1 / np.sqrt(1 + excess[:, None] * strength)
    return np.asarray(transform.istft(spectra * gain, k1=values.size), float)


def away_from_edges(
    state: Investigation, flags: Bool[np.ndarray, " looked_at"]
) -> Bool[np.ndarray, " looked_at"]:
    """Those of brief times that are not where vibration begins or ends, or shifts the mean."""
    if state.vibration is None:
        return flags
    edges = np.diff(state.flags(state.vibration.times.loud), prepend=False)
    near = widened(edges, TILE)[state.looked_at]
    apart = np.zeros(flags.size, bool)
    for start, stop in runs(flags):
        apart[start:stop] = not near[start:stop].any()
    return apart
