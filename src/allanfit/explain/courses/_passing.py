"""What the filter of a model makes of steps.

|H|^2 is told by the noise. The phase is not: it may be the least that a filter with such a gain can
have, as that of feedback is, or none but a delay, as that of symmetric filters is.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.fft import irfft, rfft
from scipy.signal import fftconvolve

from .._state import Investigation
from ..spectrum._structure import SHAPE, sieve
from ._course import Edge, risen

#: Points a sample of the response of a filter in front of the converter.
FINE = 8
# Those of a whole response, and samples to either side that matter of one.
_LENGTH, _REACH = 2**14, 1024
# Below such a part of the power there is nothing to tell a response by.
_STOPPED = 1e-60
# So near to its end is as good as there.
_NEAR = 0.02


class Passing(NamedTuple):
    """A filter: |H| at evenly spaced frequencies from zero on, and what it makes of a step."""

    frequency: Float[np.ndarray, " frequencies"]
    gain: Float[np.ndarray, " frequencies"]
    #: With the least phase, and with none.
    least: Edge
    none: Edge

    def gain_at(self, frequency: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """|H| at frequencies in cycles per sample."""
        return np.interp(frequency, self.frequency, self.gain)


def passing(state: Investigation) -> Passing | None:
    """The model's filter, if it has one."""
    kinds = state.model.kinds
    if not kinds.filtering:
        return None
    four = jnp.asarray(state.model.theta[SHAPE])
    found = sieve(kinds.shaping or "", four, state.data.samples)
    fine = 1 if found.after_converter else FINE
    frequency = np.arange(_LENGTH // 2 + 1) * (fine / _LENGTH)
    passed = np.asarray(found.passed(jnp.asarray(frequency), 1.0))
    gain = np.sqrt(np.maximum(passed, _STOPPED))
    least, none = _least_phase(gain), np.roll(np.asarray(irfft(gain)), _LENGTH // 2)
    # Samples that are averages are those of what passes the filter.
    averaged = (state.data.averaging or found.averaged) and not found.after_converter
    if averaged:
        gain = gain * np.abs(np.sinc(frequency))
    over = fine if averaged else 1
    edges = _response(least, 0, fine, over), _response(none, _LENGTH // 2, fine, over)
    return Passing(frequency, gain, *edges)


def passed(
    level: Float[np.ndarray, " samples"], edge: Edge, late: float = 0.0
) -> Float[np.ndarray, " samples"]:
    """What a filter makes of a course in steps, so many samples `late`."""
    impulse = np.diff(risen(np.arange(-_REACH - 1, _REACH + 1) - late, edge))
    return fftconvolve(np.pad(level, _REACH, mode="edge"), impulse, mode="valid")


def half_and_rise(edge: Edge) -> tuple[int, int]:
    """Samples until half of the height is there, and from nearly none of it to nearly all."""
    begun = np.flatnonzero(np.abs(edge.height) > _NEAR)[0]
    done = np.flatnonzero(np.abs(edge.height - 1) > _NEAR)[-1]
    half = np.argmax(edge.height >= 0.5)
    return round(float(edge.lag[half])), round(float(edge.lag[done] - edge.lag[begun]))


def _least_phase(gain: Float[np.ndarray, " frequencies"]) -> Float[np.ndarray, " points"]:
    """The impulse response with such a gain that is soonest over.

    Its cepstrum is zero before time zero: Oppenheim and Schafer, Discrete-Time Signal Processing.
    """
    cepstrum = np.asarray(irfft(np.log(gain)))
    cepstrum[1 : _LENGTH // 2] *= 2
    cepstrum[_LENGTH // 2 + 1 :] = 0.0
    return np.asarray(irfft(np.exp(np.asarray(rfft(cepstrum)))))


def _response(impulse: Float[np.ndarray, " points"], zero: int, fine: int, over: int) -> Edge:
    """The step response, from an impulse response with time zero at a point, `fine` a sample.

    Each value is the mean of the last `over` points.
    """
    impulse = np.convolve(impulse, np.full(over, 1 / over))[:_LENGTH] / impulse.sum()
    lag = (np.arange(-1, _LENGTH) - zero) / fine
    return Edge(lag, np.concatenate([[0.0], np.cumsum(impulse)]))
