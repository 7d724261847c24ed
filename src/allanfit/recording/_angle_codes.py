"""Whether samples are differences of an angle that was rounded to wide codes."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from scipy.optimize import brentq
from scipy.special import ndtr

from ..physics import AngleCodes

# Windows over which the mean rate is known to a small part of the noise.
_WINDOW, _FEWEST = 256, 8
# Codes passed in a sample, of which all else has more.
_FEW = 1.5
# Parts of the record's time, each with its mean rate.
_PARTS = 5
# In codes: how near values are to whole ones, and the moves for which anything is to be known; of
# a mean rate beyond so many of them the number of codes passed says nothing of the noise.
_WHOLE, _LEAST, _MOST, _SWIFT = 0.05, 0.1, 0.6, 1.5
# How well correlations agree, beyond so many standard deviations.
_ROUGH, _DEVIATIONS = 0.04, 4.0


def angle_codes(values: Float64[np.ndarray, " usable"], width: float) -> AngleCodes | None:
    """How an angle moves among its codes, if `values` are its differences in codes of this `width`.

    None for all else, and for an angle that goes through whole codes between samples, whose errors
    are white. With the angle anywhere in a code, it passes as many codes as it moves on average,
    whatever their width: that tells its white noise. Rounding then makes neighbours go back where
    rounding of the rate would leave them as they are.
    """
    if values.size < _FEWEST * _WINDOW or width <= 0:
        return None
    if np.mean(np.abs(values[: _FEWEST * _WINDOW])) > _FEW * width:
        return None
    exact = values / width
    codes = np.rint(exact)
    if np.mean(np.abs(exact - codes) > _WHOLE) > 1 / values.size:
        return None
    windows = codes[: codes.size // _WINDOW * _WINDOW].reshape(-1, _WINDOW)
    means, passed = windows.mean(axis=1), float(np.mean(np.abs(windows)))

    def too_few(move: float) -> float:
        """Codes passed with such a move less those that were."""
        ratio = means / move
        normal = np.exp(-(ratio**2) / 2) * np.sqrt(2 / np.pi)
        return float(np.mean(move * normal + means * (2 * ndtr(ratio) - 1))) - passed

    if too_few(_LEAST) > 0 or too_few(_MOST) < 0:
        return None
    move: Any = brentq(too_few, _LEAST, _MOST)
    if np.sqrt(np.mean(means**2)) > _SWIFT * move:
        return None
    rates = np.quantile(means, (np.arange(_PARTS) + 0.5) / _PARTS)
    found = AngleCodes(round(float(move), 6), tuple(np.round(rates, 6).tolist()))
    return found if _agrees(windows - means[:, None], found) else None


def _agrees(moved: Float64[np.ndarray, "windows samples"], codes: AngleCodes) -> bool:
    """Whether variance and correlations of the differences are those of an angle's codes."""
    error = codes.correlation(np.arange(4)) / 12
    expected = 2 * error[:3] - error[1:] - error[[1, 0, 1]]
    expected[0] += codes.move**2
    near = np.array([np.mean(moved[:, lag:] * moved[:, : _WINDOW - lag]) for lag in range(3)])
    allowed = _ROUGH + _DEVIATIONS / np.sqrt(moved.size)
    return bool(np.all(np.abs(near - expected) < allowed * expected[0]))
