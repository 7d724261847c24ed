"""All effects beyond the five terms, by the name that explain's JSON gives them."""

import dataclasses
import math
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
# Parameters that are arrays, by their number of axes.
_AXES = {"times": 1, "heights": 1, "strengths": 1, "intervals": 2}
# What is so or not, as 1 or 0.
_FLAGS = {"regular", "digital", "averaged", "running_mean", "windowed", "high_pass", "flat"}
_SIGNED = {"amplitude", "height", "sensitivity", "quadratic", "coefficient", "low", "high"}
# Of the others, those that have bounds other than zero.
_RANGES = {
    "sigma": (0.0, math.inf),
    "density": (0.0, math.inf),
    "limit": (0.0, math.inf),
    "fraction": (0.0, 0.99),
    "upper_share": (0.01, 0.99),
    "repeat": (1.0, math.inf),
    "order": (math.nextafter(0.5, 1), math.inf),
    "exponent": (0.0, 3.0),
    "droop": (-math.inf, 1.0),
}
_RANGE_WORDS = {
    "sigma": "zero or more",
    "density": "zero or more",
    "limit": "zero or more",
    "fraction": "between 0 and 0.99",
    "upper_share": "between 0.01 and 0.99",
    "repeat": "1 or more",
    "order": "above 0.5",
    "exponent": "between 0 and 3",
    "droop": "1 or less",
}


def effect_from(name: str, parameters: Mapping[str, Any]) -> AbstractEffect:
    """The effect of a name with its parameters, numbers or lists in the units of the class.

    **Raises:** `ValueError` for a name or a parameter that is not known, one that is missing, and
    a value of the wrong shape or out of range.

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
    return effect(**values)


def field_of(parameter: Parameter) -> str:
    """The field of an effect that holds a parameter."""
    return parameter.field or parameter.name


def _array(name: str, parameter: Parameter, value: Any):
    axes = _AXES.get(parameter.name, 0)
    if parameter.name in _FLAGS:
        if value not in (0, 1):
            raise ValueError(f"{parameter.name} of {name} must be 0 or 1; got {value!r}")
        return bool(value)
    try:
        # YAML takes 5e-3, without a point, for text, which NumPy reads.
        array = jnp.asarray(np.asarray(value, float))
    except (TypeError, ValueError):
        array = jnp.asarray(jnp.nan)
    if axes == 1:
        array = jnp.atleast_1d(array)
    # Steps may have one amplitude each.
    shapes = {axes, 1} if (name, parameter.name) == ("step", "amplitude") else {axes}
    pairs = axes < 2 or (array.ndim == 2 and array.shape[1] == 2)
    if not (array.ndim in shapes and pairs and bool(jnp.all(jnp.isfinite(array)))):
        kind = ("a number", "numbers, one a time", "pairs of start and end")[axes]
        raise ValueError(f"{parameter.name} of {name} must be {kind}; got {value!r}")
    if axes == 0 and parameter.name not in _SIGNED:
        low, high = _RANGES.get(parameter.name, (math.ulp(0.0), math.inf))
        if not low <= float(array) <= high:
            allowed = _RANGE_WORDS.get(parameter.name, "above zero")
            raise ValueError(f"{parameter.name} of {name} must be {allowed}; got {value!r}")
    return array
