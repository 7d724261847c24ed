"""Random telegraph noise: two levels, and switches between them at random times."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractAddedNoise, Parameter
from ._gauss_markov import GaussMarkov
from ._term import Sampling

# How finely a sample is divided to take its mean.
_PARTS = 16


class RandomTelegraph(AbstractAddedNoise):
    """Two levels `amplitude` apart about zero, each held for `dwell_time` on average.

    Its autocovariance is that of a Gauss-Markov process of sigma = amplitude/2 and T_c =
    dwell_time/2 (Machlup 1954, J. Appl. Phys. 25:341): its switches tell them apart, no spectrum.
    """

    amplitude: Float[Array, ""]
    dwell_time: Float[Array, ""]
    name: ClassVar[str] = "random_telegraph"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u"),
        Parameter("dwell_time", "s"),
    )
    scale: ClassVar[tuple[str, int]] = ("amplitude", 2)
    what: ClassVar[str] = "random jumps between two levels (telegraph noise)"
    origin: ClassVar[str] = "one trap that charges and discharges, or a bad contact"

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """That of the Gauss-Markov process of the same autocovariance [u^2/Hz]."""
        same = GaussMarkov(self.amplitude / 2, self.dwell_time / 2)
        return same.density(frequency, dt, sampling)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Levels from one instant to the next; the mean of 16 instants stands for an interval."""
        parts = 1 if sampling == "point" else _PARTS
        start_key, key = jax.random.split(key)
        # An odd number of switches between two instants.
        chance = -jnp.expm1(-2 * dt / parts / self.dwell_time) / 2
        switched = jax.random.uniform(key, (samples * parts,)) < chance
        start = jax.random.bernoulli(start_key).astype(int)
        level = (start + jnp.cumsum(switched)) % 2 - 0.5
        return self.amplitude * level.reshape(samples, parts).mean(axis=1)
