"""Exponentially correlated noise, the first-order Gauss-Markov process."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import ZERO_OR_MORE, AbstractAddedNoise, Parameter
from ._term import Sampling


class GaussMarkov(AbstractAddedNoise):
    """Autocovariance sigma^2 exp(-|t|/T_c): S(f) = 4 sigma^2 T_c/(1 + (2 pi f T_c)^2).

    IEEE Std 952, annex C, correlated noise; here with the aliases of its sampled form. Its Allan
    deviation peaks at 0.62 sigma near tau = 1.9 T_c.
    """

    sigma: Float[Array, ""]
    correlation_time: Float[Array, ""]
    name: ClassVar[str] = "gauss_markov"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("sigma", "u", range=ZERO_OR_MORE),
        Parameter("correlation_time", "s"),
    )
    scale: ClassVar[tuple[str, int]] = ("sigma", 2)
    what: ClassVar[str] = "exponentially correlated noise (a Gauss-Markov process)"
    origin: ClassVar[str] = "trapped charge, a control loop or a package that relaxes"

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """2 dt sigma^2 (1 - phi^2)/(1 - 2 phi cos(2 pi f dt) + phi^2), phi = exp(-dt/T_c)."""
        rate = dt / self.correlation_time
        decay, gap = jnp.exp(-rate), -jnp.expm1(-rate)
        sine = jnp.sin(jnp.pi * frequency * dt) ** 2
        denominator = gap**2 + 4 * decay * sine
        point = -jnp.expm1(-2 * rate) / denominator
        if sampling == "point":
            return 2 * dt * self.sigma**2 * point
        # The mean over the interval has the autocovariance of the point at every lag but zero,
        # times (2 sinh(rate/2)/rate)^2, so that the rest of its density is white. That form
        # overflows at large rates, and the other one cancels at small ones.
        small, large = jnp.minimum(rate, 1.0), jnp.maximum(rate, 1.0)
        shaped = (2 * jnp.sinh(small / 2) / small) ** 2 * point
        slow = shaped - 2 * small * _sine_excess(small)
        gap = -jnp.expm1(-large)
        fast = 2 * (large - gap) + 2 * gap**2 * (gap - 2 * sine) / denominator
        return 2 * dt * self.sigma**2 * jnp.where(rate < 1, slow, fast / large**2)

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The exact recursion, begun in its stationary state, or means over its intervals.

        Between two values the process is a bridge: the mean of the interval is the mean of both,
        times tanh(rate/2)/(rate/2), plus an independent normal.
        """
        rate = dt / self.correlation_time
        drive_key, bridge_key = jax.random.split(key)
        drive = jax.random.normal(drive_key, (samples + 1,))
        drive = drive.at[1:].multiply(jnp.sqrt(-jnp.expm1(-2 * rate)))

        def step(state, noise):
            state = jnp.exp(-rate) * state + noise
            return state, state

        point = jax.lax.scan(step, jnp.zeros((), drive.dtype), drive)[1]
        if sampling == "point":
            return self.sigma * point[1:]
        mean = jnp.tanh(rate / 2) / rate * (point[1:] + point[:-1])
        bridge = jax.random.normal(bridge_key, (samples,))
        return self.sigma * (mean + jnp.sqrt(_bridge_variance(rate)) * bridge)


def _sine_excess(rate: Float[Array, ""]) -> Float[Array, ""]:
    """(sinh(rate) - rate)/rate^3 for rates up to 1, by its series."""
    square = rate**2
    return (1 + square / 20 * (1 + square / 42 * (1 + square / 72 * (1 + square / 110)))) / 6


def _bridge_variance(rate: Float[Array, ""]) -> Float[Array, ""]:
    """(2 rate - 4 tanh(rate/2))/rate^2: of an interval's mean whose two ends are known."""
    small, large = jnp.minimum(rate, 0.3), jnp.maximum(rate, 0.3)
    square = small**2
    # Good to 1e-7, which is more than a draw can show.
    series = small / 6 * (1 - square / 10 * (1 - 17 / 168 * square * (1 - 31 / 306 * square)))
    return jnp.where(rate < 0.3, series, (2 * large - 4 * jnp.tanh(large / 2)) / large**2)
