"""Are replicates one? How far devices differ beyond their own uncertainty.

The model is the random-effects model of meta-analysis: device i has the true value m + b_i with
b_i of standard deviation tau, and is measured with the known standard error s_i. One function
serves the test, the estimate and the interval, so that they cannot disagree: the generalised
statistic Q(tau^2) = sum (y_i - m)^2 / (tau^2 + s_i^2), which is chi-square with n - 1 degrees of
freedom at the true tau. Q(0) is Cochran's test; where Q is n - 1 is the estimate of Paule and
Mandel (J. Res. NBS 87, 377, 1982); where it is a quantile is an end of the interval (Viechtbauer,
Statistics in Medicine 26, 37, 2007).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import root_scalar
from scipy.stats import chi2, t

Values = Float[np.ndarray, " devices"]

#: Below any spread of interest in a logarithm, and kept from zero, at which Q has a pole.
SMALLEST_ERROR = 1e-9


@dataclass(frozen=True)
class Spread:
    """How values of many devices scatter, in the unit of the values (logarithms, as a rule)."""

    devices: int
    middle: float
    """The mean over devices, each weighted by what is known of it."""
    middle_interval: tuple[float, float]
    """95 %, for the mean of all devices that might have been made."""
    tau: float
    """Standard deviation between devices."""
    tau_interval: tuple[float, float]
    """95 %."""
    p_value: float
    """Of a scatter as large as this one if the devices were equal."""
    share: float
    """I^2: of the scatter that is seen, the share that is between devices."""


class Centre(NamedTuple):
    """The middle, the standard deviation between devices, and the variance of the middle."""

    middle: float
    tau: float
    variance: float


def spread(values: Values, errors: Values) -> Spread:
    """Estimate the middle and the spread of two devices or more.

    **Arguments:** the `values`, and their standard `errors`, both of shape (devices,).
    """
    freedom = len(values) - 1
    errors = np.maximum(errors, SMALLEST_ERROR)
    found = centre(values, errors)
    reach = float(t.ppf(0.975, freedom) * np.sqrt(found.variance))
    low, high = (_at(float(chi2.ppf(q, freedom)), values, errors) for q in (0.975, 0.025))
    return Spread(
        devices=len(values),
        middle=found.middle,
        middle_interval=(found.middle - reach, found.middle + reach),
        tau=found.tau,
        tau_interval=(float(np.sqrt(low)), float(np.sqrt(high))),
        p_value=float(chi2.sf(_weighed(0.0, values, errors)[2], freedom)),
        share=found.tau**2 / (found.tau**2 + _typical_variance(errors)),
    )


def centre(values: Values, errors: Values) -> Centre:
    """Where devices are and how far apart, without intervals."""
    errors = np.maximum(errors, SMALLEST_ERROR)
    variance = _at(len(values) - 1.0, values, errors)
    middle, weight, _ = _weighed(variance, values, errors)
    return Centre(middle, float(np.sqrt(variance)), 1 / weight)


def _weighed(variance: float, values: Values, errors: Values) -> tuple[float, float, float]:
    """The weighted mean, the sum of the weights, and Q."""
    weights = 1 / (variance + errors**2)
    total = float(weights.sum())
    middle = float(weights @ values) / total
    return middle, total, float(weights @ (values - middle) ** 2)


def _at(target: float, values: Values, errors: Values) -> float:
    """The variance between devices at which Q has this value; zero if it is smaller everywhere."""

    def excess(variance: float) -> float:
        return _weighed(variance, values, errors)[2] - target

    if excess(0.0) <= 0:
        return 0.0
    # Q is at most the sum of squares over the variance; a little more, for rounding.
    largest = 1.01 * float(np.sum((values - values.mean()) ** 2)) / target
    return float(root_scalar(excess, bracket=(0.0, largest), xtol=1e-9 * largest).root)


def _typical_variance(errors: Values) -> float:
    """What all errors squared are worth in one (Higgins and Thompson, 2002, equation 9)."""
    weights = 1 / errors**2
    total = weights.sum()
    return float((len(errors) - 1) * total / (total**2 - np.sum(weights**2)))
