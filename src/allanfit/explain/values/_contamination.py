"""Spikes among values that are normal else, or nearly so, by maximum likelihood.

It looks at the whitened record, which is independent and standard normal when nothing is amiss.
"""

import itertools
from collections.abc import Callable
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.fft import irfft, rfftfreq
from scipy.optimize import minimize, minimize_scalar
from scipy.special import expit
from scipy.stats import chi2, norm

from ...physics._outliers import UNLIKE

# Uniform parts whose fourth powers add up to less than that of this change no tail.
_FLAT = 0.3
# Half-width and points of the grid on which a body that is not normal is computed [standard
# deviations], and the density below which rounding errors show.
_GRID_REACH, _GRID_POINTS, _LEAST_DENSITY = 16.0, 4096, 1e-13
# Shares of spikes, and their size over that of the body, to begin with.
_SPIKES = ((1e-4, 10.0), (1e-3, 4.0), (1e-2, 3.0), (0.1, 2.0))
Law = Literal["normal", "student", "alike"]
#: Laws of their sizes, the plainest first, and nats that another has to say more than that one.
LAWS: tuple[Law, ...] = ("normal", "student", "alike")
_PLAINER = 2.0
# Those with one size, between which the data may not tell; and odds that are too small to show.
_OF_ONE_SIZE: tuple[Law, ...] = ("normal", "alike")
_UNLIKELY = 0.03
# Spikes that are alike are so many times as large as the body is wide.
_APART = 3.0
# In the gain of a step as a part of the log-likelihood, and in its derivatives.
_TO_THE_END = {"ftol": 1e-12, "gtol": 1e-3}
_DRAWS = 2000
# As many draws of a variance show how uncertain it is.
_FEW_DRAWS = 200
# How far the logarithm of a size is from that of the reach beyond which spikes are told, before any
# are: a few of them say hardly how many there are within.
_LIKE_REACH = 0.7
# Logarithm of a size beyond all others.
_FAR = 300.0


class Contamination(NamedTuple):
    """A mixture: a `fraction` of the samples has spikes of size `amplitude` added.

    Spikes are normal with this rms. Where it says more they have Student's distribution with two
    degrees of freedom and this scale, many small ones and a few that are huge; or are all alike,
    up or down by about this much, as a bit that flips makes them.
    """

    fraction: float
    amplitude: float
    sigma: float
    law: Law
    #: Half-widths of what is uniform in values without spikes, in their standard deviations.
    boxes: tuple[float, ...]
    #: Beyond this a sample is more likely a spike than not.
    threshold: float
    #: Draws of (fraction, amplitude, sigma), shape (draws, 3): of each likely law some.
    draws: Float[np.ndarray, "draws three"]
    #: Which of `LAWS` each is of.
    drawn_by: Int[np.ndarray, " draws"]
    #: Twice the log-likelihood gained over one normal distribution.
    gain: float
    p_value: float

    @property
    def heavy(self) -> bool:
        """Whether a few spikes are far larger than most."""
        return self.law == "student"


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

    def negative(
        parameters: Float[np.ndarray, " three"], law: Law, boxes: tuple
    ) -> tuple[float, Float[np.ndarray, " three"]]:
        """Of the log-likelihood, and its derivatives."""
        three = fraction, _, core = _free(parameters)
        body, spikes = _densities(three, law, boxes, points)
        mixture = np.maximum(body + spikes, 1e-300)
        body, spikes = weights * body / mixture, weights * spikes / mixture
        of_size, of_core = _spike_slopes(three, law, points)
        slopes = (
            (1 - fraction) * spikes.sum() - fraction * body.sum(),
            spikes @ of_size,
            spikes @ of_core + body @ _body_slope(points / core, boxes),
        )
        return -float(weights @ np.log(mixture)), -np.array(slopes)

    def alone(width: float, boxes: tuple) -> float:
        return -float(weights @ log_body(points, width, boxes))

    # The same histogram under one distribution of its own best width.
    width = np.sqrt(weights @ points**2 / weights.sum())
    reach = (0.8 * width, 1.1 * width)
    light = sum(each**4 for each in boxes) > _FLAT**4
    bodies = ((), boxes) if light else ((),)
    singles: list[Any] = [minimize_scalar(alone, bounds=reach, args=(each,)) for each in bodies]
    plain = min(float(single.fun) for single in singles)
    # Where spikes that are alike would be, no other start leads.
    far = [(tail.size / weights.sum(), np.median(tail) / middle)] if tail.size else []
    best: Any = None
    shape: tuple[Law, tuple[float, ...]] = (LAWS[0], ())
    of_each: dict[tuple[Law, tuple[float, ...]], Any] = {}
    for body_of, law in itertools.product(bodies, LAWS):
        for fraction, spike in (*_SPIKES, *far):
            start = np.array([np.log(fraction), np.log(spike * middle), np.log(middle)])
            found = minimize(
                negative, start, (law, body_of), "L-BFGS-B", jac=True, options=_TO_THE_END
            )
            _, height, core = _free(found.x)
            if law != LAWS[0] and height < (core if law == "student" else _APART * core):
                # No spikes, but all of the values under another distribution.
                continue
            if found.fun < getattr(of_each.get((law, body_of)), "fun", np.inf):
                of_each[law, body_of] = found
            # The plainest kind of spikes is kept unless it says much less.
            plainest = law != LAWS[0] and shape[0] == LAWS[0]
            if best is None or found.fun < best.fun - _PLAINER * plainest:
                best, shape = found, (law, body_of)
    assert best is not None
    gain = max(2 * (plain - best.fun), 0.0)
    law, body_of = shape
    rivals: dict[Law, Any] = {
        each: of_each[each, body_of] for each in LAWS if (each, body_of) in of_each
    }
    draws, drawn_by = _of_likely_laws(lambda x, of: negative(x, of, body_of)[0], rivals, law, seed)
    found = np.array([_free(each) for each in draws])
    value = _free(best.x)
    grid = np.linspace(2, 12, 2001) * value[2]
    usual, spikes = _densities(value, *shape, grid)
    threshold = float(grid[np.argmax(spikes > usual)]) if np.any(spikes > usual) else np.inf
    # Fraction and size are free only where there are spikes.
    chance = float(chi2.sf(gain, 2))
    told = gain if sigma else 0.0
    return Contamination(*value, *shape, threshold, found, drawn_by, told, chance)


