"""The terms of a fit as parts of a state-space model: one function a term."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from ..physics import BiasInstability
from ._effect_parts import effect_parts, gauss_markov
from ._gauss_markov import Approximation, fit_relaxations
from ._read import FitChannel
from ._state_space import Part, State

#: Default band of averaging times: from this many samples to the length of the recording.
FIRST_SAMPLES = 4


class Realised(NamedTuple):
    """The parts of one channel, and sentences that say how each term and effect entered."""

    parts: list[Part]
    how: dict[str, str]
    flicker: Approximation | None
    """With variances in the unit of the channel squared."""
    effects: list[str]


class _Term(NamedTuple):
    parts: list[Part]
    how: str
    flicker: Approximation | None = None


def default_band(channel: FitChannel) -> tuple[float, float]:
    """Averaging times [s] in which flicker is realised unless told otherwise."""
    return FIRST_SAMPLES * channel.dt, channel.duration_s


def realise(
    channel: FitChannel, band_s: tuple[float, float] | None = None, *, walk_limit: bool = False
) -> Realised:
    """State-space parts for each term of a fit, and for the effects that have states.

    **Arguments:** `band_s`: averaging times in which flicker must be right [s]. `walk_limit`:
    drive a bias whose random walk is not resolved by its 95 % upper limit instead of not at all.

    **Raises:** `ExportError` for a band in which flicker cannot be realised.
    """
    band_s = band_s or default_band(channel)
    found = {
        "Q": _quantization(channel),
        "N": _white(channel),
        "B": _flicker(channel, band_s),
        "K": _walk(channel, walk_limit),
        "R": _ramp(channel),
    }
    parts, effects = effect_parts(channel)
    return Realised(
        [*(part for term in found.values() for part in term.parts), *parts],
        {symbol: term.how for symbol, term in found.items()},
        found["B"].flicker,
        effects,
    )


def _quantization(channel: FitChannel) -> _Term:
    term = channel.coefficients["Q"]
    if not term.resolved:
        return _Term([], "not resolved; left out")
    return _Term(
        [],
        "not in these matrices: it is white noise of the integrated signal; a filter that "
        f"measures the integral of the channel adds Q^2 = {term.value**2:.6g} ({term.unit})^2 to "
        "the variance of each such measurement, and a filter of rate samples sees it as "
        "differences of that noise divided by dt",
    )


def _white(channel: FitChannel) -> _Term:
    density = channel.coefficients["N"].value ** 2
    how = "Rc: two-sided density N^2 in continuous time; Rd: variance N^2/dt of a sample"
    return _Term([Part("N", Rc=density)], how)


def _flicker(channel: FitChannel, band_s: tuple[float, float]) -> _Term:
    term = channel.coefficients["B"]
    if not term.resolved:
        return _Term([], "not resolved; left out")
    unit = _unit_flicker(channel.dt, band_s, channel.sampling)
    scaled = Approximation(
        tuple(each._replace(variance=each.variance * term.value**2) for each in unit.relaxations),
        unit.band_s,
        unit.worst_error,
    )
    parts = [
        gauss_markov("B", f"flicker_{index}", channel.unit, each.time_s, each.variance)
        for index, each in enumerate(scaled.relaxations, 1)
    ]
    how = (
        f"{len(parts)} first-order Gauss-Markov states; their Allan deviation is that of flicker "
        f"within {scaled.worst_error:.1%} from {band_s[0]:.4g} s to {band_s[1]:.4g} s"
    )
    return _Term(parts, how, scaled)


def _walk(channel: FitChannel, limit: bool) -> _Term:
    """The walking bias; it is there without a walk too, since every sensor has an offset."""
    term = channel.coefficients["K"]
    one = np.ones((1, 1))
    if term.resolved:
        value, how = term.value, "a bias driven by white noise of two-sided density K^2"
    elif limit and term.upper_limit_95 is not None:
        value = term.upper_limit_95
        how = "not resolved; the bias is driven at the 95 % upper limit of K"
    else:
        value, how = 0.0, "not resolved; the bias is a constant, with no drive"
    state = State("bias", channel.unit, None)
    return _Term([Part("K", (state,), 0 * one, one, value**2 * one, one)], how)


def _ramp(channel: FitChannel) -> _Term:
    term = channel.coefficients["R"]
    if not term.resolved:
        return _Term([], "not resolved; left out")
    states = (
        State("ramp", channel.unit, 0.0),
        State("ramp_rate", term.unit, term.value**2),
    )
    slope = np.array([[0.0, 1.0], [0.0, 0.0]])
    part = Part("R", states, slope, np.zeros((2, 0)), np.zeros((0, 0)), np.array([[1.0, 0.0]]))
    return _Term([part], "a constant rate of variance R^2 (its sign is not known), integrated")


@lru_cache(maxsize=64)
def _unit_flicker(dt: float, band_s: tuple[float, float], sampling: str) -> Approximation:
    """Relaxations for B = 1, shared by all channels of one rate and length."""
    return fit_relaxations(flicker_variance(dt, sampling), dt, band_s)


def flicker_variance(dt: float, sampling: str) -> Callable[[np.ndarray], np.ndarray]:
    """Allan variance of flicker with B = 1 at an array of cluster sizes."""
    term = BiasInstability(jnp.asarray(1.0))

    def target(sizes: np.ndarray) -> np.ndarray:
        rule = "averaged" if sampling == "averaged" else "point"
        return np.asarray(term.allan_variance(jnp.asarray(sizes), dt, rule), np.float64)

    return target
