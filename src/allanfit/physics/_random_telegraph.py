"""Random telegraph noise: two levels, and switches between them at random times."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, AbstractAddedNoise, Parameter, Range
from ._gauss_markov import GaussMarkov
from ._term import Sampling

# How finely a sample is divided to take its mean.
_PARTS = 16


class RandomTelegraph(AbstractAddedNoise):
    """Two levels `amplitude` apart about zero, held for `dwell_time` on average.

    With an `upper_share` p the upper level is held for a share p of the time, 2 p dwell_time at
    once on average, and the lower one for 2 (1 - p) dwell_time; without, both are alike. The
    autocovariance is that of a Gauss-Markov process of sigma = amplitude sqrt(p (1 - p)) and T_c =
    2 p (1 - p) dwell_time (Machlup 1954, J. Appl. Phys. 25:341): its switches tell them apart, no
    spectrum.
    """

    amplitude: Float[Array, ""]
    dwell_time: Float[Array, ""]
    upper_share: Float[Array, ""] | None = None
    name: ClassVar[str] = "random_telegraph"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u", range=SIGNED),
        Parameter("dwell_time", "s"),
        Parameter("upper_share", "", range=Range(0.01, 0.99, "between 0.01 and 0.99")),
    )
    scale: ClassVar[tuple[str, int]] = ("amplitude", 2)
    what: ClassVar[str] = "random jumps between two levels (telegraph noise)"
    origin: ClassVar[str] = "one trap that charges and discharges, or a bad contact"

    @property
    def share(self) -> Float[Array, ""]:
        """Of the time, on the upper level."""
        return jnp.asarray(0.5 if self.upper_share is None else self.upper_share)

    @property
    def alike(self) -> GaussMarkov:
        """The Gauss-Markov process of the same autocovariance."""
        spread = self.share * (1 - self.share)
        return GaussMarkov(self.amplitude * jnp.sqrt(spread), 2 * spread * self.dwell_time)

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """That of the Gauss-Markov process of the same autocovariance [u^2/Hz]."""
        return self.alike.density(frequency, dt, sampling)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Levels from one instant to the next; the mean of 16 instants stands for an interval."""
        parts = 1 if sampling == "point" else _PARTS
        forget_key, key = jax.random.split(key)
        # As if the level were drawn again now and then, whatever it was before.
        instants = jnp.arange(samples * parts)
        kept = jnp.exp(-dt / parts / self.alike.correlation_time)
        drawn = jax.random.uniform(forget_key, instants.shape) > kept
        last = jax.lax.cummax(jnp.where(drawn, instants, 0))
        level = jax.random.bernoulli(key, self.share, instants.shape)[last] - self.share
        return self.amplitude * level.reshape(samples, parts).mean(axis=1)
