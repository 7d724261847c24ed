"""What is not noise but a course in time: steps, a warm-up, a slow oscillation, temperature.

A course is a mean of the ordinates' signed amplitudes, which are independent, each with the
variance that the noise gives it: its size is found by generalised least squares, the ramp taken
out of both sides. A random walk imitates every slow course, and a course that is left out makes
the walk larger; so a course counts for what the likelihood gains when the noise is fitted again.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.signal import lfilter

from ..spectrum._climb import log_scatter
from ..spectrum._in_bins import shaped
from ..spectrum._model import Model, mean_density, rescaled
from ..spectrum._ordinates import Ordinates, amplitudes, points
from ..spectrum._structure import HIGH_PASS, SHAPE, Data
from ._sums import Moved, Products, Summing

_ROUNDS = 3
# What changes as slowly as a step at most, and how far below the top of what is slow a sinusoid is.
_SLOW = ("step", "warm_up", "temperature")
_FAR = 8.0
# A thermometer that is behind is as smooth as one that is ahead by such a part of its lag.
_PARTS = 8

Template = Float[np.ndarray, "samples columns"]


class Course(NamedTuple):
    """A named course in time, up to its size."""

    name: str
    #: Draws what it adds to each sample for unit sizes, shape (samples, columns): of the many that
    #: are looked at in a long record there is no room for all.
    draw: Callable[[], Template]
    #: How many sizes it has.
    sizes: int
    #: Its parameters beside the sizes, in samples.
    shape: dict[str, float]
    #: Among how many it is the best: unrelated ones, or those along a path of that length.
    places: float = 1.0
    length: float = 0.0

    def kept(self) -> "Course":
        """The course, drawn once for all times."""
        template = self.draw()
        return self._replace(draw=lambda: template)


class Edge(NamedTuple):
    """What a filter makes of a step of one: its height so many samples after it."""

    lag: Float[np.ndarray, " points"]
    height: Float[np.ndarray, " points"]


class Sized(NamedTuple):
    """Courses with their sizes, jointly, and the noise that is left."""

    sizes: Float[np.ndarray, " columns"]
    model: Model
    data: Data
    #: Minus twice the log-likelihood, up to a constant that all models of the record share.
    cost: float


def cost(model: Model, data: Data) -> float:
    """Minus twice the log-likelihood of the ordinates, up to a constant of the record."""
    mean = mean_density(model, data)
    return float(
        np.sum(
            2 * np.asarray(data.bins.shape) * (np.log(mean) + np.asarray(data.bins.density) / mean)
        )
    )


def ordinate_variance(
    spectrum: Ordinates, model: Model, data: Data
) -> Float[np.ndarray, " ordinates"]:
    """The model's expectation of each ordinate."""
    mean = mean_density(model, data)[data.bins.used]
    frequency = data.bins.frequency[data.bins.used]
    # Between the middles of bins in the logarithm; a power law is a straight line there.
    found = np.exp(np.interp(np.log(spectrum.frequency), np.log(frequency), np.log(mean)))
    return found * fallen(model, data, spectrum.frequency, float(frequency[0]))


def fallen(
    model: Model, data: Data, frequency: Float[np.ndarray, " _"], first: float
) -> Float[np.ndarray, " _"]:
    """What a high-pass filter leaves below the first bin, as a part of what it leaves there."""
    part = np.ones(frequency.size)
    if model.kinds.shaping == HIGH_PASS:
        four, below = model.theta[SHAPE], frequency < first
        at = points(np.append(frequency[below], first))
        gain = np.asarray(shaped(HIGH_PASS, four, at, data.samples)[2])
        part[below] = gain[:-1] / gain[-1]
    return part


def size_up(products: Products, summing: Summing, model: Model, data: Data) -> Sized:
    """Sizes of courses with the powers of the noise fitted again beside them.

    `products` are those of the courses, by `summing`.
    """
    sizes = np.zeros(products.plain.shape[1] - 1)
    bins = summing.bins
    # The edges may be others than before.
    data = data._replace(bins=bins)
    for _ in range(_ROUNDS):
        gram = _weighted(products, model, data)
        sizes = _inverse(gram[1:, 1:]) @ gram[1:, 0]
        density = np.array(bins.density)
        density[bins.used] = products.less(sizes) / summing.count
        data = data._replace(bins=bins._replace(density=density))
        model = rescaled(model, data)
    return Sized(sizes, model, data, cost(model, data))


def covariance_of(
    products: Products, model: Model, data: Data
) -> Float[np.ndarray, "columns columns"]:
    """Of the sizes of courses, by generalised least squares on the ordinates that are seen."""
    return _inverse(_weighted(products, model, data)[1:, 1:])


