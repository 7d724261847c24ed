"""Is the noise normal, and as strong at all times? Outliers, bursts, knocks and changing variance.

All of it looks at the whitened record, which is independent and standard normal when nothing is
amiss, so that each test has a null distribution that does not depend on the sensor.
"""

import itertools
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.optimize import minimize, minimize_scalar
from scipy.special import expit
from scipy.stats import chi2, f

from ._strength import varying

# Whitened samples beyond this are pulled in before variances are compared in time.
PULLED_IN = 4.0
# Uniform parts whose fourth powers add up to less than that of this change no tail.
_FLAT = 0.3
# Half-width and points of the grid on which a body that is not normal is computed [standard
# deviations], and the density below which rounding errors show.
_GRID_REACH, _GRID_POINTS, _LEAST_DENSITY = 16.0, 4096, 1e-13
# Shares of spikes, and their size over that of the body, to begin with.
_SPIKES = ((1e-4, 10.0), (1e-3, 4.0), (1e-2, 3.0), (0.1, 2.0))
# Logarithm of a size beyond all others.
_FAR = 300.0
_SHORTEST_WINDOW = 32
_FEWEST_WINDOWS = 8
# Windows from this length on are compared with neighbouring short ones, unless the sum of squared
# correlations is more than this.
_LONG_WINDOW, _UNCORRELATED = 16 * _SHORTEST_WINDOW, 0.01
# Samples apart up to which the whitened record may be correlated.
_LAGS = 1024
# Windows of at most this many are told apart by the hidden Markov model.
_MOST_WINDOWS = 4096
# From such a chance on the strength is followed, and levels are measured so many times over.
_UNEVEN, _AGAIN = 1e-3, 3
# How much louder the loud times may be than the quiet ones, to begin with.
_EXCESSES = (0.03, 0.1, 0.3, 1.0, 10.0)


class Contamination(NamedTuple):
    """A mixture: a `fraction` of the samples has spikes of size `amplitude` added.

    Spikes are normal with this rms, or have Student's distribution with two degrees of freedom
    and this scale where that says more: many small ones and a few that are huge.
    """

    fraction: float
    amplitude: float
    sigma: float
    heavy: bool
    #: Half-widths of what is uniform in values without spikes, in their standard deviations.
    boxes: tuple[float, ...]
    #: Beyond this a sample is more likely a spike than not.
    threshold: float
    #: Draws of (fraction, amplitude, sigma), shape (draws, 3).
    draws: Float[np.ndarray, "draws three"]
    #: Twice the log-likelihood gained over one normal distribution.
    gain: float
    p_value: float


class Modulation(NamedTuple):
    """Two levels of variance."""

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

    def deviation(self) -> Float[np.ndarray, " samples"]:
        """Of each sample, over that of the quiet times."""
        return np.where(self.loud, self.ratio, 1.0) if self.strength is None else self.strength


def contamination(
    values: Float[np.ndarray, " samples"], seed: int, boxes: tuple[float, ...] = ()
) -> Contamination:
    """Spikes among other values, by maximum likelihood on their histogram.

    Most of what is said of spikes comes from the tails: the body is summed in narrow bins, so that
    a million samples cost no more than a thousand. The body is normal, or the sum of a normal value
    and of uniform ones of half-widths `boxes` (in standard deviations of the sum), whichever is
    likelier: tails that are lighter than a normal one's would hide spikes.
    """
    sigma = float(np.std(values))
    middle = 1.4826 * float(np.median(np.abs(values)))
    size = np.abs(values) / middle
    edges = np.concatenate([np.linspace(0, 6, 241), [np.inf]])
    body = np.histogram(size, edges)[0].astype(float)
    centres = (edges[:-2] + edges[1:-1]) / 2 * middle
    tail = size[size >= 6] * middle
    points = np.concatenate([centres, tail])
    weights = np.concatenate([body[:-1], np.ones(tail.size)])

    def negative(three: Float[np.ndarray, " three"], heavy: bool, boxes: tuple) -> float:
        mixture = sum(_densities(_free(three), heavy, boxes, points))
        return -float(weights @ np.log(np.maximum(mixture, 1e-300)))

    def alone(width: float, boxes: tuple) -> float:
        return -float(weights @ log_body(points, width, boxes))

    # The same histogram under one distribution of its own best width.
    width = np.sqrt(weights @ points**2 / weights.sum())
    reach = (0.8 * width, 1.1 * width)
    light = sum(each**4 for each in boxes) > _FLAT**4
    bodies = ((), boxes) if light else ((),)
    singles: list[Any] = [minimize_scalar(alone, bounds=reach, args=(each,)) for each in bodies]
    plain = min(float(single.fun) for single in singles)
    best, shape = None, (False, ())
    for body_of, spread, (fraction, spike) in itertools.product(bodies, (False, True), _SPIKES):
        start = np.array([np.log(fraction), np.log(spike * middle), np.log(middle)])
        found = minimize(
            negative, start, (spread, body_of), "Nelder-Mead", options={"maxiter": 600}
        )
        _, height, core = _free(found.x)
        if spread and height < core:
            # No spikes, but all of the values under another distribution.
            continue
        # Two kinds of spikes are tried; the plainer one is kept unless it says much less.
        if best is None or found.fun < best.fun - 2.0 * (spread and not shape[0]):
            best, shape = found, (spread, body_of)
    assert best is not None
    gain = max(2 * (plain - best.fun), 0.0)
    draws = curvature_draws(lambda x: negative(x, *shape), best.x, seed)
    found = np.array([_free(each) for each in draws])
    value = _free(best.x)
    grid = np.linspace(2, 12, 2001) * value[2]
    usual, spikes = _densities(value, *shape, grid)
    threshold = float(grid[np.argmax(spikes > usual)]) if np.any(spikes > usual) else np.inf
    # Fraction and size are free only where there are spikes.
    chance = float(chi2.sf(gain, 2))
    return Contamination(*value, *shape, threshold, found, gain if sigma else 0.0, chance)


