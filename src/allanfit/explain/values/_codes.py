"""How much noise rounding to coarse codes adds, or hides."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import minimize_scalar
from scipy.special import ndtr

# Short enough that the mean stays where it is among the codes; so many of them are looked at.
_WINDOW, _MOST_WINDOWS = 32, 4000
# Noise as wide as this, in codes, spreads the error of a code evenly.
_WIDE = 0.9
# The narrowest and widest noise that is tried, in codes, and the places of a mean between two.
_NARROWEST, _WIDEST = 0.05, 1.2
_PLACES = np.linspace(-0.5, 0.5, 65)
# Codes on either side of a window's own, and the share of samples that lie anywhere.
_CODES = np.arange(-6, 7)
_ANYWHERE = 1e-6
# The logarithm of the width is known as well as this, or the width is not known.
_KNOWN = 0.1
# Narrower noise, in codes, is not told from noise whose mean is elsewhere.
_TOLD = 0.2
# Neighbours whose correlation is less are apart.
_ALIKE = 0.25
_STEP = 0.01
_ROUNDS = 200
# The means of windows are not quite what they are taken for: so much of what that changes.
_ROUGH = 0.05


class Rounding(NamedTuple):
    """What codes do to white noise."""

    #: Variance of what is logged less that of the noise [u^2]; negative where codes hide it.
    added: float
    #: Standard deviation of that, as far as it is known.
    deviation: float
    #: Variance of what is logged.
    logged: float
    #: Variance that noise may have and hide within a code [u^2].
    hidden: float = 0.0


UNROUNDED = Rounding(0.0, 0.0, 0.0)


def rounding(values: Float[np.ndarray, " usable"], width: float, sigma: float) -> Rounding:
    """What codes of this `width` [u] do to noise of about this `sigma` [u] about slow changes.

    The error of a code is uniform, and adds a twelfth, where noise or slow changes spread the
    values over several codes. Fainter noise makes errors that depend on it: with the mean on a
    code they hide it, with the mean between two codes they add up to a quarter. How often each
    code occurs in short windows tells how wide the noise is, whatever the mean of each is.
    """
    usual = Rounding(width**2 / 12, 0.0, sigma**2)
    if sigma > _WIDE * width or values.size < _WINDOW:
        return usual
    counts, often = np.unique(_counts(values, width), axis=0, return_counts=True)

    def negative(log_width: float) -> float:
        likelihood, height = _likelihood(log_width, counts)
        return -float(often @ (np.log(likelihood @ _means(likelihood, often)) + height))

    found: Any = minimize_scalar(negative, bounds=(np.log(_NARROWEST), np.log(_WIDEST)))
    top: float = found.x
    low, middle, high = (negative(top + step) for step in (-_STEP, 0.0, _STEP))
    curvature = (low - 2 * middle + high) / _STEP**2
    unknown = curvature < _KNOWN**-2
    if (unknown or np.exp(top) < _TOLD) and _are_apart(values):
        # What is spread evenly over a code is seen no more than what stays in its middle.
        return usual._replace(hidden=width**2 / 12)
    if unknown:
        return usual
    scatter = curvature**-0.5
    (added, logged), (less, _), (more, _) = (
        _spread(top + step, counts, often) for step in (0.0, -scatter, scatter)
    )
    deviation = float(np.hypot((more - less) / 2, _ROUGH * (added - 1 / 12)))
    return Rounding(*(width**2 * each for each in (added, deviation, logged)))


def _counts(
    values: Float[np.ndarray, " usable"], width: float
) -> Float[np.ndarray, "windows codes"]:
    """How often each code occurs in windows, about the middle one of each."""
    windows = values[: values.size // _WINDOW * _WINDOW].reshape(-1, _WINDOW)
    windows = windows[:: -(-len(windows) // _MOST_WINDOWS)]
    middle = np.sort(windows, axis=1)[:, _WINDOW // 2, None]
    codes = np.rint((windows - middle) / width)
    return np.stack([np.count_nonzero(codes == code, axis=1) for code in _CODES], axis=1).astype(
        float
    )


def _are_apart(values: Float[np.ndarray, " usable"]) -> bool:
    """Whether values are elsewhere by the next sample, as white noise is and filtered noise is not.

    Of slow noise that goes from code to code more is seen than of what hides within one.
    """
    windows = values[: values.size // _WINDOW * _WINDOW].reshape(-1, _WINDOW)
    left = windows - windows.mean(axis=1, keepdims=True)
    return bool(np.sum(left[:, 1:] * left[:, :-1]) < _ALIKE * np.sum(left**2))


def _chances(log_width: float) -> Float[np.ndarray, "places codes"]:
    """Of each code, with the mean at each place between two codes."""
    above = ndtr(
        (_CODES[:, None] + np.array([-0.5, 0.5]) - _PLACES[:, None, None]) / np.exp(log_width)
    )
    return np.diff(above, axis=-1)[..., 0] * (1 - _ANYWHERE) + _ANYWHERE


def _likelihood(
    log_width: float, counts: Float[np.ndarray, "windows codes"]
) -> tuple[Float[np.ndarray, "windows places"], Float[np.ndarray, " windows"]]:
    """Of each place, up to a factor whose logarithm is second."""
    likelihood = counts @ np.log(_chances(log_width)).T
    height = likelihood.max(axis=1)
    return np.exp(likelihood - height[:, None]), height


def _means(
    likelihood: Float[np.ndarray, "windows places"], often: Int[np.ndarray, " windows"]
) -> Float[np.ndarray, " places"]:
    """How often the mean is at each place, by expectation and maximization."""
    share = np.full(_PLACES.size, 1 / _PLACES.size)
    for _ in range(_ROUNDS):
        share = share * ((often / (likelihood @ share)) @ likelihood) / often.sum()
    return share


def _spread(
    log_width: float,
    counts: Float[np.ndarray, "windows codes"],
    often: Int[np.ndarray, " windows"],
) -> tuple[float, float]:
    """Variance that codes add to noise of a width, and variance with it, where the means are."""
    chances = _chances(log_width)
    chances = chances / chances.sum(axis=1, keepdims=True)
    means = _means(_likelihood(log_width, counts)[0], often)
    logged = float(means @ (chances @ _CODES**2 - (chances @ _CODES) ** 2))
    return logged - float(np.exp(2 * log_width)), logged