def _weighted(products: Products, model: Model, data: Data) -> Float[np.ndarray, "columns columns"]:
    return np.tensordot(1 / mean_density(model, data)[data.bins.used], products.weighted, 1)


def _inverse(information: Float[np.ndarray, "columns columns"]):
    unit = np.sqrt(np.maximum(np.diag(information), 1e-300))
    inverse = np.linalg.pinv(information / unit / unit[:, None], rcond=1e-10, hermitian=True)
    return inverse / unit / unit[:, None]


def knowledge(products: Products, columns: slice, model: Model, data: Data) -> float:
    """How well the noise is known where a course is: as from so many ordinates of one variance.

    Its `columns` are counted among those of all courses. Of n such ordinates the log of the
    variance would scatter with 2/n; the fit's own scatter comes from its Fisher information.
    """
    slopes, covariance = log_scatter(model.theta, model.kinds, data)
    used = data.bins.used
    scatter = np.einsum("bi,ij,bj->b", slopes[used], covariance, slopes[used])
    energy = np.einsum("bii->bi", products.weighted)[:, 1:][:, columns].sum(axis=1)
    weight = energy / mean_density(model, data)[used]
    return float(2 * weight.sum() / max(weight @ scatter, 1e-300))


def oscillation(
    frequency: float,
    time: Float[np.ndarray, " samples"],
    ahead: Float[np.ndarray, " samples"] | float = 0.0,
) -> Course:
    """Cosine and sine at a frequency [cycles per sample]; half a cycle has no sine.

    `ahead` is by how much its phase is ahead of that at a `time` of zero [rad].
    """

    def draw() -> Template:
        angle = 2 * np.pi * frequency * time + ahead
        both = (np.cos, np.sin) if frequency < 0.5 else (np.cos,)
        return np.column_stack([each(angle) for each in both])

    return Course("sinusoid", draw, 1 if frequency == 0.5 else 2, {"frequency": frequency})


def warm_up(constant: float, samples: int) -> Course:
    """An exponential that begins with the recording, its constant in samples."""

    def draw() -> Template:
        return np.exp(-np.arange(samples)[:, None] / constant)

    return Course("warm_up", draw, 1, {"time_constant": constant})


def step(time: int | float, samples: int, edge: Edge | None = None) -> Course:
    """One from sample `time` on, or what a filter makes of that."""

    def draw() -> Template:
        return risen(np.arange(samples) - time, edge)[:, None]

    return Course("step", draw, 1, {"time": float(time)})


def risen(
    after: Float[np.ndarray, " samples"] | Int[np.ndarray, " samples"], edge: Edge | None
) -> Float[np.ndarray, " samples"]:
    """The height of a step so many samples after it."""
    return (after >= 0).astype(float) if edge is None else np.interp(after, *edge)


def late(felt: Float[np.ndarray, " samples"], lag: float) -> Course:
    """A temperature and its square, which a sensor feels through one thermal mass, `lag` behind.

    A thermometer that is behind the sensor has a `lag` below zero: how fast it rises, over a part
    of that time, tells what it will show.
    """

    def behind(mass: float) -> Float[np.ndarray, " samples"]:
        share = 1 - np.exp(-1 / mass)
        return lfilter([share], [1, share - 1], felt - felt[0]) + felt[0]

    def draw() -> Template:
        later = felt
        if lag > 1:
            later = behind(lag)
        elif lag < -_PARTS:
            later = felt + _PARTS * (felt - behind(-lag / _PARTS))
        later = later - later.mean()
        return np.column_stack([later, later**2])

    return Course("temperature", draw, 2, {"lag": lag})


def polish(
    course: Course,
    remake: Callable[[float], Course],
    value: float,
    spread: float,
    gain: Callable[[Course], float],
) -> Course:
    """The best of a course's neighbours, halving the step a few times."""
    best_gain, best_course = gain(course), course
    for _ in range(7):
        for candidate in (value - spread, value + spread):
            if candidate <= 0:
                continue
            tried = remake(candidate)
            reached = gain(tried)
            if reached > best_gain:
                best_gain, best_course, value = reached, tried, candidate
        spread /= 2
    # As many were looked at to find it.
    return best_course._replace(places=course.places, length=course.length)


def moved_by(course: Course, pieces: tuple[tuple[int, int], ...], slow_top: float) -> Moved:
    """The amplitudes of the ordinates of each column of a course.

    Of one that is slow up to a frequency of `slow_top` [cycles per sample]: beyond there is nothing
    of it that is not lost in the noise.
    """
    slow = course.name in _SLOW or course.shape.get("frequency", 0.5) < slow_top / _FAR
    top = slow_top if slow else 0.5
    return np.column_stack(
        [
            amplitudes(tuple(column[start:stop] for start, stop in pieces), top)
            for column in course.draw().T
        ]
    )
