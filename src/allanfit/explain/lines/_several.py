"""Several sinusoids near to one another, as mains and its harmonics are that fold to one place."""

import numpy as np
from jaxtyping import Float

from ._lines import Peak, Sine, evenly, line_log_chance, refine, scan
from ._sidebands import FEWEST, symmetric

# More lines in a band are those of one that comes and goes, or of none; nearer ones [ordinates] are
# one line whose phase or strength changes.
_MOST, _APART = 6, 2.5
# Lines further apart [ordinates] stand out one by one.
_WIDEST = 400.0
# Steps toward the frequencies of all of them together.
_STEPS = 3
# Samples at a time, for the sake of memory.
_CHUNK = 1 << 16
# Widths and heights of one noise band in their stead, over all that is tried.
_WIDTHS, _HEIGHTS = 10, 40
# By so much in log-likelihood sinusoids have to be likelier than a band of noise, whose middle,
# width and height cost so much: one band never tells them well.
_LIKELIER, _BAND_COST = 3.0, 4.5


def several(
    white: Float[np.ndarray, " present"],
    weight: Float[np.ndarray, " present"],
    time: Float[np.ndarray, " present"],
    peak: Peak,
    loose: float,
) -> list[Sine]:
    """The sinusoids that empty a band of the whitened record, of two or more; none if they do not.

    `time` is that of each sample, in whole steps from zero, and `weight` what a sinusoid is times
    there. What is left is scanned at a family-wise p-value of `loose`. A band of noise leaves as
    little to many sinusoids: they have to be likelier than the best such band, each less what its
    three numbers cost. Sidebands of one line that swings are not several either.
    """
    samples = int(time[-1]) + 1
    even = evenly(white, time)
    reach = max(8.0, 2.5 * peak.half_width * samples) / samples
    if reach * samples > _WIDEST:
        return []
    found, rest = np.zeros(0), even
    while True:
        strongest = _strongest(rest, peak.frequency, reach)
        found = np.append(found, strongest.frequency)
        if _too_near(found, samples):
            return []
        found, left_over, gains = _together(white, weight, time, found)
        rest = evenly(left_over, time)
        left = scan(rest, loose)
        if not any(np.abs(found - each.frequency).min() < reach for each in left):
            break
        if found.size == _MOST:
            return []
    chances = [
        line_log_chance(gain / 2, line, samples) for gain, line in zip(gains, found, strict=True)
    ]
    if found.size == 1 or _too_near(found, samples) or max(chances) > np.log(loose):
        return []
    order = np.argsort(found)
    strengths = list(np.sqrt(gains[order]))
    if found.size >= FEWEST and symmetric(list(found[order]), strengths, samples):
        return []
    # Of each its frequency, amplitude and phase are known the better the stronger it is.
    cost = 1.5 * np.log(gains / 2) + np.log(2 * reach * samples)
    noise = _band(even, peak.frequency, 2 * reach) - _BAND_COST
    if np.sum(gains / 2 - cost) < noise + _LIKELIER:
        return []
    deviations = np.sqrt(12 / gains) / (2 * np.pi * samples)
    return [Sine(*map(float, each)) for each in zip(found, deviations, gains, strict=True)]


def _too_near(lines: Float[np.ndarray, " lines"], samples: int) -> bool:
    return bool(np.diff(np.sort(lines)).min(initial=np.inf) < _APART / samples)


def _strongest(even: Float[np.ndarray, " samples"], middle: float, reach: float) -> Sine:
    """The strongest sinusoid within reach of a frequency."""
    fine = np.abs(np.fft.rfft(even, 2 * even.size)) ** 2
    place = np.abs(np.arange(fine.size) / (2 * even.size) - middle)
    top = int(np.argmax(np.where(place < reach, fine, 0.0)))
    return refine(even, Peak(top / (2 * even.size), 0.5 / even.size, 1.0, 0.0), 1.0)


def _together(white, weight, time, frequency: Float[np.ndarray, " lines"]):
    """Frequencies of all lines by least squares, what they leave, and what each gains."""
    centre, scale = (time[0] + time[-1]) / 2, (time[-1] - time[0]) / 2
    lines = frequency.size

    def columns(part: slice) -> Float[np.ndarray, "part columns"]:
        angle = 2 * np.pi * frequency * (time[part, None] - centre)
        both = weight[part, None] * np.hstack([np.cos(angle), np.sin(angle)])
        late = (time[part, None] - centre) / scale
        return np.hstack([both, late * both])

    parts = [slice(begin, begin + _CHUNK) for begin in range(0, white.size, _CHUNK)]
    for step in range(_STEPS + 1):
        sums, products = np.zeros((4 * lines, 4 * lines)), np.zeros(4 * lines)
        for part in parts:
            each = columns(part)
            sums, products = sums + each.T @ each, products + each.T @ white[part]
        if step == _STEPS:
            break
        cosine, sine, cosine_late, sine_late = np.linalg.solve(sums, products).reshape(4, lines)
        power = np.maximum(cosine**2 + sine**2, 1e-300)
        # A frequency that is wrong by d adds 2 pi d t times the derivative in phase.
        moved = (sine * cosine_late - cosine * sine_late) / (2 * np.pi * scale * power)
        frequency = frequency + np.clip(moved, -0.25 / scale, 0.25 / scale)
    now = slice(0, 2 * lines)
    sizes = np.linalg.solve(sums[now, now], products[now])
    rest = np.concatenate([white[part] - columns(part)[:, now] @ sizes for part in parts])
    own = np.linalg.inv(sums[now, now])
    gains = []
    for line in range(lines):
        pair = [line, lines + line]
        gains.append(sizes[pair] @ np.linalg.solve(own[np.ix_(pair, pair)], sizes[pair]))
    return frequency, rest, np.array(gains)


def _band(even: Float[np.ndarray, " samples"], middle: float, reach: float) -> float:
    """What one band of noise gains in log-likelihood at most, of normal shape or a resonance's."""
    samples = even.size
    power = np.abs(np.fft.rfft(even)) ** 2 / samples
    order = np.arange(power.size)
    near = np.abs(order / samples - middle) < reach
    order, power = order[near], power[near]
    strong = np.argsort(power)[-_MOST:]
    middles = np.append(order[strong], [middle * samples, power @ order / power.sum()])
    widths = np.geomspace(0.5, reach * samples, _WIDTHS)
    away = (order - middles[:, None, None]) / widths[:, None]
    heights = np.geomspace(0.3, max(power.max(), 1.0), _HEIGHTS)[:, None, None, None]
    best = 0.0
    for shape in (np.exp(-(away**2) / 2), 1 / (1 + away**2)):
        expected = 1 + heights * shape
        best = max(
            best, float(np.max(np.sum(power - power / expected - np.log(expected), axis=-1)))
        )
    return best
