"""Whether something repeats of which no harmonic stands out: all of them together may.

A pulse of one sample in a hundred has fifty harmonics alike. What they hold together is looked for
at every frequency that they may be multiples of.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import uniform_filter1d
from scipy.stats import gamma

# Harmonics that are added up: as many as a band of fundamentals has, doubled from band to band.
_FEWEST, _MOST = 8, 64
# Periods in a record.
_OFTEN = 100
# One harmonic counts for as much at most, in units of what noise has on average: a line is no comb.
_TALLEST = 8.0
# Distances of harmonics over which a spectrum is even.
_NEAR = 6
_NO_CHANCE = -600.0


class Comb(NamedTuple):
    """A fundamental [cycles per sample], and the log of the chance of as much anywhere."""

    frequency: float
    log_p: float


def strongest_comb(
    white: Float[np.ndarray, " samples"],
    seen: Callable[[Float[np.ndarray, " _"]], Bool[np.ndarray, " _"]] = np.isfinite,
) -> Comb | None:
    """The harmonics that hold most together of a white record; None of a short one.

    Only frequencies that are `seen` count [cycles per sample]: beyond a steep edge, and at its
    zeros, which may be as evenly spaced as harmonics, there is what the ends of the record leak.
    """
    # Twice as fine as ordinates are, so that none falls between two of them.
    samples = white.size
    power = np.abs(np.fft.rfft(white, 2 * samples)) ** 2 / (samples * np.var(white))
    unseen = ~seen(np.arange(samples + 1) / (2 * samples))
    power = np.minimum(power, _TALLEST)
    found, places, harmonics = [], 0, _FEWEST
    while harmonics <= _MOST and samples > 4 * _OFTEN * harmonics:
        # The last harmonic moves by one place from one fundamental to the next.
        lowest = 2 * _OFTEN * harmonics if harmonics == _MOST else samples // 2
        each = np.arange(lowest + 1, samples + 1)
        total = np.zeros(each.size)
        # What is uneven over some harmonics is no comb.
        around = uniform_filter1d(power, _NEAR * lowest // harmonics)
        even = (power / np.maximum(around, 1.0)).astype(np.float32)
        even[unseen] = 1.0
        for multiple in range(1, harmonics + 1):
            total += even[(multiple * each + harmonics // 2) // harmonics]
        strongest = int(np.argmax(total))
        frequency = float(each[strongest]) / (2 * samples * harmonics)
        log_p = float(gamma.logsf(total[strongest], harmonics))
        found.append(Comb(frequency, max(log_p, _NO_CHANCE)))
        places += each.size
        harmonics *= 2
    if not found:
        return None
    best = min(found, key=lambda comb: comb.log_p)
    return best._replace(log_p=min(best.log_p + float(np.log(places)), 0.0))
