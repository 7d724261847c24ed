"""A line whose frequency wanders."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, AbstractAddedNoise, Parameter
from ._term import Sampling

# Correlation time of the wandering times the width: slow enough for the line to be as wide as
# the frequency wanders.
_SLOWNESS = 10.0


class DriftingLine(AbstractAddedNoise):
    """A sinusoid of an amplitude, whose frequency wanders about its mean by an rms width.

    Its power A^2/2 lies in a Gaussian of that rms about the mean frequency (a slow modulation's
    spectrum is the distribution of the frequency: Woodward's theorem). The amplitude is that of
    the samples, however the sensor makes them.
    """

    amplitude: Float[Array, ""]
    frequency: Float[Array, ""]
    width: Float[Array, ""]
    name: ClassVar[str] = "drifting_line"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "u", range=SIGNED),
        Parameter("frequency", "Hz"),
        Parameter("width", "Hz"),
    )
    scale: ClassVar[tuple[str, int]] = ("amplitude", 2)
    what: ClassVar[str] = "a line whose frequency drifts"
    origin: ClassVar[str] = "a motor, a fan or a beat of two clocks whose speed varies"

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """A^2/2 times a normal density about the mean, folded at the Nyquist frequency.

        Of the aliases the nearest two: another is a whole rate away at least.
        """
        rate, inverse = 1 / dt, 1 / self.width
        total = jnp.zeros_like(frequency)
        for image in (frequency - self.frequency, frequency + self.frequency):
            nearest = image - jnp.round(image * dt) * rate
            for apart in (nearest, nearest - jnp.copysign(rate, nearest)):
                total += jnp.exp(-jnp.square(apart * inverse) / 2)
        return self.amplitude**2 / 2 * total * (inverse / jnp.sqrt(2 * jnp.pi))

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The frequency is a slow Gauss-Markov process, the phase its integral."""
        phase_key, drive_key = jax.random.split(key)
        rate = dt * self.width / _SLOWNESS
        drive = jax.random.normal(drive_key, (samples,))
        drive = drive.at[1:].multiply(jnp.sqrt(-jnp.expm1(-2 * rate)))

        def step(carry, noise):
            drift, phase = carry
            drift = jnp.exp(-rate) * drift + noise
            # Whole cycles are dropped: single precision would lose the phase of a long record.
            after = (phase + dt * (self.frequency + self.width * drift)) % 1.0
            return (drift, after), phase

        start = (jnp.zeros((), drive.dtype), jax.random.uniform(phase_key, (), drive.dtype))
        return self.amplitude * jnp.sin(2 * jnp.pi * jax.lax.scan(step, start, drive)[1])