def _free(parameters: Float[np.ndarray, " three"]) -> tuple[float, float, float]:
    """Fraction, size and width from their logistic or logarithm."""
    # Where there are no spikes their size may run away, and its square shall still be a number.
    size, width = np.exp(np.clip(parameters[1:], -_FAR, _FAR))
    return float(expit(parameters[0])), float(size), float(width)


def _densities(
    three: tuple[float, float, float],
    law: Law,
    boxes: tuple[float, ...],
    at: Float[np.ndarray, " values"],
):
    """Densities of the body and of the spikes of a mixture."""
    fraction, size, core = three
    wide = np.hypot(core, UNLIKE * size if law == "alike" else size)
    if law == "alike":
        spike = (normal((at - size) / wide) + normal((at + size) / wide)) / 2
    else:
        spike = _student(at / wide) if law == "student" else normal(at / wide)
    return (1 - fraction) * _body(at / core, boxes) / core, fraction * spike / wide


def _spike_slopes(
    three: tuple[float, float, float], law: Law, at: Float[np.ndarray, " values"]
) -> tuple[Float[np.ndarray, " values"], Float[np.ndarray, " values"]]:
    """Derivatives of the log density of spikes by the logs of their size and of the core."""
    _, size, core = three
    if law != "alike":
        wide = np.hypot(core, size)
        x = at / wide
        wider = 3 * x**2 / (2 + x**2) - 1 if law == "student" else x**2 - 1
        return wider * (size / wide) ** 2, wider * (core / wide) ** 2
    wide = np.hypot(core, UNLIKE * size)
    up, down = (at - size) / wide, (at + size) / wide
    # The share of those that are up, without the overflow of either density.
    share = expit((down**2 - up**2) / 2)
    wider = share * up**2 + (1 - share) * down**2 - 1
    along = size / wide * (share * up - (1 - share) * down)
    return along + wider * (UNLIKE * size / wide) ** 2, wider * (core / wide) ** 2


def _body_slope(
    x: Float[np.ndarray, " values"], boxes: tuple[float, ...]
) -> Float[np.ndarray, " values"]:
    """The same of the body."""
    if not boxes:
        return x**2 - 1
    grid, _, slope = _sum_of_uniform(boxes)
    at = np.minimum(np.abs(x) / grid[1], grid.size - 1).astype(int)
    return -np.abs(x) * slope[at] - 1


def _body(
    x: Float[np.ndarray, " values"], boxes: tuple[float, ...]
) -> Float[np.ndarray, " values"]:
    """Of a normal value and uniform ones within `boxes` together, of variance 1."""
    if not boxes:
        return normal(x)
    grid, logarithm, _ = _sum_of_uniform(boxes)
    return np.exp(np.interp(np.abs(x), grid, logarithm, right=-np.inf))


@lru_cache
def _sum_of_uniform(
    boxes: tuple[float, ...],
) -> tuple[
    Float[np.ndarray, " points"], Float[np.ndarray, " points"], Float[np.ndarray, " points"]
]:
    """The log density of a sum on a grid, and its slope from each point to the next.

    It is the transform of the product of its parts' own.
    """
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
    whole = np.concatenate([logarithm, tail])
    return grid, whole, np.append(np.diff(whole) / step, 0.0)


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
    return np.log(np.maximum(sum(_densities(three, found.law, found.boxes, at)), 1e-300))


