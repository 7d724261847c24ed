"""Noise whose strength changes all the time, and not between a quiet and a loud one.

The log of the mean square in windows is taken for a random walk, or for a smoother course whose
slope is one. The cosine transform makes either independent (as the precision of a walk between two
ends has cosines for eigenvectors: Strang 1999, SIAM Review 41:135), so that likelihood, mean and
draws are those of single normal numbers. Noise of two levels, or a few, is told from it by the
likelihood of either, with all courses of it counted by their own probability.
"""

import itertools
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.fft import dct, idct

# Variances of the slowest cosine over that of noise, and powers of frequency with which the others
# fall: those of a walk, and of a course whose slope is one.
_SLOWEST = np.geomspace(1e-2, 1e8, 81)
_POWERS = (2, 4)
# Chances that a window is the last one of a level.
_CHANGES = np.geomspace(1e-4, 0.3, 12)
# What a course must be more likely by than levels [nats].
_MARGIN = 8.0
_DRAWS = 400

Windows = Float[np.ndarray, " windows"]
Labels = Int[np.ndarray, " windows"]


class Varying(NamedTuple):
    """The log of a mean square that changes all the time."""

    course: Windows
    draws: Float[np.ndarray, "draws windows"]
    #: Whether it is smoother than a walk.
    smooth: bool

    @property
    def reach(self) -> Float[np.ndarray, " draws"]:
        """How far apart its extremes are, in draws."""
        reach = np.ptp(self.draws, axis=1)
        if not self.smooth:
            return reach
        # Draws are rough about a course that is none, and so is that: the extremes of either are
        # beyond those of the true one by about as much.
        beyond = max(float(np.mean(reach) - np.ptp(self.course)), 0.0)
        return np.maximum(reach - 2 * beyond, 0.0)


def varying(power: Windows, weight: float, labels: Labels, seed: int) -> Varying | None:
    """The course of the log of the mean square, and draws of it, unless levels say as much.

    `power` is the mean square in windows, as certain as that of `weight` independent normal
    samples. `labels` say which level each is of.
    """
    # Of a chi-square variate with many degrees of freedom: mean and variance of the logarithm.
    logarithm, variance = np.log(power) + 1 / weight, 2 / weight
    cosines = np.asarray(dct(logarithm, norm="ortho"))
    order = np.sin(np.pi * np.arange(1, power.size) / (2 * power.size))
    best, prior, smooth = -np.inf, np.zeros(0), False
    for slowest, falling in itertools.product(_SLOWEST, _POWERS):
        tried = slowest * variance * (order[0] / order) ** falling
        total = tried + variance
        # The mean is free.
        likelihood = -(np.sum(np.log(total) + cosines[1:] ** 2 / total) + np.log(variance)) / 2
        if likelihood > best:
            best, prior, smooth = float(likelihood), tried, falling > min(_POWERS)
    if best < _in_levels(logarithm, variance, labels) + _MARGIN:
        return None
    part = np.append(1.0, prior / (prior + variance))
    noise = np.random.default_rng(seed).standard_normal((_DRAWS, power.size))
    drawn = part * cosines + np.sqrt(part * variance) * noise
    course = np.asarray(idct(part * cosines, norm="ortho"))
    return Varying(course, np.asarray(idct(drawn, norm="ortho", axis=1)), smooth)


def _in_levels(logarithm: Windows, variance: float, labels: Labels) -> float:
    """The log-likelihood of levels with a chance of changes, whichever is best."""
    levels = [logarithm[labels == each].mean() for each in range(int(labels.max()) + 1)]
    others = max(len(levels) - 1, 1)
    emitted = -(np.log(variance) + (logarithm[:, None] - np.array(levels)) ** 2 / variance) / 2
    # Scaled in each window, or they would vanish.
    top = emitted.max(axis=1)
    emitted = np.exp(emitted - top[:, None])
    chance = np.full((_CHANGES.size, len(levels)), 1 / len(levels))
    total = np.full(_CHANGES.size, top.sum())
    leave = _CHANGES[:, None] if len(levels) > 1 else 0 * _CHANGES[:, None]
    for each in emitted:
        chance = ((1 - leave) * chance + leave * (1 - chance) / others) * each
        size = chance.sum(axis=1, keepdims=True)
        total += np.log(size[:, 0])
        chance /= size
    return float(total.max())
