"""Lines and narrow bands, found at full resolution.

Averages over bins in log f hide a line of ten times the amplitude that the single ordinate shows.
The periodogram of the whitened record is exponential with mean one at each frequency; windows of
1, 2, 4, ... ordinates are scanned for more than chance puts into them.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import gamma, norm

# A band may be as broad as this part of its frequency; broader, bins see it as well.
_BROAD = 0.04
_MOST = 24
# A broader window has to say more than a narrower one by this much, in log p.
_NARROWER = 3.0
# With fewer periods in the record a line is a course in time; see `courses`.
_SLOWEST = 100
# Steps to either side of a peak's middle where its strongest frequency is looked for.
_REFINED = 16
# A window this many deviations above its mean is looked at closely.
_MUCH = 2.0
# Sums in which they are looked for: a phase turns by a thousandth of a cycle within one.
_SUMS = 4096
# Cycles over a record, from half the sampling rate, at which a sinusoid and its image overlap, and
# what another frequency than that half has to gain.
_HALF, _TWICE = 2, 6.0
# Its frequency is no better known then [cycles a record].
_ROUGH = 0.1
# Independent places for each ordinate, of one line between ordinates and of windows of all widths;
# the chances that follow hold on simulated white noise.
_PADDED_TRIALS = 2.2
_WINDOW_TRIALS = 30.0


class Peak(NamedTuple):
    """An excess of power in a narrow band of the whitened record."""

    #: Its middle and half its width [cycles per sample].
    frequency: float
    half_width: float
    #: Mean over expected power, and the log of the chance of such an excess anywhere.
    ratio: float
    log_p: float


def evenly(
    white: Float[np.ndarray, " present"], time: Float[np.ndarray, " present"]
) -> Float[np.ndarray, " samples"]:
    """A white record with nothing where samples were lost: as strong in all, and as a sinusoid.

    `time` is that of each sample, in whole steps from zero.
    """
    even = np.zeros(int(time[-1]) + 1)
    even[time.astype(int)] = white * np.sqrt(even.size / white.size)
    return even


def scan(white: Float[np.ndarray, " samples"], p_value: float) -> list[Peak]:
    """Bands with more power than chance, of a family-wise `p_value`, strongest first."""
    samples = white.size
    # Twice the length: a line between two ordinates would lose up to 60 % of its power.
    spectrum = np.fft.rfft(white, 2 * samples)
    fine = (spectrum.real**2 + spectrum.imag**2) / samples
    del spectrum
    fine[: 2 * _SLOWEST] = 0.0
    # Half the sampling rate has one phase: as exponential as the others with the same chance.
    fine[-1] = -np.log(2) - norm.logsf(np.sqrt(fine[-1]))
    power = fine[::2].copy()
    trials = np.log(_places(np.arange(power.size, dtype=float), samples))
    peaks: list[Peak] = []
    taken = np.zeros(fine.size, bool)
    while len(peaks) < _MOST:
        left = np.where(taken, 0.0, fine), np.where(taken[::2], 1.0, power)
        found = _likeliest(*left, trials, samples)
        if found.log_p > np.log(p_value):
            break
        peaks.append(found)
        reach = max(2.5 * found.half_width, 3 / samples)
        low, high = 2 * samples * (found.frequency + np.array([-reach, reach]))
        taken[max(int(np.floor(low)) + 1, 0) : max(int(np.ceil(high)), 0)] = True
    return peaks


def _likeliest(
    fine: Float[np.ndarray, " padded"],
    power: Float[np.ndarray, " ordinates"],
    trials: Float[np.ndarray, " ordinates"],
    samples: int,
) -> Peak:
    """The band that chance makes least often, given the log of the `_places` of each ordinate."""
    top = int(np.argmax(fine - np.repeat(trials, 2)[: fine.size]))
    strongest, frequency = float(fine[top]), top / (2 * samples)
    log_p = line_log_chance(strongest, frequency, samples)
    best = Peak(frequency, 0.5 / samples, strongest, log_p)
    total = np.concatenate([[0.0], np.cumsum(power)])
    width = 2
    while width < min(_BROAD * power.size, power.size - 1 - _SLOWEST):
        # Half a window apart; a window's power is Gamma with its width for shape.
        step = width // 2
        start = np.arange(_SLOWEST, power.size - width - 1, step)
        inside = total[start + width] - total[start]
        # Broad for its frequency, a band is no line, and the level need not be flat within it.
        much = np.flatnonzero((inside > width + _MUCH * width**0.5) & (width < _BROAD * start))
        if much.size:
            start, inside = start[much], inside[much]
            chance = _log_bound(inside, width) + trials[start]
            at = int(np.argmin(chance))
            # Many widths are looked at, and the narrowest that says as much is best.
            log_p = _log_tail(float(inside[at]), width) + float(trials[start[at]])
            log_p += np.log(_WINDOW_TRIALS / step)
            if log_p < best.log_p - _NARROWER:
                middle = (start[at] + (width - 1) / 2) / samples
                ratio = float(inside[at] / width)
                best = Peak(float(middle), width / (2 * samples), ratio, log_p)
        width *= 2
    return best


def line_log_chance(power: float, frequency: float, samples: int) -> float:
    """Log of the chance of such a power of white noise at this frequency or the like elsewhere.

    The power is that of a periodogram, over its mean; frequencies in cycles per sample.
    """
    trials = _PADDED_TRIALS * _places(np.array([frequency * samples]), samples)[0]
    return min(0.0, float(np.log(trials) - power))


def _places(order: Float[np.ndarray, " orders"], samples: int) -> Float[np.ndarray, " orders"]:
    """Among how many ordinates one of some order shares the chance of a false alarm.

    Half of it belongs to all alike, and half to all octaves alike: machines and sensors have lines
    at any scale of frequency, and most ordinates are in the highest octaves.
    """
    every = samples // 2 + 1
    alike = np.maximum(order, _SLOWEST) * np.log(max(every / _SLOWEST, np.e))
    return 2 / (1 / every + 1 / alike)


def _log_bound(power: Float[np.ndarray, " windows"], width: int) -> Float[np.ndarray, " windows"]:
    """Chernoff's bound on the log of the chance of more power in so many ordinates."""
    power = np.maximum(power, width)
    return width - power + width * np.log(power / width)


