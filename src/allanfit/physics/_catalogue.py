"""All effects beyond the five terms, by the name that explain's JSON gives them."""

import dataclasses
import reprlib
from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np

from ._bump import Bump
from ._disturbance import Disturbance
from ._drifting_line import DriftingLine
from ._dropped_samples import DroppedSamples
from ._effect import AbstractEffect, Parameter
from ._gauss_markov import GaussMarkov
from ._low_pass import LowPass
from ._outliers import Outliers
from ._output_rounding import OutputRounding
from ._power_law import PowerLaw
from ._random_telegraph import RandomTelegraph
from ._resonance import Resonance
from ._sample_hold import SampleHold
from ._saturation import Saturation
from ._sinusoid import Sinusoid
from ._step import Step
from ._temperature import Temperature
from ._variance_modulation import VarianceModulation
from ._vibration_rectification import VibrationRectification
from ._warm_up import WarmUp

#: Classes of effects by name.
EFFECTS: dict[str, type[AbstractEffect]] = {
    effect.name: effect
    for effect in (
        GaussMarkov,
        Sinusoid,
        DriftingLine,
        Resonance,
        LowPass,
        PowerLaw,
        RandomTelegraph,
        Temperature,
        WarmUp,
        Step,
        Outliers,
        OutputRounding,
        SampleHold,
        DroppedSamples,
        Saturation,
        VarianceModulation,
        VibrationRectification,
        Disturbance,
        # What has no name among them.
        Bump,
    )
}
_AXES = {"number": {0}, "series": {0, 1}, "each": {0, 1}, "intervals": {2}}
_WORDS = {
    "number": "a number",
    "series": "numbers, one a time",
    "each": "a number, or one a time",
    "intervals": "pairs of start and end",
}


def effect_from(name: str, parameters: Mapping[str, Any]) -> AbstractEffect:
    """The effect of a name with its parameters, numbers or lists in the units of the class.

    **Raises:** `ValueError` for a name or a parameter that is not known, one that is missing, a
    value of the wrong shape or out of range, and values that contradict each other.

    >>> effect_from("warm_up", {"amplitude": 0.1, "time_constant": 600}).name
    'warm_up'
    """
    effect = EFFECTS.get(name)
    if effect is None:
        raise ValueError(
            f"effect {reprlib.repr(name)} is not known; known are {', '.join(EFFECTS)}"
        )
    fields = {field_of(parameter): parameter for parameter in effect.parameters}
    known = {parameter.name for parameter in effect.parameters}
    unknown = sorted(set(parameters) - known)
    if unknown:
        raise ValueError(
            f"{name} has no parameter {reprlib.repr(unknown[0])}; it has {', '.join(sorted(known))}"
        )
    values = {}
    for field in dataclasses.fields(effect):
        parameter = fields.get(field.name)
        if parameter is not None and parameter.name in parameters:
            values[field.name] = _array(name, parameter, parameters[parameter.name])
        elif parameter is not None and field.default is dataclasses.MISSING:
            raise ValueError(f"{name} lacks its parameter {parameter.name!r}")
    made = effect(**values)
    if why := made.contradiction():
        raise ValueError(f"{name} {why}")
    return made


def field_of(parameter: Parameter) -> str:
    """The field of an effect that holds a parameter."""
    return parameter.field or parameter.name


def _array(name: str, parameter: Parameter, value: Any):
    what = f"{parameter.name} of {name} must be"
    if parameter.kind == "flag":
        if value not in (0, 1):
            raise ValueError(f"{what} 0 or 1; got {value!r}")
        return bool(value)
    try:
        # YAML takes 5e-3, without a point, for text, which NumPy reads.
        array = jnp.asarray(np.asarray(value, float))
    except (TypeError, ValueError):
        array = jnp.asarray(jnp.nan)
    pairs = parameter.kind != "intervals" or array.shape[1:] == (2,)
    if not (array.ndim in _AXES[parameter.kind] and pairs and bool(jnp.all(jnp.isfinite(array)))):
        raise ValueError(f"{what} {_WORDS[parameter.kind]}; got {value!r}")
    low, high, words = parameter.range
    if parameter.kind == "number" and not low <= float(array) <= high:
        raise ValueError(f"{what} {words}; got {value!r}")
    return jnp.atleast_1d(array) if parameter.kind == "series" else array
