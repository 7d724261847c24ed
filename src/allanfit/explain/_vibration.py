"""Vibration that comes and goes: noise of a band of its own, in loud times.

White noise that is louder at times has a place beside a spectrum that lasts; vibration has a
spectrum of its own. For the analysis alone loud times are filtered until they have the spectrum of
the quiet ones. What is slow passes, with the mean that vibration may have shifted.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import uniform_filter1d
from scipy.signal import oaconvolve

from ._changing import TILE, loud_and_quiet, quiet_spectrum, reshaped_at_times, shares, tiles
from ._intervals import runs, widened
from ._modulation import Modulation
from ._ordinates import amplitudes
from ._refit import rebin
from ._state import Investigation

# The lowest frequencies of a tile, which pass; of vibration hardly a part may be there, beside a
# shift of the mean, which has the very lowest.
_SLOW, _SHIFT, _SLOW_PART = 5, 2, 0.25
# And it fills as many of a tile's frequencies: fewer are a line that comes and goes.
_BROAD = 12
# Neighbours whose excess is averaged, and standard deviations from which on it is one.
_TOGETHER, _CLEAR = 5, 3.0


class Vibration(NamedTuple):
    """What loud times have that the quiet ones have not."""

    #: When it is there.
    times: Modulation
    #: Its variance [u^2], its middle frequency [cycles per sample] and its width in e-folds.
    variance: float
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
    """Vibration in loud times, and what filters it out: its gain at a tile's frequencies.

    `expected` are the ordinates that `white` was made white with. None where loud times are as
    loud by white noise, or by more of what there is, or by a line, as well; and where there is no
    telling what else is slow.
    """
    loud = _sharper(changing.loud, changing.window, white)
    for start, stop in runs(loud):
        # Too brief to show a spectrum: a knock, perhaps.
        loud[start:stop] = stop - start >= 2 * TILE
    if not loud.any():
        return None
    powers, share = tiles(white), shares(loud)
    # An ordinate is twice a squared amplitude.
    at = np.arange(powers.shape[1]) / TILE
    density = np.interp(at, state.left.frequency, expected) / 2
    if any(
        reshaped_at_times(powers, share, each) is None for each in (density, np.ones_like(density))
    ):
        return None
    there, quiet = loud_and_quiet(powers, share)
    usual = quiet_spectrum(quiet)
    excess = there.mean(axis=0) / usual - 1
    slow = excess[_SHIFT:_SLOW].mean()
    excess = uniform_filter1d(excess, _TOGETHER)
    error = np.sqrt((1 / len(there) + 1 / len(quiet)) / _TOGETHER)
    excess[excess < _CLEAR * error] = 0.0
    breadth = excess.sum() ** 2 / max(np.sum(excess**2), 1e-300)
    if breadth < _BROAD or slow > _SLOW_PART * excess.mean():
        return None
    excess[:_SLOW] = 0.0
    power = excess * usual * density
    middle = float(power @ at / power.sum())
    width = float(np.sqrt(power @ (at - middle) ** 2 / power.sum())) / middle
    times = changing._replace(loud=loud)
    found = Vibration(times, float(power.mean()), middle, width, state.values)
    return found, 1 / np.sqrt(1 + excess)


def take_out(
    state: Investigation, found: Vibration, gain: Float[np.ndarray, " frequencies"]
) -> None:
    """Filter the loud times of the values."""
    taps = np.fft.fftshift(np.fft.irfft(gain)) * np.hanning(TILE + 1)[:TILE]
    taps = np.append(taps / taps.sum(), 0.0)
    state.vibration = found
    loud, values = state.flags(found.times.loud), state.values.copy()
    for start, stop in state.long_pieces:
        inside = values[start:stop]
        middle = inside.mean()
        filtered = oaconvolve(inside - middle, taps, mode="same") + middle
        inside[:] = np.where(loud[start:stop], filtered, inside)
    state.values = values
    # Of fast noise these times say no more than the others do.
    dilution = 1 / (1 - float(found.times.loud.mean()))
    parts = tuple(values[start:stop] for start, stop in state.pieces)
    state.spectrum = state.spectrum._replace(amplitude=amplitudes(parts), dilution=dilution)
    rebin(state)


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


def _sharper(
    loud: Bool[np.ndarray, " looked_at"], window: int, white: Float[np.ndarray, " looked_at"]
) -> Bool[np.ndarray, " looked_at"]:
    """Loud times that begin and end where their squares say so, a window away at most."""
    strong, weak = np.mean(white[loud] ** 2), np.mean(white[~loud] ** 2)
    # What each sample adds to the log-likelihood if it is loud.
    each = (white**2 * (1 / weak - 1 / strong) - np.log(strong / weak)) / 2
    total = np.concatenate([[0.0], np.cumsum(each)])
    sharp = np.zeros(loud.size, bool)
    for start, stop in runs(loud):
        half = max(min(window, (stop - start) // 2), 1)
        low, high = max(start - window, 0), stop - half
        first = start if start == 0 else low + int(np.argmin(total[low : start + half]))
        last = stop
        if stop < loud.size:
            last = high + int(np.argmax(total[high : min(stop + window, loud.size)]))
        sharp[first:last] = True
    return sharp