def _log_tail(power: float, width: int) -> float:
    """Log of the chance of more power in that many ordinates; Chernoff's bound far out."""
    if power <= width:
        return 0.0
    bound = float(_log_bound(np.array([power]), width)[0])
    return bound if bound < -500 else float(gamma.logsf(power, width))


class Sine(NamedTuple):
    """A sinusoid by least squares."""

    frequency: float
    frequency_deviation: float
    #: What twice the log-likelihood gains by it.
    gain: float


def refine(white: Float[np.ndarray, " samples"], peak: Peak, level: float) -> Sine:
    """The best sinusoid within a peak of the whitened record [cycles per sample].

    `level` is the one-sided density of the record there, for a sampling interval of one [u^2].
    The deviation is the Cramer-Rao bound (Rife and Boorstyn 1974, IEEE Trans. IT 20:591).
    Exactly half the sampling rate is the frequency of what only alternates.
    """
    samples = white.size
    time = np.arange(samples) - (samples - 1) / 2
    # Beside the peak's own frequency phases turn so little that sums over short times will do.
    starts = np.arange(0, samples, max(1, samples // _SUMS))
    turned = np.add.reduceat(white * np.exp(-2j * np.pi * peak.frequency * time), starts)
    middle = np.add.reduceat(time, starts) / np.diff(starts, append=samples)
    away, step = 0.0, 0.25 / samples
    reach = max(4, int(np.ceil(min(peak.half_width / step, _REFINED))))
    for _ in range(6):
        at = away + step * np.arange(-reach, reach + 1)
        height = np.abs(np.exp(-2j * np.pi * at[:, None] * middle) @ turned)
        away, step, reach = float(at[int(np.argmax(height))]), step / 3, 4
    frequency = peak.frequency + away
    gain = 2 * np.abs(white @ np.exp(-2j * np.pi * frequency * time)) ** 2 / samples
    folded = frequency > 0.5 - _HALF / samples
    if folded:
        frequency, gain = _about_half(white)
    amplitude = float(np.sqrt(2 * gain / samples * level / 2))
    deviation = float(np.sqrt(12 * level / (amplitude**2 * samples**3)) / (2 * np.pi))
    return Sine(frequency, max(deviation, _ROUGH / samples * folded), float(gain))


def _about_half(white: Float[np.ndarray, " samples"]) -> tuple[float, float]:
    """Frequency and gain of a sinusoid that turns hardly once against half the sampling rate.

    There a sinusoid and its image are one, and which part of it shows depends on its phase.
    """
    samples = white.size
    turned = white * (1 - 2 * (np.arange(samples) % 2))
    starts = np.arange(0, samples, max(1, samples // _SUMS))
    counts = np.diff(starts, append=samples)
    middle = np.add.reduceat(np.arange(samples) + 0.5, starts) / counts
    root = np.sqrt(counts)
    sums = np.add.reduceat(turned, starts) / root
    alone = float(sums @ root) ** 2 / samples
    best, frequency = alone + _TWICE, 0.5
    for away in np.arange(1, 16 * _HALF) / (16 * samples):
        angle = 2 * np.pi * away * middle
        columns = np.linalg.qr(np.column_stack([np.cos(angle), np.sin(angle)]) * root[:, None])[0]
        gain = float(np.sum((columns.T @ sums) ** 2))
        if gain > best:
            best, frequency = gain, 0.5 - away
    return frequency, alone if frequency == 0.5 else best
