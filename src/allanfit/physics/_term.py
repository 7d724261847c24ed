"""The base of every noise term, and the conventions that all of them keep.

Conventions, stated once for the whole package:

- A channel carries the unit u (rad/s, m/s^2, ...), sampled every dt seconds.
- Spectral densities are one-sided, in u^2/Hz: the variance is their integral from 0 to the
  Nyquist frequency. IEEE Std 952 and 1293 print two-sided densities, half of these.
- The Allan variance at cluster size n (tau = n dt) is half the mean square of the difference
  between two adjacent means of n samples.
- Bias instability B is the coefficient of IEEE Std 952: a one-sided density B^2/(pi f), whose
  Allan deviation is flat at sqrt(2 ln 2/pi) B = 0.664 B.
- `sampling` says how the sensor makes one sample out of a continuous signal: "point" takes its
  value at an instant, "averaged" takes its mean over the interval. Textbook formulas hold for
  every n only when the sensor averages.

Each term's expectations are those of the sampled process, aliases and all, so that they are
right at small n and up to the Nyquist frequency.
"""

import abc
from typing import Literal, NamedTuple, get_args

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

Sampling = Literal["point", "averaged"]


def check_sampling(sampling: str) -> None:
    """Raise `ValueError` for a word that is none."""
    if sampling not in get_args(Sampling):
        raise ValueError(f"sampling must be 'point' or 'averaged'; got {sampling!r}")


class Names(NamedTuple):
    """What the field calls a term on each kind of channel."""

    gyro: str
    accelerometer: str
    other: str


class AbstractNoiseTerm(eqx.Module):
    """One physical source of noise: what it does to both curves, and how to draw it.

    The coefficient enters every expectation as its square.
    """

    coefficient: eqx.AbstractVar[Float[Array, ""]]
    symbol: eqx.AbstractClassVar[str]
    names: eqx.AbstractClassVar[Names]
    #: The coefficient's unit is u s^seconds_power, spelled for people by `coefficient_unit`.
    seconds_power: eqx.AbstractClassVar[float]

    @abc.abstractmethod
    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """One-sided spectral density of the samples [u^2/Hz] at `frequency` [Hz]."""

    @abc.abstractmethod
    def allan_variance(
        self, cluster_size: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """Expected Allan variance [u^2] of clusters of `cluster_size` samples."""

    @abc.abstractmethod
    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Draw a realisation, exact in law up to an additive constant."""

    def low_mode_ratio(
        self, order: Float[Array, "*shape"], samples: int | Int[Array, ""]
    ) -> Float[Array, "*shape"]:
        """Expected mirror-spectrum ordinate over the density at its frequency.

        `order` counts half cycles over the record of `samples`. The mirror spectrum is unbiased
        for white noise and for a random walk; a term for which it is not says so here.
        """
        return jnp.ones_like(order)


def coefficient_unit(term: type[AbstractNoiseTerm], unit: str) -> str:
    """The unit of a term's coefficient on a channel that carries `unit`.

    >>> coefficient_unit(WhiteNoise, "rad/s"), coefficient_unit(RateRamp, "m/s^2")
    ('rad/s/sqrt(Hz)', 'm/s^3')
    """
    if term.seconds_power == 1:
        return _multiply_seconds(unit, 1)
    if term.seconds_power == -1:
        return _multiply_seconds(unit, -1)
    suffix = {0.5: "/sqrt(Hz)", 0: "", -0.5: "/sqrt(s)"}[term.seconds_power]
    return f"{unit or '1'}{suffix}" if suffix else unit


def _multiply_seconds(unit: str, power: int) -> str:
    """`unit` times s or 1/s, written as people write it: rad/s becomes rad or rad/s^2."""
    base, _, seconds = unit.partition("/s")
    if seconds not in ("", "^2", "^3") or "/s" not in unit:
        return f"{unit or '1'} s" if power == 1 else f"{unit or '1'}/s"
    order = int(seconds.lstrip("^") or 1) - power
    return base if order == 0 else f"{base}/s" if order == 1 else f"{base}/s^{order}"
