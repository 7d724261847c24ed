"""What is not noise but a course in time: steps, a warm-up, a slow oscillation, temperature.

A course is a mean of the ordinates' signed amplitudes, which are independent, each with the
variance that the noise gives it: its size is found by generalised least squares, the ramp taken
out of both sides. A random walk imitates every slow course, and a course that is left out makes
the walk larger; so a course counts for what the likelihood gains when the noise is fitted again.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.signal import lfilter

from ._climb import log_scatter
from ._ordinates import Ordinates, amplitudes, binned, points
from ._search import Model, best, mean_density, rescaled
from ._structure import EACH, HIGH_PASS, TERMS, Data, shaped

_ROUNDS = 3

Template = Float[np.ndarray, "samples columns"]


class Course(NamedTuple):
    """A named course in time, up to its size."""

    name: str
    #: What it adds to each sample for unit sizes, shape (samples, columns).
    template: Template
    #: Its parameters beside the sizes, in samples.
    shape: dict[str, float]
    #: Among how many it is the best: unrelated ones, or those along a path of that length.
    places: float = 1.0
    length: float = 0.0

    @property
    def sizes(self) -> int:
        """How many sizes it has."""
        return self.template.shape[1]


class Sized(NamedTuple):
    """Courses with their sizes, jointly, and the noise that is left."""

    sizes: Float[np.ndarray, " columns"]
    covariance: Float[np.ndarray, "columns columns"]
    model: Model
    data: Data
    #: The ordinates less the courses.
    left: Ordinates
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
        three, below = model.theta[TERMS : TERMS + EACH], frequency < first
        at = points(np.append(frequency[below], first))
        gain = np.asarray(shaped(HIGH_PASS, three, at, data.samples)[2])
        part[below] = gain[:-1] / gain[-1]
    return part


def size_up(
    spectrum: Ordinates,
    moved: Float[np.ndarray, "ordinates columns"],
    model: Model,
    data: Data,
    edges: Float[np.ndarray, " edges"],
    *,
    shapes_too: bool,
) -> Sized:
    """Sizes of courses with the noise fitted again beside them.

    `moved` holds the amplitudes of the ordinates of each column of the courses. Of the noise the
    powers are fitted, and with `shapes_too` in the end all else.
    """
    sizes, covariance = np.zeros(moved.shape[1]), np.zeros((moved.shape[1],) * 2)
    left = spectrum
    for _ in range(_ROUNDS):
        variance = ordinate_variance(spectrum, model, data)
        seen = spectrum.clean(spectrum.frequency)
        covariance = covariance_of(moved, variance, seen)
        weighted = np.where(seen, 1 / variance, 0.0)[:, None] * moved
        sizes = covariance @ (weighted.T @ spectrum.amplitude)
        left = spectrum.less(moved @ sizes)
        data = data._replace(bins=binned(left, edges))
        model = rescaled(model, data)
    if shapes_too:
        model = best([(model.kinds, model.theta)], data)[0]
    return Sized(sizes, covariance, model, data, left, cost(model, data))


def covariance_of(
    moved: Float[np.ndarray, "ordinates columns"],
    variance: Float[np.ndarray, " ordinates"],
    seen: Bool[np.ndarray, " ordinates"],
) -> Float[np.ndarray, "columns columns"]:
    """Of the sizes of columns, by generalised least squares on the ordinates that are seen."""
    information = (np.where(seen, 1 / variance, 0.0)[:, None] * moved).T @ moved
    unit = np.sqrt(np.maximum(np.diag(information), 1e-300))
    inverse = np.linalg.pinv(information / unit / unit[:, None], rcond=1e-10, hermitian=True)
    return inverse / unit / unit[:, None]


def knowledge(
    moved: Float[np.ndarray, "ordinates columns"],
    spectrum: Ordinates,
    model: Model,
    data: Data,
) -> float:
    """How well the noise is known where a course is: as from so many ordinates of one variance.

    Of n such ordinates the log of the variance would scatter with 2/n; the fit's own scatter comes
    from its Fisher information.
    """
    slopes, covariance = log_scatter(model.theta, model.kinds, data)
    used = data.bins.used
    scatter = np.einsum("bi,ij,bj->b", slopes, covariance, slopes)
    at = np.interp(np.log(spectrum.frequency), np.log(data.bins.frequency[used]), scatter[used])
    weight = np.sum(moved**2, axis=1) / ordinate_variance(spectrum, model, data)
    return float(2 * weight.sum() / max(weight @ at, 1e-300))


def oscillation(
    frequency: float,
    time: Float[np.ndarray, " samples"],
    ahead: Float[np.ndarray, " samples"] | float = 0.0,
) -> Course:
    """Cosine and sine at a frequency [cycles per sample]; half a cycle has no sine.

    `ahead` is by how much its phase is ahead of that at a `time` of zero [rad].
    """
    angle = 2 * np.pi * frequency * time + ahead
    if frequency == 0.5:
        return Course("sinusoid", np.cos(angle)[:, None], {"frequency": frequency})
    return Course(
        "sinusoid", np.column_stack([np.cos(angle), np.sin(angle)]), {"frequency": frequency}
    )


def warm_up(constant: float, samples: int) -> Course:
    """An exponential that begins with the recording, its constant in samples."""
    time = np.arange(samples)[:, None]
    return Course("warm_up", np.exp(-time / constant), {"time_constant": constant})


def step(time: int, samples: int) -> Course:
    """One from sample `time` on."""
    return Course(
        "step", (np.arange(samples) >= time)[:, None].astype(float), {"time": float(time)}
    )


def late(felt: Float[np.ndarray, " samples"], lag: float) -> Course:
    """A temperature and its square, which a sensor feels through one thermal mass, `lag` behind."""
    if lag > 1:
        share = 1 - np.exp(-1 / lag)
        felt = lfilter([share], [1, share - 1], felt - felt[0]) + felt[0]
    felt = felt - felt.mean()
    return Course("temperature", np.column_stack([felt, felt**2]), {"lag": lag})


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


def moved_by(
    course: Course, pieces: tuple[tuple[int, int], ...]
) -> Float[np.ndarray, "ordinates columns"]:
    """The amplitudes of the ordinates of each column of a course."""
    return np.column_stack(
        [
            amplitudes(tuple(column[start:stop] for start, stop in pieces))
            for column in course.template.T
        ]
    )
