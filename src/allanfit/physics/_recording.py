"""A recording of the five terms with effects: which comes first in a sensor."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._bump import Bump
from ._disturbance import Disturbance
from ._drifting_line import DriftingLine
from ._dropped_samples import DroppedSamples
from ._effect import AbstractAddedNoise, AbstractEffect, AbstractMean
from ._filtering import filtered
from ._low_pass import LowPass
from ._model import NoiseModel
from ._outliers import Outliers
from ._output_rounding import OutputRounding
from ._sample_hold import SampleHold
from ._saturation import Saturation
from ._temperature import Temperature
from ._term import Sampling
from ._variance_modulation import VarianceModulation
from ._vibration_rectification import VibrationRectification

# What the sensor feels, then what it makes of it, then what becomes of the number it sends.
_FELT = (
    AbstractAddedNoise,
    AbstractMean,
    Temperature,
    VibrationRectification,
    Outliers,
    DroppedSamples,
)
_SENT = (Saturation, OutputRounding, SampleHold)
_PLACED = (LowPass, VarianceModulation, Bump, Disturbance, *_FELT, *_SENT)
# Beside those of the terms.
_KEYS = 1000


def draw_recording(
    key: PRNGKeyArray,
    model: NoiseModel,
    effects: Sequence[AbstractEffect],
    samples: int,
    dt: float,
    sampling: Sampling,
    bias: float = 0.0,
) -> Float[Array, " samples"]:
    """Draw the terms of a model and apply effects, in the order of a sensor.

    That order is low-pass filters, modulation of white and quantization noise, bumps, added noises,
    means, temperature, vibration rectification, outliers, lost samples, the bias, the end of the
    range, rounding and holding, whatever the order of `effects`. A filter in front of the converter
    passes white noise with its aliases and slow noise without any; quantization noise is made
    behind it. One behind the converter passes all of them, and one that comes last added noises
    too, but for lines that wander. No filter changes the ramp.

    **Arguments:** coefficients and parameters in a unit u and s, `dt` [s] between samples, and the
    `bias` [u].

    **Returns:** samples [u], shape (samples,).
    """
    length = samples
    for effect in effects:
        if not isinstance(effect, _PLACED):
            raise TypeError(f"{effect.name} has no place in the order of a sensor")
        if isinstance(effect, DroppedSamples):
            length = effect.enough(length)
    keys = [jax.random.fold_in(key, _KEYS + index) for index in range(len(effects))]
    terms = {
        term.symbol: term.sample(jax.random.fold_in(key, index), length, dt, sampling)
        for index, term in enumerate(model.terms)
    }

    def of(*kinds: type[AbstractEffect]):
        """Effects of these kinds, kind by kind, with their keys."""
        return (
            (effect, each)
            for kind in kinds
            for effect, each in zip(effects, keys, strict=True)
            if isinstance(effect, kind)
        )

    for effect, each in of(LowPass):
        assert isinstance(effect, LowPass)
        before = {"Q", "N", "B", "K"} if effect.after_converter else {"N", "B", "K"}
        for symbol in terms.keys() & before:
            terms[symbol] = (
                effect.apply(each, terms[symbol], dt, sampling)
                if symbol == "N"
                else filtered(terms[symbol], lambda f, h=effect: h.passed(f, dt), dt)
            )
    # A line that wanders is as large as it is among the samples.
    sieves = [effect for effect in effects if isinstance(effect, LowPass) and effect.last]
    ramp = terms.pop("R", jnp.zeros(()))
    for effect, _ in of(VarianceModulation):
        assert isinstance(effect, VarianceModulation)
        for symbol in terms.keys() & {"Q", "N"}:
            terms[symbol] = effect.strength(length, dt) * terms[symbol]
    drawn = sum(terms.values(), jnp.zeros(length))
    for effect, each in of(Bump):
        drawn = effect.apply(each, drawn, dt, sampling)
    drawn += ramp
    for effect, each in of(*_FELT):
        if isinstance(effect, AbstractAddedNoise) and not isinstance(effect, DriftingLine):
            noise = effect.sample(each, length, dt, sampling)
            for sieve in sieves:
                noise = filtered(noise, lambda f, h=sieve: h.passed(f, dt), dt)
            drawn += noise
        else:
            drawn = effect.apply(each, drawn, dt, sampling)
    drawn += bias
    for effect, each in of(*_SENT):
        drawn = effect.apply(each, drawn, dt, sampling)
    return drawn[:samples]
