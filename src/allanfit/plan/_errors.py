"""How well a record of a given length tells each coefficient."""

from collections.abc import Mapping
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np

from ..curves import unit_scale
from ..identify._likelihood import fisher_information
from ..physics import SYMBOLS, Sampling
from ._record import CountedDesign, counted_design

# No record has more bins than this; a fixed number spares compiling for each length.
_BINS = 256
_fisher_information = jax.jit(fisher_information)


def relative_errors(
    coefficients: Mapping[str, float], rate_hz: float, samples: int, sampling: Sampling
) -> dict[str, float]:
    """Standard error over value of each coefficient that is not zero.

    Those of Q, N, B and K come from the Fisher information of the fit's own likelihood, the ramp
    being projected out; that of R is the ramp's by generalised least squares, the noise given.
    """
    layout = counted_design(samples, sampling)
    values = np.array([coefficients.get(symbol, 0.0) for symbol in SYMBOLS]) / _scale(rate_hz)
    power, ramp = values[:-1] ** 2, values[-1]
    errors = np.sqrt(_power_variances(layout, power))
    # A square's relative error is twice that of its root.
    found = {
        symbol: float(error / power[i] / 2)
        for i, (symbol, error) in enumerate(zip(SYMBOLS[:-1], errors, strict=True))
        if power[i]
    }
    if ramp:
        weight = layout.ramp**2 / (layout.ramp_variance @ power)
        found["R"] = float(weight.sum() ** -0.5 / ramp)
    return found


def _power_variances(layout: CountedDesign, power: np.ndarray) -> np.ndarray:
    """Mean square error of the squares of Q, N, B and K; infinite for an absent Q.

    The fit seeks flicker and walk in every record, and what it allows for them when they are
    absent costs their neighbours as much as if they had to be estimated. Quantization noise it
    takes for absent unless the record says otherwise, which costs next to nothing.
    """
    information = _information(layout, power)
    unknown = np.flatnonzero((power > 0) | np.array([False, True, True, True]))
    variances = np.full(len(power), np.inf)
    variances[unknown] = _inverse_diagonal(information[np.ix_(unknown, unknown)])
    return variances


def _information(layout: CountedDesign, power: np.ndarray) -> np.ndarray:
    padding = _BINS - len(layout.ordinates)
    # Bins of no ordinates know nothing, whatever is expected of them.
    expected = np.pad(layout.density, ((0, padding), (0, 0)), constant_values=1.0)
    shape = np.pad(layout.ordinates / 2, (0, padding))
    with jax.enable_x64(True):
        arrays = (jnp.asarray(array) for array in (power, expected, shape))
        return np.asarray(_fisher_information(*arrays))


@lru_cache(maxsize=64)
def _scale(rate_hz: float) -> np.ndarray:
    with jax.enable_x64(True):
        return np.asarray(unit_scale(1 / rate_hz))


def _inverse_diagonal(information: np.ndarray) -> np.ndarray:
    """Of the inverse; terms differ by twenty decades, so in units that make them alike."""
    unit = np.sqrt(np.diag(information))
    return np.diag(np.linalg.inv(information / unit / unit[:, None])) / unit**2
