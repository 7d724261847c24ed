"""A sum of first-order Gauss-Markov processes with a wanted Allan variance.

A state-space filter has no finite model of flicker noise. Over a bounded band of averaging times
a few relaxations do: their variances and relaxation times are fitted here.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from ._errors import ExportError

#: Largest error of the Allan deviation within the band, as a fraction.
ALLOWED_ERROR = 0.05
_MOST_STATES = 24
_POINTS_PER_DECADE = 16
# Exponents of the residuals, one after the other: the last is close to the largest error alone.
_EXPONENTS = (1, 3, 9)
# The higher powers make the largest error at most a few times smaller.
_HOPELESS = 4


class Relaxation(NamedTuple):
    """One stationary process with autocovariance variance exp(-|t|/time_s)."""

    time_s: float
    variance: float
    """In the square of the channel's unit."""


@dataclass(frozen=True)
class Approximation:
    """Relaxations that stand for a term within a band of averaging times."""

    relaxations: tuple[Relaxation, ...]
    band_s: tuple[float, float]
    worst_error: float
    """Largest error of the Allan deviation within the band, as a fraction of it."""


def allan_variance(cluster_size: np.ndarray, dt: float, time_s: np.ndarray) -> np.ndarray:
    """Allan variance of samples of Gauss-Markov processes of variance 1.

    With phi = exp(-dt/time_s) and n samples a cluster, from the autocovariance phi^|k|:
    (n (1 - phi^2) - 3 phi + 4 phi^(n+1) - phi^(2n+1))/(n (1 - phi))^2. The numerator cancels to
    third order where the record hardly relaxes, and there its power series takes over.

    **Arguments:** `cluster_size` of shape (sizes,); `dt` [s]; `time_s` of shape (processes,).
    **Returns** the variances, shape (sizes, processes).
    """
    n, step = np.broadcast_arrays(np.asarray(cluster_size, np.float64)[:, None], dt / time_s)
    numerator = n * -np.expm1(-2 * step) - 3 * np.exp(-step)
    numerator += 4 * np.exp(-(n + 1) * step) - np.exp(-(2 * n + 1) * step)
    small = (2 * n + 1) * step < 0.3
    numerator[small] = _series(n[small], step[small])
    return numerator / (n * np.expm1(-step)) ** 2


def _series(n: np.ndarray, step: np.ndarray) -> np.ndarray:
    """The numerator of the Allan variance for (2 n + 1) step < 0.3, to 4e-16 of itself."""
    total = np.zeros_like(n)
    for order in range(3, 15):
        bracket = 4 * (n + 1) ** order - (2 * n + 1) ** order - n * 2.0**order - 3
        total += (-step) ** order / math.factorial(order) * bracket
    return total


def fit_relaxations(
    target: Callable[[np.ndarray], np.ndarray],
    dt: float,
    band_s: tuple[float, float],
    allowed_error: float = ALLOWED_ERROR,
) -> Approximation:
    """The fewest relaxations whose Allan deviation keeps to a target within a band.

    Least squares on the logarithm of the Allan variance, over relaxation times and variances,
    with residuals raised to higher powers in turn until the largest error decides.

    **Arguments:**

    - `target`: Allan variance [u^2] at an array of cluster sizes.
    - `dt`: sampling interval [s].
    - `band_s`: shortest and longest averaging time [s].
    - `allowed_error`: of the Allan deviation, as a fraction.

    **Raises:** `ExportError` for an empty band, or one that 24 relaxations cannot fill.
    """
    low, high = band_s
    if not (dt <= low < high < math.inf):
        raise ExportError(
            f"The band must run from the sampling interval, {dt:g} s, or more, to a longer time; "
            f"got {low:g} s to {high:g} s."
        )
    sizes = np.geomspace(low, high, 2 + math.ceil(_POINTS_PER_DECADE * math.log10(high / low))) / dt
    wanted = target(sizes)
    for states in range(1, _MOST_STATES + 1):
        relaxations, error = _fit(sizes, dt, wanted, states, allowed_error)
        if error <= allowed_error:
            return Approximation(relaxations, band_s, error)
    raise ExportError(
        f"{_MOST_STATES} relaxations do not keep within {allowed_error:.0%} from {low:g} s to "
        f"{high:g} s; give a narrower band."
    )


def _fit(
    sizes: np.ndarray, dt: float, wanted: np.ndarray, states: int, allowed_error: float
) -> tuple[tuple[Relaxation, ...], float]:
    """`states` relaxations and their largest error of the Allan deviation."""
    edges = np.geomspace(sizes[0] * dt, sizes[-1] * dt, states + 1)
    # A relaxation peaks at 1.89 times its time, with 0.38 of its variance.
    times = np.sqrt(edges[1:] * edges[:-1]) / 1.89
    variances = np.full(states, np.median(wanted) / 0.7)
    parameters = np.log(np.concatenate([times, variances]))

    for exponent in _EXPONENTS:
        objective = _Objective(sizes, dt, wanted, exponent, parameters)
        found = least_squares(
            objective.residuals,
            parameters,
            objective.jacobian,  # pyright: ignore[reportArgumentType]  (a callable is allowed)
            max_nfev=100,
        )
        parameters = found.x
        times, variances = np.exp(parameters.reshape(2, states))
        error = float(np.abs(np.expm1(_log_error(sizes, dt, wanted, times, variances))).max())
        if error > _HOPELESS * allowed_error:
            break
    order = np.argsort(times)
    return tuple(Relaxation(float(times[i]), float(variances[i])) for i in order), error


def _log_error(
    sizes: np.ndarray, dt: float, wanted: np.ndarray, times: np.ndarray, variances: np.ndarray
) -> np.ndarray:
    """Logarithm of the Allan deviation over the wanted one."""
    return np.log(allan_variance(sizes, dt, times) @ variances / wanted) / 2


class _Objective:
    """Powers of the errors, relative to the largest at the start, and their derivatives."""

    def __init__(
        self, sizes: np.ndarray, dt: float, wanted: np.ndarray, exponent: int, start: np.ndarray
    ) -> None:
        self.sizes, self.dt, self.wanted, self.exponent = sizes, dt, wanted, exponent
        self.scale = 1.0
        self.scale = float(np.abs(self._error(start)).max())

    def _error(self, parameters: np.ndarray) -> np.ndarray:
        times, variances = np.exp(parameters.reshape(2, -1))
        return _log_error(self.sizes, self.dt, self.wanted, times, variances) / self.scale

    def residuals(self, parameters: np.ndarray) -> np.ndarray:
        return self._error(parameters) ** self.exponent

    def jacobian(self, parameters: np.ndarray) -> np.ndarray:
        """Exact in the variances, central differences in the logarithms of the times."""
        times, variances = np.exp(parameters.reshape(2, -1))
        parts = allan_variance(self.sizes, self.dt, times) * variances
        later = allan_variance(self.sizes, self.dt, times * math.exp(1e-4)) * variances
        earlier = allan_variance(self.sizes, self.dt, times * math.exp(-1e-4)) * variances
        by_parameter = np.hstack([(later - earlier) / 2e-4, parts])
        by_parameter /= 2 * self.scale * parts.sum(axis=1, keepdims=True)
        outer = self.exponent * self._error(parameters) ** (self.exponent - 1)
        return outer[:, None] * by_parameter
