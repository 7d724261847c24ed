"""A sinusoid."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, AbstractMean, Parameter
from ._term import Sampling

# Turns that are counted together.
_AT_ONCE = 1024


class Sinusoid(AbstractMean):
    """A sin(2 pi f t + phase), of constant amplitude A [u] and frequency f [Hz].

    Above the Nyquist frequency it appears at its alias. The phase [rad] is no parameter of the
    effect: left out, it is zero in `mean` and random in `apply`.
    """

    amplitude: Float[Array, ""]
    frequency: Float[Array, ""]
    phase: Float[Array, ""] | None = None
    name: ClassVar[str] = "sinusoid"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u", range=SIGNED),
        Parameter("frequency", "Hz"),
    )
    what: ClassVar[str] = "a sinusoid"
    origin: ClassVar[str] = "mains, a fan, a pump or a clock near by"

    def mean(self, time: Float[Array, " samples"]) -> Float[Array, " samples"]:
        """A sin(2 pi f t + phase) [u]."""
        phase = 0.0 if self.phase is None else self.phase
        return self.amplitude * jnp.sin(2 * jnp.pi * self.frequency * time + phase)

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples and sinusoid added."""
        phase = self.phase
        if phase is None:
            phase = jax.random.uniform(key, maxval=2 * jnp.pi)
        turned = 2 * jnp.pi * _turns(self.frequency * dt, samples.shape[0])
        return samples + self.amplitude * jnp.sin(turned + phase)


def _turns(step: Float[Array, ""], samples: int) -> Float[Array, " samples"]:
    """Multiples of a part of a turn, less all whole ones.

    In float32 the turns of a long record have no digits left for the part.
    """
    many, few = jnp.divmod(jnp.arange(samples), _AT_ONCE)
    # Times a power of two nothing is rounded.
    return (many * (_AT_ONCE * step % 1) + few * step) % 1
