"""The base of every effect beyond the five terms: what explain may name and simulate may add.

An effect is one file here: its parameters with their units, what it does to samples, what it does
to the spectrum if it has one, and two sentences for people. `_catalogue.py` lists them all.
"""

import abc
import math
from typing import Literal, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from ._term import Sampling


class Range(NamedTuple):
    """The values that a parameter may have, ends included."""

    low: float
    high: float
    #: After "must be".
    words: str


ABOVE_ZERO = Range(math.ulp(0.0), math.inf, "above zero")
ZERO_OR_MORE = Range(0.0, math.inf, "zero or more")
FRACTION = Range(0.0, 0.99, "between 0 and 0.99")
SIGNED = Range(-math.inf, math.inf, "a number")


class Parameter(NamedTuple):
    """What describes an effect: a number, what is so or not, a series, or intervals."""

    #: As in explain's JSON.
    name: str
    #: With `u` for the unit of the channel: "u", "s", "Hz", "u^2/Hz", "u/K", "u/K^2", "1/u", or ""
    #: for none.
    unit: str
    #: The field of the class that holds it, where a method has its name.
    field: str = ""
    #: Of a number alone.
    range: Range = ABOVE_ZERO
    #: "flag" is 1 or 0, and "each" a number or one a time.
    kind: Literal["number", "flag", "series", "each", "intervals"] = "number"


class AbstractEffect(eqx.Module):
    """Something that a sensor does beside Q, N, B, K and R.

    Its fields are its parameters, under the same names: scalars, times [s] of shape (n,), or
    intervals [s] of shape (n, 2). The unit of the samples is u, times and frequencies are in s
    and Hz.
    """

    #: As in explain's JSON.
    name: eqx.AbstractClassVar[str]
    parameters: eqx.AbstractClassVar[tuple[Parameter, ...]]
    #: What it is, after "the recording holds": "a sinusoid", "exponentially correlated noise".
    what: eqx.AbstractClassVar[str]
    #: Where it comes from as a rule, one clause.
    origin: eqx.AbstractClassVar[str]

    def contradiction(self) -> str:
        """Why its parameters do not go together, as the end of a sentence; "" if they do."""
        return ""

    @abc.abstractmethod
    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The samples [u] of a sensor with the effect, given those of one without."""


class AbstractAddedNoise(AbstractEffect):
    """Stationary noise beside the five terms, whose density adds to theirs."""

    #: The density is proportional to this parameter to this power.
    scale: eqx.AbstractClassVar[tuple[str, int]]

    @abc.abstractmethod
    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """One-sided spectral density of the samples [u^2/Hz] at `frequency` [Hz]."""

    @abc.abstractmethod
    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Draw a realisation [u]."""

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples and noise added."""
        return samples + self.sample(key, samples.shape[0], dt, sampling)


class AbstractFilter(AbstractEffect):
    """Something that multiplies the density of what the sensor feels.

    Its `apply` is for white noise, with the aliases that belong to it; `passed` is for noise that
    is weak beyond the Nyquist frequency.
    """

    @abc.abstractmethod
    def gain(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """|H|^2 for white noise, as sampled: aliases of what the filter passes are folded in."""

    @abc.abstractmethod
    def passed(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """|H|^2 of the filter alone."""


class AbstractMean(AbstractEffect):
    """Something deterministic, added to the samples."""

    @abc.abstractmethod
    def mean(self, time: Float[Array, " samples"]) -> Float[Array, " samples"]:
        """What it adds [u] at each `time` [s] since the first sample."""

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples and mean added."""
        return samples + self.mean(dt * jnp.arange(samples.shape[0]))
