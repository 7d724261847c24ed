"""Whether noise is as strong at all times: loud and quiet ones, or a strength that varies.

It looks at the whitened record, which is independent and standard normal when nothing is amiss, so
that the test has a null distribution that does not depend on the sensor.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from scipy.fft import dct, irfft, next_fast_len, rfft
from scipy.stats import chi2, f

from ._levels import Levels, levels_that_last, window_of
from ._paths import FEWEST_WINDOWS, UNEVEN, chance_of_scatter, levels_of, two_levels_of
from ._varying import varying

# Whitened samples beyond this are pulled in before variances are compared in time.
PULLED_IN = 4.0
_SHORTEST_WINDOW = 32
# Orders as slow as windows of this length are compared with how neighbouring short windows differ,
# unless the sum of squared correlations is more than this.
_LONG_WINDOW, _UNCORRELATED = 16 * _SHORTEST_WINDOW, 0.01
# Samples apart up to which the whitened record may be correlated.
_LAGS = 1024
# Windows of at most this many are told apart by the hidden Markov model.
_MOST_WINDOWS = 4096
# The part of false alarms that is left to windows, for what levels that last do not show.
_BRIEF = 0.25
# So many times over levels are measured.
_AGAIN = 3

Samples = Float[np.ndarray, " samples"]
Flags = Bool[np.ndarray, " samples"]
Windows = Float[np.ndarray, " windows"]


class Modulation(NamedTuple):
    """Two levels of variance, or a course of it."""

    #: Standard deviation of the loud times over that of the quiet ones, and draws of that.
    ratio: float
    draws: Float[np.ndarray, " draws"]
    #: Which samples are loud.
    loud: Bool[np.ndarray, " samples"]
    #: Samples a window, and the chance of windows as uneven as these.
    window: int
    p_value: float
    #: Where there is more to it than two levels: the standard deviation of each sample over that of
    #: the quiet times, and draws of the largest over the smallest.
    strength: Float[np.ndarray, " samples"] | None = None
    extremes: Float[np.ndarray, " draws"] | None = None
    #: Samples that were summed up to tell: their noise is that below their Nyquist frequency.
    summed: int = 1
    #: The log of how much likelier each sample is of the loud times, where two levels tell.
    odds: Float[np.ndarray, " samples"] | None = None

    def of(self, kept: Shaped[np.ndarray, " _"]) -> "Modulation":
        """The same of some of the samples, by flags or by their places."""
        strength = None if self.strength is None else self.strength[kept]
        odds = None if self.odds is None else self.odds[kept]
        return self._replace(loud=self.loud[kept], strength=strength, odds=odds)

    def sharp(self) -> "Modulation":
        """With each edge of the loud times where the likelihood has it, a window away at most.

        What is cut out as a knock is not sharp: its tail is quieter.
        """
        if self.odds is None:
            return self
        before = np.concatenate([[0.0], np.cumsum(self.odds)])
        edges, last = np.flatnonzero(np.diff(self.loud)) + 1, self.loud.size - 1
        for i, edge in enumerate(edges):
            low = max(edge - self.window, edges[i - 1] + 1 if i else 1)
            high = min(edge + self.window, edges[i + 1] - 1 if i + 1 < edges.size else last)
            sign = -1 if self.loud[edge] else 1
            edges[i] = low + int(np.argmax(sign * before[low : high + 1]))
        within = np.searchsorted(edges, np.arange(self.loud.size), side="right") % 2 == 1
        return self._replace(loud=within != self.loud[0])

    def at_times(self, loud: Bool[np.ndarray, " samples"]) -> "Modulation":
        """Two levels with other loud times, and how much louder these are."""
        assert self.odds is not None
        # The odds are linear in the squares of the noise, in some unit.
        squares = 2 * self.summed * self.odds + 2 * np.log(self.ratio)
        quiet, louder = (max(float(np.mean(squares[of])), 1e-9) for of in (~loud, loud))
        odds = _log_odds(squares, quiet, louder) / self.summed
        return self._replace(loud=loud, odds=odds).louder_by(float(np.sqrt(louder / quiet)))

    def louder_by(self, ratio: float) -> "Modulation":
        """Another ratio of the deviations, as certain as this one."""
        return self._replace(ratio=ratio, draws=self.draws * ratio / self.ratio)

    def deviation(self) -> Float[np.ndarray, " samples"]:
        """Of each sample, over that of the quiet times."""
        return np.where(self.loud, self.ratio, 1.0) if self.strength is None else self.strength


def local_power(white: Float[np.ndarray, " samples"], window: int) -> Float[np.ndarray, " windows"]:
    """Mean square in windows, spikes pulled in."""
    count = white.size // window
    pulled = np.clip(white[: count * window], -PULLED_IN, PULLED_IN)
    return np.mean(pulled.reshape(count, window) ** 2, axis=1)


def uneven(white: Float[np.ndarray, " samples"]) -> tuple[float, int, float]:
    """The chance that squares vary as they do, and the window that is as slow as they say best.

    Last, the variance of the mean square of so many samples, times their number.

    For independent samples the mean squares of short windows of m samples scatter with the variance
    of one square over m, whatever the distribution. So does each order of their cosine transform:
    the squares of the first J are chi-square with J degrees of freedom. Louder times that last are
    in few orders, wherever they begin, while windows as long as they would mix them with quiet
    ones. J is halved; Bonferroni over it, the k-th from the slowest with a share of 1/k, since what
    changes a sensor mostly lasts, and short spectra are scanned for what does not (`bursts`).

    Where whitening left a correlation r_k, as beside the zeros of a filter, squares of normal
    samples have the correlation r_k^2, and scatter by 1 + 2 sum r_k^2 more. Uncorrelated samples
    that are not normal, such as rounded angles made white, have squares that are correlated with
    their neighbours. Low orders are therefore compared with how neighbouring windows differ.
    """
    if not white.any():
        return 1.0, _SHORTEST_WINDOW, 1.0
    squares = np.clip(white, -PULLED_IN, PULLED_IN) ** 2
    correlation = _squared_correlation(white)
    one = float(np.var(squares)) * (1 + 2 * correlation)
    if white.size < FEWEST_WINDOWS * _SHORTEST_WINDOW:
        return 1.0, _SHORTEST_WINDOW, one
    power = local_power(white, _SHORTEST_WINDOW)
    steps = np.diff(power)
    # Of differences of neighbours, each in two of them, two thirds are degrees of freedom.
    measured, freedom = float(np.mean(steps**2)) / 2 * _SHORTEST_WINDOW, 2 * steps.size / 3
    plain = correlation < _UNCORRELATED
    orders = np.asarray(dct(power - power.mean(), norm="ortho"))[1:]
    scatter = _SHORTEST_WINDOW * np.cumsum(orders**2)
    chances, window = [], _SHORTEST_WINDOW
    while white.size // window >= FEWEST_WINDOWS:
        first = white.size // window - 1
        if window >= _LONG_WINDOW and plain:
            chance = float(f.sf(scatter[first - 1] / first / measured, first, freedom))
        else:
            chance = float(chi2.sf(scatter[first - 1] / one, first))
        chances.append(chance)
        window *= 2
    ranks = np.arange(len(chances), 0, -1)
    shared = np.array(chances) * ranks * np.sum(1 / ranks)
    best = int(np.argmin(shared))
    window = _SHORTEST_WINDOW * 2**best
    return min(1.0, float(shared[best])), window, measured if plain else one


def _squared_correlation(white: Float[np.ndarray, " samples"]) -> float:
    """The sum of squared correlations over the first lags, less what chance makes of it."""
    length = next_fast_len(white.size + _LAGS, real=True)
    power = np.abs(np.asarray(rfft(white, length))) ** 2
    covariance = np.asarray(irfft(power, length))[: _LAGS + 1]
    correlation = covariance[1:] / np.maximum(covariance[0], 1e-300)
    return max(float(np.sum(correlation**2)) - _LAGS / white.size, 0.0)


def modulation(white: Float[np.ndarray, " samples"], seed: int) -> Modulation:
    """When the noise is loud and when quiet: a hidden Markov model of two variances."""
    by_windows, slowest, variance = uneven(white)
    lasting, longest = lasting_levels(white, variance)
    p_value = either(by_windows, lasting)

    def told(path: Bool[np.ndarray, " windows"], window: int) -> Modulation:
        loud = of_samples(path, window, white.size)
        return _between_levels(white, loud, window, variance, seed)._replace(p_value=p_value)

    window = max(slowest // 2, _SHORTEST_WINDOW, white.size // _MOST_WINDOWS)
    power = local_power(white, window)
    weight = _weight(power, window, variance)
    labels = levels_of(power, weight)
    found = told(labels > 0, window)
    if p_value >= UNEVEN:
        return found
    found = _with_strength(found, white, labels, weight, seed)
    if lasting is None:
        return found
    if found.strength is not None:
        # A long window in which loud times begin or end is of a level between the two.
        several = labels.max() > 1 and lasting.p_value < UNEVEN
        if several and _are_all(white, lasting.path, longest, variance, seed):
            return told(lasting.path, longest)
        return found
    # The likeliest path leaves out what does not stand out by itself.
    if lasting.p_value < (by_windows if found.loud.any() else UNEVEN):
        return told(lasting.path, longest)
    if slowest >= _LONG_WINDOW and not found.loud.any():
        # That it varies is known already, and few changes do it.
        path, *_ = two_levels_of(power, weight, (np.log(power.size) / 2,))
        return told(path, window)
    return found


def _are_all(
    white: Samples, path: Bool[np.ndarray, " windows"], window: int, variance: float, seed: int
) -> bool:
    """Whether two levels are all there is: no course of it, and of each no more than noise.

    Windows at the edges of either are left out; `variance` is from `uneven`.
    """
    power = local_power(white, window)
    weight = _weight(power, window, variance)
    edges = np.flatnonzero(np.diff(path))
    inside = np.ones(path.size, bool)
    inside[edges] = inside[edges + 1] = False
    for level in (path & inside, ~path & inside):
        own = power[level]
        if own.size < FEWEST_WINDOWS or chance_of_scatter(own, weight) < UNEVEN:
            return False
    return varying(power, weight, path.astype(int), seed) is None


def either(by_windows: float, lasting: Levels | None) -> float:
    """The chance that windows or levels that last are as unlikely; mostly these are told first."""
    by_levels = 1.0 if lasting is None else lasting.p_value
    return min(1.0, by_windows / _BRIEF, by_levels / (1 - _BRIEF))


def lasting_levels(white: Samples, variance: float) -> tuple[Levels | None, int]:
    """Two levels that last, where there are windows enough to tell, and the window.

    `variance` is that of the mean square of so many samples, times their number.
    """
    window = window_of(white.size, _SHORTEST_WINDOW)
    if window is None or not white.any():
        return None, _SHORTEST_WINDOW
    power = local_power(white, window)
    return levels_that_last(power, _weight(power, window, variance)), window


def _weight(power: Windows, window: int, variance: float) -> float:
    """So many independent normal samples have as certain a mean square as windows have."""
    return float(2 * np.mean(power) ** 2 * window / variance)


def two_levels(white: Samples, loud: Flags, window: int, seed: int) -> Modulation:
    """Two levels of noise at times that are known to a window."""
    *_, variance = uneven(white)
    return _between_levels(white, loud, window, variance, seed)


def _between_levels(
    white: Samples, samples: Flags, window: int, variance: float, seed: int
) -> Modulation:
    """Two levels, of the samples that are loud and of the others; `variance` is from `uneven`."""
    power = local_power(white, window)
    weight = _weight(power, window, variance)
    quiet = loud = float(power.mean())
    odds = None
    if samples.any():
        quiet, loud = _variances(white, samples.astype(int), window)
        odds = _odds(white, quiet, loud)
    rng = np.random.default_rng(seed)
    windows = np.array([np.sum(~samples), np.sum(samples)]) / window
    spread = np.sqrt(2 / np.maximum(windows * weight, 2))
    log_ratio = np.log(loud / quiet) / 2
    draws = np.exp(log_ratio + rng.standard_normal(2000) * np.hypot(*spread) / 2)
    return Modulation(float(np.exp(log_ratio)), draws, samples, window, 1.0, odds=odds)


def of_samples(
    windows: Shaped[np.ndarray, " windows"], window: int, samples: int
) -> Shaped[np.ndarray, " samples"]:
    """What is true of windows, of their samples; of those beyond the last, what is of it."""
    return windows[np.minimum(np.arange(samples) // window, windows.size - 1)]


def _odds(white: Samples, quiet: float, loud: float) -> Samples:
    """The log of how much likelier each sample is with the variance of the loud times."""
    return _log_odds(np.minimum(white**2, PULLED_IN**2 * max(quiet, loud)), quiet, loud)


def _log_odds(squares: Samples, quiet: float, loud: float) -> Samples:
    """Of normal samples with these squares, between two variances."""
    return (squares * (1 / quiet - 1 / loud) - np.log(loud / quiet)) / 2


def _variances(
    white: Samples, of: Int[np.ndarray, " samples"], window: int
) -> Float[np.ndarray, " levels"]:
    """Of the samples of each level, pulled in where these themselves are far.

    Loud noise has many beyond what is far for all. Beside a change a window has samples of both.
    """
    inside = np.ones(white.size, bool)
    for edge in np.flatnonzero(np.diff(of)) + 1:
        inside[max(edge - window, 0) : edge + window] = False
    return np.array([_variance(white, of == each, inside) for each in range(int(of.max()) + 1)])


def _variance(white: Samples, of: Flags, inside: Flags) -> float:
    """Of some samples, those `inside` where there are any."""
    values = white[of & inside] if (of & inside).any() else white[of]
    level = float(np.mean(np.clip(values, -PULLED_IN, PULLED_IN) ** 2))
    for _ in range(_AGAIN):
        far = PULLED_IN * np.sqrt(level)
        level = float(np.mean(np.clip(values, -far, far) ** 2))
    return level


def _with_strength(
    found: Modulation, white: Samples, labels: Int[np.ndarray, " windows"], weight: float, seed: int
) -> Modulation:
    """The course of the strength beside two levels, where it is more than these."""
    middles = ((np.arange(labels.size) + 0.5) * found.window).astype(int)
    strength, told = np.ones(white.size), None
    for _ in range(_AGAIN):
        power = local_power(white / strength, found.window) * strength[middles] ** 2
        told = varying(power, weight, labels, seed)
        if told is None:
            return _with_levels(found, white, labels, weight, seed)
        strength = np.exp(np.interp(np.arange(white.size), middles, told.course) / 2)
    assert told is not None
    loud = found.loud
    if not loud.any() or loud.all():
        # No two levels of it are worth their changes: what is beyond the middle is loud.
        loud = strength > np.sqrt(strength.min() * strength.max())
        quiet, louder = (float(np.mean(strength[of] ** 2)) for of in (~loud, loud))
        ratio = np.sqrt(louder / quiet)
        found = found._replace(ratio=float(ratio), draws=found.draws / found.ratio * ratio)
    strength /= np.sqrt(np.mean(strength[~loud] ** 2))
    return found._replace(loud=loud, strength=strength, extremes=np.exp(told.reach / 2))


def _with_levels(
    found: Modulation, white: Samples, labels: Int[np.ndarray, " windows"], weight: float, seed: int
) -> Modulation:
    """More than two levels, if there are."""
    count = int(labels.max()) + 1
    if count < 3:
        return found
    of = of_samples(labels, found.window, white.size)
    levels = _variances(white, of, found.window)
    windows = np.array([np.sum(labels == each) for each in (np.argmin(levels), np.argmax(levels))])
    ratio = np.log(levels.max() / levels.min()) / 2
    spread = np.sqrt(2 / (windows * weight))
    noise = np.random.default_rng(seed).standard_normal(2000) * np.hypot(*spread) / 2
    strength = np.sqrt(levels / levels[0])[of]
    return found._replace(strength=strength, extremes=np.exp(ratio + noise))
