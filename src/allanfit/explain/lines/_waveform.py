"""A mean that repeats: the pulse of a clock, a radio that sends, a logger that writes.

Its harmonics are lines, many more than are worth a name each. All of them show at once where a
white record is folded at their period (epoch folding; Leahy et al., ApJ 266, 160, 1983).
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.stats import chi2

from ..values._held_out import Gain, of_phases

# Phases that a period is divided into where it has as many samples: to find it, and to take away
# what repeats with its edges.
_PHASES, _FINE = 64, 1024
# A phase's mean is taken of so many samples at least.
_FEWEST = 100


class Waveform(NamedTuple):
    """A mean that repeats every so many samples, and the log chance of as much."""

    period: float
    log_p: float

    def held_out(self, white: Float[np.ndarray, " samples"]) -> Gain:
        """What it gains on samples that its means are not taken from."""
        return of_phases(white, _phase(white.size, 1 / self.period, _PHASES))

    def taken_from(self, white: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
        """The record without it, and without its edges."""
        phase = _phase(white.size, 1 / self.period, min(_FINE, white.size // _FEWEST))
        means, _ = _folded(white, phase)
        return white - means[phase]


def waveform(white: Float[np.ndarray, " samples"], frequency: float) -> Waveform:
    """The mean of a white record that repeats at a frequency [cycles per sample], or near it.

    A frequency found from a line is off by a part of 1/T, and each phase must stay with itself
    from the beginning to the end.
    """
    tried = frequency + np.arange(-2 * _PHASES, 2 * _PHASES + 1) / (2 * _PHASES * white.size)

    def power(one: float) -> tuple[float, int]:
        means, counts = _folded(white, _phase(white.size, one, _PHASES))
        return float(counts @ means**2), means.size

    strongest = max(tried, key=power)
    gain, phases = power(strongest)
    log_p = chi2.logsf(gain / np.var(white), phases) + np.log(tried.size)
    return Waveform(1 / strongest, float(min(0.0, log_p)))


def _phase(samples: int, frequency: float, most: int) -> Int[np.ndarray, " samples"]:
    """Which part of its period each sample is in, of `most` at most."""
    parts = int(np.clip(1 / frequency, 2, most))
    return (np.arange(samples) * frequency % 1 * parts).astype(int)


def _folded(
    white: Float[np.ndarray, " samples"], phase: Int[np.ndarray, " samples"]
) -> tuple[Float[np.ndarray, " phases"], Int[np.ndarray, " phases"]]:
    """The mean of each phase, and of how many samples."""
    counts = np.maximum(np.bincount(phase), 1)
    return np.bincount(phase, white) / counts, counts
