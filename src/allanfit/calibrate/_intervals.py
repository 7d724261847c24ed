"""Intervals about an estimate, from what is known of its error."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from scipy.optimize import brentq
from scipy.stats import norm, t

#: The levels of every interval, as the JSON spells them.
LEVELS = ("0.68", "0.95")

Intervals = dict[str, tuple[float, float] | None]


def normal_intervals(value: float, standard_error: float) -> Intervals:
    """Normal intervals, for a standard error that is stated and not estimated."""
    return _about(value, lambda level: standard_error * float(norm.ppf((1 + level) / 2)))


def student_intervals(value: float, standard_error: float, freedom: int) -> Intervals:
    """Student's t intervals, for a standard error with `freedom` degrees of freedom.

    Without a degree of freedom there is none: None at each level.
    """
    if freedom < 1:
        return dict.fromkeys(LEVELS)
    return _about(value, lambda level: standard_error * float(t.ppf((1 + level) / 2, freedom)))


def mixture_intervals(
    value: float,
    variances: Float[np.ndarray, " draws"],
    weights: Float[np.ndarray, " draws"] | None = None,
) -> Intervals:
    """Intervals of an error that is normal given its variance, of which there are weighted draws.

    The half-width h at level p solves mean(Phi(h/sqrt(variance))) = (1 + p)/2 over the draws: what
    Student's t is for draws of a scaled inverse chi-square.
    """
    deviations = np.sqrt(variances)

    def half_width(level: float) -> float:
        tail = (1 + level) / 2

        def excess(width: float) -> float:
            return float(np.average(norm.cdf(width / deviations), weights=weights)) - tail

        if not deviations.max() > 0:
            return 0.0
        # Between them, both ends included, lie the widths of all draws.
        ends = norm.ppf(tail) * np.array([deviations.min(), deviations.max()])
        return float(brentq(excess, *(ends * [1 - 1e-6, 1 + 1e-6])))  # pyright: ignore[reportArgumentType]  (it may return a pair, only if asked to)

    return _about(value, half_width)


def _about(value: float, half_width: Callable[[float], float]) -> Intervals:
    widths = {level: float(half_width(float(level))) for level in LEVELS}
    return {level: (value - width, value + width) for level, width in widths.items()}