def _free(parameters: Float[np.ndarray, " three"]) -> tuple[float, float, float]:
    """Fraction, size and width from their logistic or logarithm."""
    # Where there are no spikes their size may run away, and its square shall still be a number.
    size, width = np.exp(np.clip(parameters[1:], -_FAR, _FAR))
    return float(expit(parameters[0])), float(size), float(width)


def _densities(
    three: tuple[float, float, float],
    heavy: bool,
    boxes: tuple[float, ...],
    at: Float[np.ndarray, " values"],
):
    """Densities of the body and of the spikes of a mixture."""
    fraction, size, core = three
    wide = np.hypot(core, size)
    spike = _student(at / wide) if heavy else normal(at / wide)
    return (1 - fraction) * _body(at / core, boxes) / core, fraction * spike / wide


def _body(
    x: Float[np.ndarray, " values"], boxes: tuple[float, ...]
) -> Float[np.ndarray, " values"]:
    """Of a normal value and uniform ones within `boxes` together, of variance 1."""
    if not boxes:
        return normal(x)
    grid, logarithm = _sum_of_uniform(boxes)
    return np.exp(np.interp(np.abs(x), grid, logarithm, right=-_FAR))


@lru_cache
def _sum_of_uniform(
    boxes: tuple[float, ...],
) -> tuple[Float[np.ndarray, " points"], Float[np.ndarray, " points"]]:
    """The log density of a sum, which is the transform of the product of its parts' own."""
    half = np.asarray(boxes)
    rest = 1 - np.sum(half**2) / 3
    step = 2 * _GRID_REACH / _GRID_POINTS
    angular = 2 * np.pi * rfftfreq(_GRID_POINTS, step)
    parts = np.prod(np.sinc(half[:, None] * angular / np.pi), axis=0)
    density = np.asarray(irfft(np.exp(-rest * angular**2 / 2) * parts))[: _GRID_POINTS // 2] / step
    known = int(np.argmax(density < _LEAST_DENSITY))
    grid = step * np.arange(density.size)
    logarithm = np.log(density[:known])
    # Beyond all uniform parts the tail is that of the normal one.
    beyond = grid[known:] - grid[known - 1]
    tail = logarithm[-1] + beyond * (logarithm[-1] - logarithm[-2]) / step - beyond**2 / 2 / rest
    return grid, np.concatenate([logarithm, tail])


# Written out: SciPy's take five times as long, mostly to look at their arguments.
def normal(x: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Density of a standard normal distribution."""
    return np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)


def _student(x: Float[np.ndarray, " values"]) -> Float[np.ndarray, " values"]:
    """Of two degrees of freedom."""
    return (2 + x**2) ** -1.5


def log_body(
    at: Float[np.ndarray, " values"], width: float, boxes: tuple[float, ...]
) -> Float[np.ndarray, " values"]:
    """Log density of values without spikes, of standard deviation `width`."""
    return np.log(np.maximum(_body(at / width, boxes), 1e-300) / width)


def log_mixture(
    found: Contamination, at: Float[np.ndarray, " values"]
) -> Float[np.ndarray, " values"]:
    """Log density of a mixture."""
    three = found.fraction, found.amplitude, found.sigma
    return np.log(np.maximum(sum(_densities(three, found.heavy, found.boxes, at)), 1e-300))


def curvature_draws(
    negative, at: Float[np.ndarray, " k"], seed: int
) -> Float[np.ndarray, "draws k"]:
    """A normal posterior about the maximum, from the curvature there."""
    size = at.size
    step = 1e-2
    hessian = np.zeros((size, size))
    unit = step * np.eye(size)
    for i in range(size):
        for j in range(size):
            hessian[i, j] = (
                negative(at + unit[i] + unit[j])
                - negative(at + unit[i] - unit[j])
                - negative(at - unit[i] + unit[j])
                + negative(at - unit[i] - unit[j])
            ) / (4 * step**2)
    values, vectors = np.linalg.eigh((hessian + hessian.T) / 2)
    scale = vectors / np.sqrt(np.maximum(values, 1e-2))
    return at + np.random.default_rng(seed).standard_normal((2000, size)) @ scale.T


def local_power(white: Float[np.ndarray, " samples"], window: int) -> Float[np.ndarray, " windows"]:
    """Mean square in windows, spikes pulled in."""
    count = white.size // window
    pulled = np.clip(white[: count * window], -PULLED_IN, PULLED_IN)
    return np.mean(pulled.reshape(count, window) ** 2, axis=1)


def uneven(white: Float[np.ndarray, " samples"]) -> tuple[float, int, float]:
    """The chance that windowed variances differ as they do, and the window that says so best.

    Last, the variance of the mean square of so many samples, times their number.

    For independent samples the mean squares of W windows of m samples scatter with the variance of
    one square over m, whatever the distribution: their sum of squares is chi-square with W - 1
    degrees of freedom. Windows double in length; Bonferroni over them.

    Where whitening left a correlation r_k, as beside the zeros of a filter, squares of normal
    samples have the correlation r_k^2, and scatter by 1 + 2 sum r_k^2 more. Uncorrelated samples
    that are not normal, such as rounded angles made white, have squares that are correlated with
    their neighbours. Long windows are therefore compared with how neighbouring short ones differ.
    """
    squares = np.clip(white, -PULLED_IN, PULLED_IN) ** 2
    correlation = _squared_correlation(white)
    one = float(np.var(squares)) * (1 + 2 * correlation)
    steps = np.diff(local_power(white, _SHORTEST_WINDOW))
    # Of differences of neighbours, each in two of them, two thirds are degrees of freedom.
    measured, freedom = float(np.mean(steps**2)) / 2 * _SHORTEST_WINDOW, 2 * steps.size / 3
    plain = correlation < _UNCORRELATED
    best, at, levels = 1.0, _SHORTEST_WINDOW, 0
    window = _SHORTEST_WINDOW
    while white.size // window >= _FEWEST_WINDOWS:
        power = local_power(white, window)
        scatter = float(np.var(power, ddof=1)) * window
        if window >= _LONG_WINDOW and plain:
            chance = float(f.sf(scatter / measured, power.size - 1, freedom))
        else:
            chance = float(chi2.sf(scatter / one * (power.size - 1), power.size - 1))
        levels += 1
        if chance < best:
            best, at = chance, window
        window *= 2
    return min(1.0, best * max(levels, 1)), at, measured if plain else one


def _squared_correlation(white: Float[np.ndarray, " samples"]) -> float:
    """The sum of squared correlations over the first lags, less what chance makes of it."""
    length = next_fast_len(white.size + _LAGS, real=True)
    power = np.abs(np.asarray(rfft(white, length))) ** 2
    covariance = np.asarray(irfft(power, length))[: _LAGS + 1]
    correlation = covariance[1:] / np.maximum(covariance[0], 1e-300)
    return max(float(np.sum(correlation**2)) - _LAGS / white.size, 0.0)


def modulation(white: Float[np.ndarray, " samples"], seed: int) -> Modulation:
    """When the noise is loud and when quiet: a hidden Markov model of two variances."""
    p_value, window, variance = uneven(white)
    window = max(window // 2, _SHORTEST_WINDOW, white.size // _MOST_WINDOWS)
    power = local_power(white, window)
    # So many independent normal samples have as certain a mean square.
    weight = float(2 * np.mean(power) ** 2 * window / variance)
    path, quiet, loud = _two_levels(power, weight)
    samples = _of_samples(path, window, white.size)
    if path.any() and not path.all():
        quiet, loud = _unclipped(white, samples, window, (quiet, loud))
    rng = np.random.default_rng(seed)
    freedom = np.maximum([np.sum(~path) * weight, np.sum(path) * weight], 2)
    spread = np.sqrt(2 / freedom)
    log_ratio = np.log(loud / quiet) / 2
    draws = np.exp(log_ratio + rng.standard_normal(2000) * np.hypot(*spread) / 2)
    found = Modulation(float(np.exp(log_ratio)), draws, samples, window, p_value)
    return _with_strength(found, white, path, weight, seed) if p_value < _UNEVEN else found


def _of_samples(of_windows: np.ndarray, window: int, samples: int) -> Float[np.ndarray, " samples"]:
    """What is true of windows, of each sample; of those beyond the last window what is of it."""
    return of_windows[np.minimum(np.arange(samples) // window, of_windows.size - 1)]


def _unclipped(
    white: Float[np.ndarray, " samples"],
    loud: Bool[np.ndarray, " samples"],
    window: int,
    levels: tuple[float, float],
) -> tuple[float, float]:
    """Two variances again, of samples pulled in where their own level says that they are far.

    Loud noise has many beyond what is far for all. Beside a change a window has samples of both.
    """
    inside = np.ones(white.size, bool)
    for edge in np.flatnonzero(np.diff(loud)) + 1:
        inside[max(edge - window, 0) : edge + window] = False
    parts = [
        white[each & inside] if (each & inside).any() else white[each] for each in (~loud, loud)
    ]
    for _ in range(_AGAIN):
        ends = (PULLED_IN * np.sqrt(level) for level in levels)
        quiet, strong = (
            np.mean(np.clip(x, -far, far) ** 2) for x, far in zip(parts, ends, strict=True)
        )
        levels = float(quiet), float(strong)
    return levels


def _with_strength(
    found: Modulation,
    white: Float[np.ndarray, " samples"],
    path: Bool[np.ndarray, " windows"],
    weight: float,
    seed: int,
) -> Modulation:
    """The course of the strength beside two levels, where it is more than these."""
    middles = (np.arange(path.size) + 0.5) * found.window
    quiet = ~found.loud if not found.loud.all() else found.loud
    strength = np.ones(white.size)
    course, draws = None, None
    for _ in range(_AGAIN):
        power = local_power(white / strength, found.window)
        level = 2 * np.log(strength[middles.astype(int)])
        told = varying(power * np.exp(level), weight, path, seed)
        if told is None:
            return found
        course, draws = told
        strength = np.exp(np.interp(np.arange(white.size), middles, course) / 2)
    assert draws is not None
    strength /= np.sqrt(np.mean(strength[quiet] ** 2))
    return found._replace(
        strength=strength, extremes=np.exp((draws.max(axis=1) - draws.min(axis=1)) / 2)
    )


def _two_levels(
    power: Float[np.ndarray, " windows"], samples: float
) -> tuple[Bool[np.ndarray, " windows"], float, float]:
    """The likeliest path between two variances, and the two; begun from several ratios."""
    mean = float(power.mean())
    best = np.zeros(power.size, bool), mean, mean
    # Leaving a level must be worth some evidence, or noise would chop intervals up; it is asked for
    # less where that leaves nothing.
    for price in np.log(power.size) + np.array([2.0, 0.0]):
        highest = _likelihood(power, mean, samples).sum()
        for excess in _EXCESSES:
            # As if a third of the time were loud.
            quiet = mean / (1 + excess / 3)
            path, *levels, score = _climbed(power, samples, price, quiet, quiet * (1 + excess))
            if score > highest:
                best, highest = (path, levels[0], levels[1]), score
        if best[0].any():
            break
    return best


def _climbed(
    power: Float[np.ndarray, " windows"], samples: float, price: float, quiet: float, loud: float
) -> tuple[Bool[np.ndarray, " windows"], float, float, float]:
    """Path and levels by turns (Viterbi), and their log-likelihood less the price of changes."""
    path = np.zeros(power.size, bool)
    for _ in range(20):
        likelihood = np.stack([_likelihood(power, level, samples) for level in (quiet, loud)])
        score = likelihood[:, 0]
        came = np.zeros((2, power.size), int)
        for t in range(1, power.size):
            across = score[::-1] - price
            came[:, t] = np.where(across > score, [1, 0], [0, 1])
            score = np.maximum(score, across) + likelihood[:, t]
        found = np.zeros(power.size, int)
        found[-1] = int(np.argmax(score))
        for t in range(power.size - 1, 0, -1):
            found[t - 1] = came[found[t], t]
        same = np.array_equal(found.astype(bool), path)
        path = found.astype(bool)
        if not path.any() or path.all():
            return path, quiet, loud, -np.inf
        quiet, loud = float(power[~path].mean()), float(power[path].mean())
        if same:
            break
    if loud < quiet:
        path, quiet, loud = ~path, loud, quiet
    return path, quiet, loud, float(score.max())


def _likelihood(
    power: Float[np.ndarray, " windows"], level: float, samples: float
) -> Float[np.ndarray, " windows"]:
    """The log-likelihood of mean squares of so many samples, Gamma variates about a level."""
    return -samples / 2 * (np.log(level) + power / level)
