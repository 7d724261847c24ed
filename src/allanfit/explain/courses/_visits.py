"""Whether a telegraph comes to one height whenever it leaves the level that it is on most.

A telegraph has two levels; pulses of differing heights have not, though two levels describe their
distribution better than one. So each visit to the rarer level is measured against the quiet times
on both its sides, and by the noise of such a difference of means, of which the spectrum tells.
What exceeds the typical height by a part of it, and by what noise does, is too high for a
telegraph: brief returns that nobody sees lower a visit, and nothing makes it higher. Of few visits
their scatter tells more, by chi-square, where it is larger than such returns make it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.fft import dct, idct, irfft
from scipy.special import ndtr
from scipy.stats import binom, chi2

from .._intervals import runs
from ._decoded import likeliest

# A visit that is too high is higher by such a part of the height, and by so many of its own
# standard deviations.
_HIGHER, _DEVIATIONS = 0.25, 3.0
# Samples on each side whose mean is taken, at most; and of a visit and of each side, at least.
_MOST, _FEWEST = 512, 3
# Edges of the likeliest path are wrong by so many samples, times the noise over the height squared.
_EDGE = 4.0
# A visit that would be seen were it lower by so many standard deviations was not picked for being
# high.
_SEEN = 2.0
# Moments of a visit, and how often the path is sought.
_A_VISIT, _ROUNDS = 16, 3
# They scatter by such a part of the height beside noise, which hidden returns do not make of them,
# and the few that are farthest off may have been disturbed. A deviation over a median one.
_SCATTER, _FARTHEST, _NORMAL = 0.2, 2, 1.4826
# Fewer visits, or a smaller part of them that is too high, tell nothing.
_VISITS, _SHARE = 8, 0.08

Samples = Float[np.ndarray, " samples"]


class Visits(NamedTuple):
    """Visits to the rarer level."""

    #: Each as a row `[start, stop)`.
    at: Int[np.ndarray, "visits 2"]
    #: How far each is from the quiet times beside it [u], and the standard deviation by noise.
    height: Float[np.ndarray, " visits"]
    deviation: Float[np.ndarray, " visits"]

    @property
    def typical(self) -> float:
        """The median height [u]."""
        return float(np.median(self.height))

    @property
    def too_high(self) -> Bool[np.ndarray, " visits"]:
        """Which are clearly higher than that."""
        return self.height > (1 + _HIGHER) * self.typical + _DEVIATIONS * self.deviation

    @property
    def log_chance(self) -> float:
        """Log of the chance that noise makes heights that differ as much, of visits all alike."""
        return min(min(self._of_high, self._of_scatter) + float(np.log(2)), 0.0)

    @property
    def _of_high(self) -> float:
        """Of as many that are too high."""
        many, count = self.height.size, int(np.count_nonzero(self.too_high))
        if count < _SHARE * many:
            return 0.0
        # Each passes by chance as often as a normal value passes so many standard deviations.
        beyond = _DEVIATIONS + _HIGHER * self.typical / self.deviation
        return float(binom.logsf(count - 1, many, np.mean(ndtr(-beyond))))

    @property
    def _of_scatter(self) -> float:
        """Of as much scatter, without the few that are farthest off."""
        off = np.abs(self.height - self.typical)
        scatter = (_NORMAL * np.median(off)) ** 2 - np.median(self.deviation) ** 2
        if scatter < (_SCATTER * self.typical) ** 2:
            return 0.0
        squares = np.sort((off / self.deviation) ** 2)[:-_FARTHEST]
        return float(chi2.logsf(squares.sum(), self.height.size - 1))


def visits(
    values: Samples,
    level: Samples,
    density: Float[np.ndarray, " frequencies"],
    settles: int,
) -> Visits | None:
    """The visits of `values` to the rarer level; None of fewer than eight that are seen for sure.

    `level` is a rough path of zeros and ones; `density` [u^2], of white noise its variance, is that
    of the noise at evenly spaced frequencies up to half the rate; a switch `settles` within so many
    samples.
    """
    if np.mean(level) > 0.5:
        values, level = -values, 1 - level
    frequency = np.linspace(0.0, 0.5, density.size)
    for _ in range(_ROUNDS):
        switches = np.count_nonzero(np.diff(level))
        if switches < 2 * _VISITS:
            return None
        brief = 2 * float(np.sum(level)) / switches
        # That of noise which changes as fast as the level does.
        white = float(np.interp(1 / (2 * brief), frequency, density))
        level = _likelier(values, level, white, density, brief)
    at = np.array(runs(level > 0), int).reshape(-1, 2)
    at = at[(at[:, 0] > 0) & (at[:, 1] < values.size)]
    if len(at) < _VISITS:
        return None
    rough = values[level > 0].mean() - values[level <= 0].mean()
    if rough <= 0:
        return None
    noise = white / rough**2
    edge = settles + int(np.ceil(_EDGE * noise))
    # What the likeliest path has to gain for a visit.
    cost = 2 * np.log(values.size / len(at))
    size = np.diff(at, axis=1)[:, 0] - 2 * edge
    quiet = np.diff(np.concatenate([[0], at.ravel(), [values.size]]))[::2] // 2 - edge
    before, after = quiet[:-1], quiet[1:]
    inside = np.clip(size, 1, _MOST)
    lowest = 0.5 + cost * noise / inside + _SEEN * np.sqrt(noise / inside)
    seen = (size >= _FEWEST) & (before >= _FEWEST) & (after >= _FEWEST) & (lowest < 1)
    if np.count_nonzero(seen) < _VISITS:
        return None
    at, inside = at[seen], inside[seen]
    before, after = np.minimum(before[seen], _MOST), np.minimum(after[seen], _MOST)
    # Of a long visit both ends, each beside its quiet time.
    first, last = at[:, 0] + edge, at[:, 1] - edge
    starts = np.stack([first, last - inside, at[:, 0] - edge - before, at[:, 1] + edge], axis=1)
    lengths = np.stack([inside, inside, before, after], axis=1)
    sums = np.concatenate([[0.0], np.cumsum(values)])
    means = (sums[starts + lengths] - sums[starts]) / lengths
    weights = np.array([0.5, 0.5, -0.5, -0.5]) / lengths
    variance = _variance(starts, starts + lengths, weights, density)
    return Visits(at, means @ [0.5, 0.5, -0.5, -0.5], np.sqrt(variance))


def _likelier(
    values: Samples,
    level: Samples,
    white: float,
    density: Float[np.ndarray, " frequencies"],
    brief: float,
) -> Samples:
    """The likeliest path beside noise of such a `density`, of which the slow part is known first.

    Of that all is slow that exceeds the part which is `white` where levels change.
    """
    modes = np.linspace(0.0, 0.5, values.size)
    every = np.interp(modes, np.linspace(0.0, 0.5, density.size), density)
    fast = np.minimum(white / every, 1.0)
    fast[modes > 1 / (2 * brief)] = 1.0

    def quick(series: Samples) -> Samples:
        return np.asarray(idct(np.asarray(dct(series, norm="ortho")) * fast, norm="ortho"))

    bare, path = quick(values), quick(level)
    height = float(bare @ path / (path @ path))
    if height <= 0:
        # Levels that have changed places are none.
        return np.zeros(values.size)
    rest = bare + height * (level - path)
    size = max(round(brief / _A_VISIT), 1)
    count = values.size // size
    means = rest[: count * size].reshape(count, size).mean(axis=1)
    # A visit costs two switches, of which one is the rarer.
    share = float(np.mean(level))
    leave = size / brief * np.sqrt(share / (1 - share))
    middle = float(np.mean(rest[level <= 0]))
    found = likeliest((means - middle) / height, white / size / height**2, leave)
    return np.pad(np.repeat(found, size), (0, values.size % size), mode="edge").astype(float)


def _variance(
    starts: Int[np.ndarray, "rows parts"],
    stops: Int[np.ndarray, "rows parts"],
    weights: Float[np.ndarray, "rows parts"],
    density: Float[np.ndarray, " frequencies"],
) -> Float[np.ndarray, " rows"]:
    """Of weighted sums of noise over parts of a record, the weights of all samples adding to zero.

    Two sums have a covariance that the variances of sums between their ends tell.
    """
    longest = int((stops.max(axis=1) - starts.min(axis=1)).max())
    size = 2 ** int(np.ceil(np.log2(2 * longest + 2)))
    even = np.interp(np.arange(size // 2 + 1) / size, np.linspace(0, 0.5, density.size), density)
    memory = np.asarray(irfft(even, size))[: longest + 1]
    # The variance of the sum of n samples: n c_0 + 2 sum (n - k) c_k.
    of_sum = np.concatenate([[0.0], np.cumsum(2 * np.cumsum(memory) - memory[0])])
    total = np.zeros(len(starts))
    for one in range(starts.shape[1]):
        for other in range(starts.shape[1]):
            a, b, c, d = starts[:, one], stops[:, one], starts[:, other], stops[:, other]
            both = of_sum[np.abs(d - a)] + of_sum[np.abs(c - b)]
            both -= of_sum[np.abs(c - a)] + of_sum[np.abs(d - b)]
            total += weights[:, one] * weights[:, other] * both / 2
    return np.maximum(total, 1e-300)
