"""Samples that are lost without a trace."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import FRACTION, AbstractEffect, Parameter
from ._term import Sampling


class DroppedSamples(AbstractEffect):
    """A `fraction` of samples is missing, and the others follow one another as if none were.

    White noise does not change; a line broadens, and everything slow is faster by
    1/(1 - fraction).
    """

    fraction: Float[Array, ""]
    name: ClassVar[str] = "dropped_samples"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("fraction", "", range=FRACTION),)
    what: ClassVar[str] = "samples that are missing"
    origin: ClassVar[str] = "a bus or a logger that cannot keep up"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The samples that are left, closed up; their mirror image fills the end.

        Give more samples than are needed, `enough(needed)`, and cut: no mirror image remains.
        """
        count = samples.shape[0]
        kept = jax.random.uniform(key, samples.shape) >= self.fraction
        closed = samples[jnp.argsort(~kept, stable=True)]
        last = kept.sum() - 1
        index = jnp.arange(count)
        return closed[jnp.clip(jnp.where(index <= last, index, 2 * last - index), 0)]

    def enough(self, samples: int) -> int:
        """How many samples leave `samples`, but for one record in a billion."""
        fraction = float(self.fraction)
        expected = samples / (1 - fraction)
        return round(expected + 6 * (expected * fraction) ** 0.5 / (1 - fraction)) + 2
