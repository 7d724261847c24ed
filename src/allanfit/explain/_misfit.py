"""Whether the better model fits, wherever it says what the spectrum is."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..identify._goodness import goodness_of_fit
from ._state import Investigation
from .spectrum._climb import deviances
from .spectrum._density import expected_density
from .spectrum._narrow import narrow_noises
from .spectrum._structure import EACH, active

#: A better model as unlikely as this is wrong in something.
MISFIT = 1e-4
# Standard deviations of its frequency to either side within which a line wanders.
_BAND = 4.0


class Goodness(NamedTuple):
    """How well a model fits."""

    p_value: float
    #: Whether bands were left out in which a line wanders.
    apart: bool = False


def goodness(state: Investigation, courses: int) -> Goodness:
    """The p-value of the structure beside so many columns of courses in time.

    A line that wanders is told by its power and by how far it goes. How often it is where, the
    model has as a normal distribution, which it need not be: to and fro as a sine it dwells where
    it turns. If that is all that does not fit, the p-value is of what is beside such a band.
    """
    fitted = int(active(state.model.kinds, state.data.terms).sum()) + courses
    shape = np.asarray(state.data.bins.shape)
    whole = _p_value(state.model.deviance, shape, fitted)
    frequency = state.data.bins.frequency
    lines = [
        one
        for one in narrow_noises(state.model, float(state.data.samples))
        if (one.name == "drifting_line" or one.place in state.wandering)
        and one.place not in state.disowned_noises
    ]
    if whole >= MISFIT or not lines:
        return Goodness(whole)
    near = np.any([np.abs(frequency - one.middle) < _BAND * one.width for one in lines], axis=0)
    beside = np.where(near, 0.0, shape)
    mean = expected_density(state.model.theta, state.model.kinds, state.data)
    data = state.data._replace(bins=state.data.bins._replace(shape=beside))
    rest = _p_value(float(deviances(mean[None], data)[0]), beside, fitted - EACH * len(lines))
    return Goodness(whole) if rest < MISFIT else Goodness(rest, apart=True)


def _p_value(deviance: float, shape: Float[np.ndarray, " bins"], fitted: int) -> float:
    return float(
        goodness_of_fit(jnp.asarray(deviance), jnp.asarray(shape), jnp.asarray(float(fitted)))
    )
