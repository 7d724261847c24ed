"""Outliers: single samples far off."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import FRACTION, SIGNED, AbstractEffect, Parameter
from ._term import Sampling

#: Errors that are alike differ by such a part of their size (standard deviation).
UNLIKE = 0.1


class Outliers(AbstractEffect):
    """A `fraction` of samples has a normal error of rms `amplitude` on top.

    Or errors that are `alike`, as a bit that flips makes them: `amplitude` up or down, within a
    tenth of it.

    Their spectrum is white: they add fraction amplitude^2 dt to N^2, and only the distribution of
    the samples shows them.
    """

    fraction: Float[Array, ""]
    amplitude: Float[Array, ""]
    alike: bool = eqx.field(static=True, default=False)
    name: ClassVar[str] = "outliers"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("fraction", "", range=FRACTION),
        Parameter("amplitude", "u", range=SIGNED),
        Parameter("alike", "", kind="flag"),
    )
    what: ClassVar[str] = "outliers"
    origin: ClassVar[str] = "bits lost in transmission, or electric pulses"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples, some of them with an error added."""
        hit_key, size_key = jax.random.split(key)
        spread_key = jax.random.fold_in(size_key, 1)
        hit = jax.random.uniform(hit_key, samples.shape) < self.fraction
        size = jax.random.normal(size_key, samples.shape)
        if self.alike:
            size = jnp.sign(size) + UNLIKE * jax.random.normal(spread_key, samples.shape)
        return samples + hit * self.amplitude * size
