"""A low-pass filter between the sensor and its samples."""

import math
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import scipy.special
from jax.scipy.special import log_ndtr
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import AbstractFilter, Parameter, Range
from ._equiripple import MOST_POLES, equiripple_gain
from ._filtering import filtered
from ._term import Sampling

# Aliases summed on each side; an integral is taken for the rest.
_ALIASES = 16
# Those up to here are summed at each frequency. The others are summed at few, and interpolated by
# even Chebyshev polynomials: within 1e-9 up to the tenth order, if no peak is cut at its top.
_NEAR, _EVEN = 2, np.arange(12)
_ANGLES = np.pi * (_EVEN + 0.5) / _EVEN.size
_PLACES = np.cos(_ANGLES / 2) / 2
_COSINES = np.cos(np.outer(_EVEN, _ANGLES)) * np.where(_EVEN > 0, 2, 1)[:, None] / _EVEN.size
# Newton's steps, each of which doubles the digits; the first estimate is within a fifth.
_NEWTON = 7
# For that integral where there is no series, Gauss-Legendre nodes on (0, 1).
_NODES, _WEIGHTS = (np.polynomial.legendre.leggauss(10) + np.array([[1.0], [0.0]])) / 2
# The edge of a window of one sample like Hamming's is the normal integral at u + _TAIL u^3, with u
# the distance from its middle over so many cycles a sample.
# Power is within 2 % down to a five-hundredth, and within 5 % of that of Kaiser's and Blackman's
# windows of another length.
_SPREAD, _TAIL = 0.746, 0.029
# How far from zero such edges are of a band, in these units, whose cut-off is looked up; two that
# are nearer leave what the window alone does.
_EDGES = np.linspace(0.02, 3.0, 300)
# What a window lets pass far beyond the edge, and a zero where it is.
_SIDE_LOBES = 1e-9
# A frequency [Hz] below all cut-offs, and what lies beyond is stopped.
_SLOWEST, _STEEPEST = 1e-30, float(np.exp(80))
# Aliases of means that are taken more than once: they fall with the fourth power.
_FOLDS = np.arange(-8, 9)
# A peak is no higher than the root of this.
_LOWEST = 1e-2