def beyond(
    sizes: Float[np.ndarray, " spikes"], reach: float, samples: int, seed: int
) -> Contamination:
    """Spikes of which only those beyond some reach are told from noise, by maximum likelihood.

    How many there are, and how far, tells of those within: normal ones, or all alike. `sizes` and
    `reach` are in standard deviations of the noise, and so is what is found. Its gain and chance
    the caller has to tell.
    """

    def negative(two: Float[np.ndarray, " two"], law: Law) -> float:
        three = float(expit(two[0])), float(np.exp(two[1])), 1.0
        within = 1 - three[0] * _outside(reach, three[1], law)
        density = 2 * np.maximum(_densities(three, law, (), sizes)[1], 1e-300)
        told = (samples - sizes.size) * np.log(within) + np.log(density).sum()
        return float(((two[1] - np.log(reach)) / _LIKE_REACH) ** 2 / 2 - told)

    start = np.array([np.log(2 * sizes.size / samples), np.log(np.sqrt(np.mean(sizes**2)))])
    each: dict[Law, Any] = {
        law: minimize(negative, start, (law,), "Nelder-Mead") for law in _OF_ONE_SIZE
    }
    law = min(each, key=lambda law: each[law].fun + _cost(law))
    best = each[law].x
    drawn, drawn_by = _of_likely_laws(negative, each, law, seed)
    draws = np.column_stack([expit(drawn[:, 0]), np.exp(drawn[:, 1]), np.ones(len(drawn))])
    fraction, size = float(expit(best[0])), float(np.exp(best[1]))
    return Contamination(fraction, size, 1.0, law, (), reach, draws, drawn_by, 0.0, 1.0)


def _of_likely_laws(
    negative: Callable[[Float[np.ndarray, " k"], Law], float],
    fits: dict[Law, Any],
    law: Law,
    seed: int,
) -> tuple[Float[np.ndarray, "draws k"], Int[np.ndarray, " draws"]]:
    """Draws about the maxima of all laws that may be, and which of `LAWS` each is of.

    Few spikes hardly tell whether they are the largest of many or all alike, which are other
    numbers. That some are huge is told, and the size is another one then.
    """
    may_be = _OF_ONE_SIZE if law in _OF_ONE_SIZE else (law,)
    worth = {each: -fits[each].fun - _cost(each) for each in may_be if each in fits}
    odds = np.array([np.exp(worth.get(each, -np.inf) - max(worth.values())) for each in LAWS])
    odds[odds < _UNLIKELY] = 0.0
    counts = np.round(_DRAWS * odds / odds.sum()).astype(int)

    def draws_of(each: Law, count: int) -> Float[np.ndarray, "count k"]:
        return curvature_draws(lambda x: negative(x, each), fits[each].x, seed)[:count]

    drawn = [
        draws_of(each, count) for each, count in zip(LAWS, counts.tolist(), strict=True) if count
    ]
    return np.concatenate(drawn), np.repeat(np.arange(len(LAWS)), counts)


def _cost(law: Law) -> float:
    """Nats that it has to say more than the plainest."""
    return 0.0 if law == LAWS[0] else _PLAINER


def _outside(reach: float, size: float, law: Law) -> float:
    """The share of spikes, with noise of one, that are beyond some reach."""
    if law == "normal":
        return float(2 * norm.sf(reach / np.hypot(1.0, size)))
    wide = np.hypot(1.0, UNLIKE * size)
    return float(norm.sf((reach - size) / wide) + norm.sf((reach + size) / wide))


def in_units(found: Contamination, height: float) -> Contamination:
    """In another unit, of which one stands `height` tall."""
    scale = np.array([1.0, 1 / height, 1 / height])
    return found._replace(
        amplitude=found.amplitude / height,
        sigma=found.sigma / height,
        threshold=found.threshold / height,
        draws=found.draws * scale,
    )


def unseen(found: Contamination) -> float:
    """Variance that spikes within reach of the noise add to it, in the unit squared."""
    widest = _GRID_REACH * float(np.hypot(found.sigma, found.amplitude))
    at = np.linspace(0.0, min(found.threshold, widest), _GRID_POINTS)
    three = found.fraction, found.amplitude, found.sigma
    spikes = _densities(three, found.law, found.boxes, at)[1]
    return max(2 * float(np.trapezoid(spikes * (at**2 - found.sigma**2), at)), 0.0)


def unseen_draws(found: Contamination, seed: int) -> Float[np.ndarray, " few"]:
    """Draws of the same."""
    few = np.random.default_rng(seed).choice(len(found.draws), _FEW_DRAWS)
    return np.array(
        [
            unseen(found._replace(fraction=f, amplitude=size, law=LAWS[law]))
            for (f, size, _), law in zip(
                found.draws[few].tolist(), found.drawn_by[few].tolist(), strict=True
            )
        ]
    )


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
    return at + np.random.default_rng(seed).standard_normal((_DRAWS, size)) @ scale.T
