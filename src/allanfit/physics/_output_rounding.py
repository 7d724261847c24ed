"""The rounding of the output to whole codes."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractEffect, Parameter
from ._term import Sampling


class OutputRounding(AbstractEffect):
    """Samples are whole multiples of `lsb` [u].

    Where the noise is half an lsb or more, the error is white of variance lsb^2/12, which adds
    lsb^2 dt/12 to N^2 (Widrow 1956, IRE Trans. CT-3:266). It is not the quantization noise Q.
    """

    lsb: Float[Array, ""]
    name: ClassVar[str] = "output_rounding"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("lsb", "u"),)
    what: ClassVar[str] = "rounding of the output"
    origin: ClassVar[str] = "a converter or a number format with few codes"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The nearest multiples."""
        return self.lsb * jnp.round(samples / self.lsb)