class LowPass(AbstractFilter):
    """|H|^2 = 1/(1 + (f/f_c)^(2 order)): Butterworth, f_c at -3 dB, of any order above 1/2.

    One that comes `last` filters added noises as well, and not the five terms alone.

    White noise through an analogue filter keeps what passes beyond the Nyquist frequency as
    aliases. The density N of a sensor with a filter is what it shows at low frequency, aliases
    included, so that the gain is one there whatever the cut-off. Those up to 8 sampling rates have
    their aliases right.

    A `digital` filter, in the sensor's processor, comes after the samples are taken: nothing folds,
    and by the bilinear transform its frequencies are those of tan(pi f dt)/(pi dt). A `recursive`
    one is digital too, and of poles without the zeros that this transform brings, as exponential
    averages are: its frequencies are those of sin(pi f dt). With `averaged` samples are averages
    over their interval, whatever is said of the terms.

    With a `droop` d it is no Butterworth filter: |H|^2 = 1/(1 + d r^2 + (1 - d) r^(2 order)) at
    r = f/f_c. Of order 2 these are all damped oscillators; above zero the gain falls early, as
    that of Bessel filters and of several single poles does, and below zero it rises to a peak.
    `recursive` and of order 2 these are all filters of two poles: exponential averages taken twice,
    equal or not, and resonators.

    A `running_mean` is digital too, of n samples and as many times as the order says:
    |H|^2 = (sin(pi n f dt)/(n sin(pi f dt)))^(2 order), with f_c at -3 dB, which is zero at some
    frequencies. One that is `oversampled` is taken of what is sampled much faster than the log, as
    in the sinc filters of sigma-delta converters: |H|^2 = sinc(n f dt)^(2 order), whose n need not
    be whole, and what passes folds.

    A `windowed` filter is digital and of finite response: a sinc under a window like Hamming's, as
    long as the order plus one samples, whose two edges are the integral of the window's transform,
    within 3 %. Hamming's window stands for others by its width; and where the cut-off is that of
    the window alone, no lower one is to be had. It decimates, and the first image of white noise
    folds.

    With a `ripple` in its pass band and an `attenuation` at least in its stop band a filter is
    elliptic, of as many poles as its order says; see `_equiripple`. Lobes of an even order never
    end: in front of the converter what is beyond 2.5 sampling rates is left to a floor.

    With a `floor` white noise comes in behind the filter, as that of a converter does: such a part
    of all white noise at zero frequency, which N is.
    """

    cutoff_frequency: Float[Array, ""]
    order: Float[Array, ""]
    droop: Float[Array, ""] | None = None
    ripple: Float[Array, ""] | None = None
    attenuation: Float[Array, ""] | None = None
    floor: Float[Array, ""] | None = None
    digital: bool = eqx.field(static=True, default=False)
    averaged: bool = eqx.field(static=True, default=False)
    recursive: bool = eqx.field(static=True, default=False)
    running_mean: bool = eqx.field(static=True, default=False)
    oversampled: bool = eqx.field(static=True, default=False)
    windowed: bool = eqx.field(static=True, default=False)
    last: bool = eqx.field(static=True, default=False)
    name: ClassVar[str] = "low_pass"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("cutoff_frequency", "Hz"),
        Parameter("order", "", range=Range(math.nextafter(0.5, 1), math.inf, "above 0.5")),
        Parameter("droop", "", range=Range(-math.inf, 1.0, "1 or less")),
        Parameter("ripple", "dB", range=Range(math.ulp(0.0), 3.0, "above zero, 3 at most")),
        Parameter("attenuation", "dB", range=Range(15.0, 200.0, "between 15 and 200")),
        Parameter("floor", "dB", range=Range(-math.inf, math.nextafter(0.0, -1), "below zero")),
        Parameter("digital", "", kind="flag"),
        Parameter("averaged", "", kind="flag"),
        Parameter("recursive", "", kind="flag"),
        Parameter("running_mean", "", kind="flag"),
        Parameter("oversampled", "", kind="flag"),
        Parameter("windowed", "", kind="flag"),
        Parameter("last", "", kind="flag"),
    )
    what: ClassVar[str] = "a low-pass filter"
    origin: ClassVar[str] = "the sensor's own digital or analogue filter"

    def contradiction(self) -> str:
        """A ripple that its filter cannot have; "" if there is none."""
        if self.ripple is None and self.attenuation is None:
            return ""
        if self.ripple is None or self.attenuation is None:
            return "has a ripple or an attenuation without the other: give both or neither"
        other = self.recursive, self.running_mean, self.oversampled, self.windowed
        if any(other) or self.droop is not None:
            return "has a ripple, so that it can be digital or averaged, and nothing else"
        if not 2 <= self.order <= MOST_POLES or self.order % 1:
            return f"has a ripple, so that its order must be a whole number from 2 to {MOST_POLES}"
        return ""

    @property
    def after_converter(self) -> bool:
        """Whether it filters samples, and with them whatever the converter added."""
        mean = self.running_mean and not self.oversampled
        return self.digital or self.recursive or mean or self.windowed

    def gain(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling = "point"
    ) -> Float[Array, "*shape"]:
        """The folded |H|^2, as a multiple of what it is at zero frequency; with its floor."""
        if self.after_converter:
            return self.raised(self.passed(frequency, dt))
        if self.oversampled:
            return self.raised(oversampled_gain(frequency * dt, self.taps(dt), self.order))
        # With zero frequency as the last of them: one evaluation compiles faster than two.
        places = jnp.append(frequency.reshape(-1), 0.0)
        folded = self.folded(places, dt, "averaged" if self.averaged else sampling)
        return self.raised((folded[:-1] / folded[-1]).reshape(frequency.shape))

    def raised(self, gain: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        """What is left of all white noise where such a part of what comes in first is."""
        if self.floor is None:
            return gain
        behind = jnp.exp(self.floor * (np.log(10) / 10))
        return behind + (1 - behind) * gain

    def folded(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling = "point"
    ) -> Float[Array, "*shape"]:
        """Sum over j of |H(f + j/dt)|^2, times sinc^2 there where samples are averages."""
        at = (frequency * dt - jnp.round(frequency * dt)).reshape(-1)
        near = self._images(at, np.arange(-_NEAR, _NEAR + 1), dt, sampling)
        if self.ripple is not None:
            # Lobes of an even order never end: what folds from further away is a floor.
            return near.reshape(frequency.shape)
        # What is further away changes little within a sampling rate, and is even: few points do.
        beyond = np.arange(_NEAR + 1, _ALIASES + 1)
        points = jnp.asarray(_PLACES, at.dtype)
        far = self._images(points, np.concatenate([-beyond, beyond]), dt, sampling)
        if sampling == "point":
            edges = _ALIASES + 0.5 + np.stack([_PLACES, -_PLACES])
            far += dt * self._beyond(jnp.asarray(edges, at.dtype) / dt).sum(axis=0)
        total = near + _even_series(jnp.asarray(_COSINES, at.dtype) @ far, at)
        return total.reshape(frequency.shape)

    def _images(
        self, at: Float[Array, " places"], aliases: np.ndarray, dt: float, sampling: Sampling
    ) -> Float[Array, " places"]:
        """Sum of |H|^2 over some aliases of frequencies in cycles per sample."""
        image = at + jnp.asarray(aliases, at.dtype)[:, None]
        passed = self.passed(image / dt, dt)
        if sampling == "averaged":
            passed *= jnp.sinc(image) ** 2
        return passed.sum(axis=0)

    def passed(self, frequency: Float[Array, "*shape"], dt: float) -> Float[Array, "*shape"]:
        """1/(1 + (f/f_c)^(2 order)), as a logistic function: neither it nor its slope overflows."""
        if self.running_mean:
            if self.oversampled:
                once = jnp.sinc(self.taps(dt) * frequency * dt) ** 2
            else:
                once = running_mean_gain(frequency * dt, self.taps(dt))
            # A zero has no logarithm.
            return jnp.exp(self.order * jnp.log(once + 1e-18))
        at, cutoff = jnp.abs(frequency), self.cutoff_frequency
        if self.windowed:
            spread = _SPREAD / (self.order + 1) / dt
            edge = _edge_of(cutoff / spread)
            # Such filters decimate, and what passes above half the rate of what they leave folds.
            still, once, folded = (
                _band(f / spread, edge) for f in (jnp.zeros(()), at, 1 / dt - at)
            )
            return jnp.exp(2 * (once - still)) + jnp.exp(2 * (folded - still)) + _SIDE_LOBES
        if self.digital or self.recursive:
            variable = jnp.sin if self.recursive else jnp.tan
            at, cutoff = (variable(jnp.pi * jnp.minimum(f * dt, 0.4999)) for f in (at, cutoff))
        if self.ripple is not None and self.attenuation is not None:
            passed = equiripple_gain(at, cutoff, self.order, self.ripple, self.attenuation)
            return passed + _SIDE_LOBES
        # Zero frequency has no logarithm; this one passes as well. Apart from that of the cut-off,
        # it is taken once for filters of many cut-offs.
        logarithm = 2 * (jnp.log(jnp.maximum(at, _SLOWEST)) - jnp.log(cutoff))
        if self.droop is None:
            return jax.nn.sigmoid(-self.order * logarithm)
        slow = jnp.minimum(jnp.square(at / cutoff), _STEEPEST)
        fast = jnp.exp(jnp.minimum(self.order * logarithm, np.log(_STEEPEST)))
        return 1 / jnp.maximum(1 + self.droop * slow + (1 - self.droop) * fast, _LOWEST)

    def taps(self, dt: float) -> Float[Array, ""]:
        """How many samples a running mean takes, from its cut-off frequency and order."""
        turn = jnp.pi * self.cutoff_frequency * dt
        # sin(x)/x of x = n turn, where the power is one half.
        goal = jnp.exp2(-0.5 / self.order)
        if not self.oversampled:
            goal = goal * jnp.sin(turn) / turn
        x = jnp.sqrt(6 * (1 - goal))
        for _ in range(_NEWTON):
            x = x - (jnp.sin(x) - goal * x) / (jnp.cos(x) - goal)
        return x / turn

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """White noise filtered, aliases, floor and all; nothing is drawn."""
        return filtered(samples, lambda frequency: self.gain(frequency, dt, sampling), dt)

    def _beyond(self, edge: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        """Integral of |H|^2 from `edge` on [Hz], by its series in falling powers if it has one."""
        if self.droop is not None:
            # f = edge/v^4, where what is to be integrated is smooth in v.
            at, weight = (jnp.asarray(each, edge.dtype) for each in (_NODES, _WEIGHTS))
            density = self.passed(edge[..., None] / at**4, 1.0)
            return edge * jnp.sum(4 * weight / at**5 * density, axis=-1)
        power = 2 * self.order
        ratio = jnp.exp(-power * jnp.log(edge / self.cutoff_frequency))
        terms = ((-1) ** (k + 1) * ratio**k / (k * power - 1) for k in range(1, 7))
        return edge * sum(terms, jnp.zeros_like(edge))


def _even_series(
    coefficients: Float[Array, " orders"], at: Float[Array, " places"]
) -> Float[Array, " places"]:
    """Sum over k of c_k T_2k(2 at), by Clenshaw's recurrence."""
    y = 8 * at**2 - 1

    def step(carry, coefficient):
        last, before = carry
        return (coefficient + 2 * y * last - before, last), None

    nothing = jnp.zeros_like(y + coefficients[0])
    # A loop: written out it would be most of what is compiled of a filter.
    (last, before), _ = jax.lax.scan(step, (nothing, nothing), coefficients[:0:-1])
    return coefficients[0] + y * last - before


def _cutoffs() -> np.ndarray:
    """Where half of the power of a band with such `_EDGES` passes, by bisection."""

    def passed(at):
        near, far = _EDGES - at, -_EDGES - at
        return scipy.special.ndtr(near + _TAIL * near**3) - scipy.special.ndtr(far + _TAIL * far**3)

    low, high = np.zeros_like(_EDGES), _EDGES + 3.0
    goal = np.sqrt(0.5) * passed(0.0)
    for _ in range(50):
        middle = (low + high) / 2
        beyond = passed(middle) < goal
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return high


_CUTOFFS = _cutoffs()


def _edge_of(cutoff: Float[Array, ""]) -> Float[Array, ""]:
    """How far from zero the edges of a band with such a cut-off are, in widths."""
    # Further away one edge does not see the other.
    beyond = jnp.maximum(cutoff - _CUTOFFS[-1], 0.0)
    return jnp.interp(cutoff, _CUTOFFS, _EDGES) + beyond


def lowest_cutoff(order: Float[Array, "..."]) -> Float[Array, "..."]:
    """Of a `windowed` filter of such an order, in cycles per sample: that of its window alone."""
    return _CUTOFFS[0] * _SPREAD / (order + 1)


def _band(at: Float[Array, "*shape"], edge: Float[Array, ""]) -> Float[Array, "*shape"]:
    """Logarithm of |H| at so many widths from zero, between two edges as far from it."""
    upper, lower = _edge(edge - at), _edge(-edge - at)
    # Where both are nothing the difference has no logarithm.
    return upper + jnp.log(-jnp.expm1(jnp.minimum(lower - upper, -1e-6)))


def _edge(at: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Logarithm of |H| at so many widths from the middle of a steep edge."""
    # Further out there is nothing, whose cube would overflow.
    at = jnp.clip(at, -30.0, 30.0)
    return log_ndtr(at + _TAIL * at**3)


def running_mean_gain(
    frequency: Float[Array, "..."] | np.ndarray, taps: Float[Array, "..."] | np.ndarray
) -> Float[Array, "..."]:
    """|H|^2 of the mean of the last n samples, at frequencies in cycles per sample."""
    turn = jnp.pi * jnp.asarray(frequency)
    still = turn == 0
    turn = jnp.where(still, 1.0, turn)
    return jnp.where(still, 1.0, jnp.sin(taps * turn) / (taps * jnp.sin(turn))) ** 2


def oversampled_gain(
    frequency: Float[Array, "..."] | np.ndarray,
    length: Float[Array, "..."] | np.ndarray,
    order: Float[Array, "..."] | float,
) -> Float[Array, "..."]:
    """|H|^2 of means over a length of so many samples, aliases and all, over that at zero."""

    def folded(at):
        image = jnp.asarray(at) + jnp.asarray(_FOLDS).reshape(-1, *(1,) * jnp.ndim(at))
        once = jnp.square(jnp.sinc(length * image))
        # A zero has no logarithm.
        return jnp.sum(jnp.exp(order * jnp.log(once + 1e-18)), axis=0)

    return folded(frequency) / folded(jnp.zeros(()))
