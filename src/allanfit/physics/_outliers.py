"""Outliers: single samples far off."""

from typing import ClassVar

import jax
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import FRACTION, SIGNED, AbstractEffect, Parameter
from ._term import Sampling


class Outliers(AbstractEffect):
    """A `fraction` of samples has a normal error of rms `amplitude` on top.

    Their spectrum is white: they add fraction amplitude^2 dt to N^2, and only the distribution of
    the samples shows them.
    """

    fraction: Float[Array, ""]
    amplitude: Float[Array, ""]
    name: ClassVar[str] = "outliers"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("fraction", "", range=FRACTION),
        Parameter("amplitude", "u", range=SIGNED),
    )
    what: ClassVar[str] = "outliers"
    origin: ClassVar[str] = "bits lost in transmission, or electric pulses"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples, some of them with an error added."""
        hit_key, size_key = jax.random.split(key)
        hit = jax.random.uniform(hit_key, samples.shape) < self.fraction
        return samples + hit * self.amplitude * jax.random.normal(size_key, samples.shape)
