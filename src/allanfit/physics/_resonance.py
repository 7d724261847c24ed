"""A resonance: noise that a damped oscillator has passed."""

from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import ZERO_OR_MORE, AbstractAddedNoise, Parameter
from ._stationary import sample_from_eigenvalues
from ._term import Sampling

# Below this frequency, in cycles a sample, few aliases carry power.
_SLOW = 0.25
_ALIASES = 8


class Resonance(AbstractAddedNoise):
    """The displacement of an oscillator of frequency f_r and quality Q that white noise drives.

    S(f) = 2 sigma^2/(pi f_r Q) f_r^4/((f_r^2 - f^2)^2 + (f f_r/Q)^2), of half width f_r/(2 Q) and
    variance sigma^2; here with the aliases of its sampled form. It oscillates for Q above 1/2;
    below, it is the sum of two Gauss-Markov processes, and Q counts as 1/2.

    With zeta = 1/(2 Q), the damping a = zeta 2 pi f_r dt and the turn b = sqrt(1 - zeta^2)
    2 pi f_r dt of a sample, the autocovariance is sigma^2 exp(-a k) (cos b k + (a/b) sin b k).
    """

    sigma: Float[Array, ""]
    frequency: Float[Array, ""]
    quality_factor: Float[Array, ""]
    name: ClassVar[str] = "resonance"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("sigma", "u", range=ZERO_OR_MORE),
        Parameter("frequency", "Hz"),
        Parameter("quality_factor", ""),
    )
    scale: ClassVar[tuple[str, int]] = ("sigma", 2)
    what: ClassVar[str] = "a resonance"
    origin: ClassVar[str] = "the proof mass, the circuit board or the mount that swings"

    def density(
        self, frequency: Float[Array, "*shape"], dt: float, sampling: Sampling
    ) -> Float[Array, "*shape"]:
        """Exact for samples [u^2/Hz], from the transform of the autocovariance.

        With lambda = a + i b it is 2 dt sigma^2 Re[(1 + i a/b) sinh(lambda)/(cosh(lambda) -
        cos(2 pi f dt))], written so that nothing cancels at small a and b or overflows at large.
        """
        if sampling == "averaged":
            slow = jnp.minimum(self.frequency, _SLOW / dt)
            fast = jnp.maximum(self.frequency, _SLOW / dt)
            return self.sigma**2 * jnp.where(
                self.frequency * dt < _SLOW,
                _folded(frequency, slow, self.quality_factor, dt),
                _averaged_atom(frequency, fast, self.quality_factor, dt),
            )
        damping, turn = _motion(self.frequency, self.quality_factor, dt)
        # Everything hyperbolic is times exp(-damping).
        gone = -jnp.expm1(-damping)
        decay, hyperbolic_sine, half_sine = 1 - gone, gone * (2 - gone) / 2, gone**2 / 4
        half_turn, half = _Angle.of(turn / 2), _Angle.of(jnp.pi * frequency * dt)
        twice = half_turn.doubled()
        sinc = jnp.where(turn > 0, twice.sine / jnp.where(turn > 0, turn, 1.0), 1.0)
        level = hyperbolic_sine + decay * damping * sinc
        level *= 2 * (half_sine + decay * half_turn.sine**2)
        slope = hyperbolic_sine * _lag(-(turn**2), jnp.ones_like(damping), twice.cosine - sinc)
        slope -= damping * sinc * _lag(damping**2, decay, _hyperbolic_lag(damping, decay))
        real = 2 * decay * _less_square(half, half_turn) + 2 * half_sine * twice.cosine
        imaginary = hyperbolic_sine * twice.sine
        ratio = (level + 2 * half.sine**2 * decay * slope) / (real**2 + imaginary**2)
        return 2 * dt * self.sigma**2 * ratio

    def sample(
        self, key: PRNGKeyArray, samples: int, dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """The exact recursion of displacement and velocity, begun in their stationary state.

        Means over intervals come from their density, on a period of twice the length: right
        where the oscillation dies out within the record.
        """
        if sampling == "averaged":
            bins = jnp.linspace(0.0, 0.5 / dt, samples + 1)
            eigenvalues = self.density(bins, dt, sampling) / (2 * dt)
            return sample_from_eigenvalues(key, eigenvalues)[:samples]
        damping, turn = _motion(self.frequency, self.quality_factor, dt)
        cosine, sinc, square = jnp.cos(turn), jnp.sinc(turn / jnp.pi), jnp.exp(-2 * damping)
        omega = jnp.sqrt(damping**2 + turn**2)
        # Of the displacement and the velocity over 2 pi f_r, each of variance 1.
        transition = jnp.exp(-damping) * jnp.array(
            [
                [cosine + damping * sinc, omega * sinc],
                [-omega * sinc, cosine - damping * sinc],
            ]
        )
        # The drive's covariance, 1 - transition transition^T, multiplied out.
        across = 2 * damping * omega * sinc**2 * square
        gone, pull = -jnp.expm1(-2 * damping), 2 * damping * sinc * square
        velocity = gone + pull * (cosine - damping * sinc)
        displacement = gone - pull * (cosine + damping * sinc) - across**2 / velocity
        root = jnp.array(
            [
                [jnp.sqrt(jnp.maximum(displacement, 0)), across / jnp.sqrt(velocity)],
                [jnp.zeros_like(velocity), jnp.sqrt(velocity)],
            ]
        )
        start_key, drive_key = jax.random.split(key)
        drive = jax.random.normal(drive_key, (samples, 2)) @ root.T

        def step(state, noise):
            return transition @ state + noise, state[0]

        start = jax.random.normal(start_key, (2,))
        return self.sigma * jax.lax.scan(step, start, drive)[1]


class _Motion(NamedTuple):
    damping: Float[Array, ""]
    turn: Float[Array, ""]


def _motion(
    frequency: Float[Array, ""], quality: Float[Array, ""], dt: float, least: float = 0.5
) -> _Motion:
    """Damping and turn of a sample [rad]."""
    omega = 2 * jnp.pi * frequency * dt
    zeta = 0.5 / jnp.maximum(quality, least)
    # The root has no derivative at critical damping.
    turning = jnp.maximum((1 - zeta) * (1 + zeta), 1e-12)
    return _Motion(omega * zeta, omega * jnp.sqrt(turning))


class _Angle(NamedTuple):
    """Sine and cosine of an angle: those of its double follow from them."""

    sine: Float[Array, "*shape"]
    cosine: Float[Array, "*shape"]

    @staticmethod
    def of(angle: Float[Array, "*shape"]) -> "_Angle":
        return _Angle(jnp.sin(angle), jnp.cos(angle))

    def doubled(self) -> "_Angle":
        return _Angle(2 * self.sine * self.cosine, 1 - 2 * self.sine**2)


def _less_square(one: _Angle, other: _Angle) -> Float[Array, "*shape"]:
    """sin^2 of one less that of another, by the function that is steeper there."""
    steep = one.cosine < one.sine
    first = jnp.where(steep, other.cosine, one.sine)
    second = jnp.where(steep, one.cosine, other.sine)
    return (first - second) * (first + second)


def _lag(
    square: Float[Array, ""], decay: Float[Array, ""], closed: Float[Array, ""]
) -> Float[Array, ""]:
    """`decay` times cosh(x) - sinh(x)/x, x^2 = `square`; cos and sinc for a negative square.

    `decay` is exp(-x) for a positive square, so that nothing overflows. The series, the sum of
    2 k x^(2 k)/(2 k + 1)!, takes over where the difference, `closed`, cancels.
    """
    order = np.arange(1, 9)
    factor = 2 * order / np.cumprod((2.0 * order) * (2 * order + 1))
    small = jnp.clip(square, -1.0, 1.0)
    series = decay * jnp.polyval(jnp.asarray([*factor[::-1], 0.0], small.dtype), small)
    return jnp.where(jnp.abs(square) < 1, series, closed)


def _hyperbolic_lag(x: Float[Array, ""], decay: Float[Array, ""]) -> Float[Array, ""]:
    """exp(-x) (cosh(x) - sinh(x)/x) for x of one or more; `decay` is exp(-x)."""
    return (1 + decay**2) / 2 - (1 - decay**2) / (2 * jnp.maximum(x, 1.0))


def _folded(
    frequency: Float[Array, "*shape"],
    resonant: Float[Array, ""],
    quality: Float[Array, ""],
    dt: float,
) -> Float[Array, "*shape"]:
    """Continuous density through sinc^2(f dt), aliases summed: they fall as f^-6 [1/Hz]."""
    quality = jnp.maximum(quality, 0.5)

    def add(total, order):
        ratio = (frequency + order / dt) / resonant
        shape = 1 / (((1 - ratio) * (1 + ratio)) ** 2 + (ratio / quality) ** 2)
        return total + shape * jnp.sinc(frequency * dt + order) ** 2, None

    orders = jnp.arange(-_ALIASES, _ALIASES + 1, dtype=frequency.dtype)
    total = jax.lax.scan(add, jnp.zeros_like(frequency * resonant * quality), orders)[0]
    return 2 / (jnp.pi * resonant * quality) * total


def _averaged_atom(
    frequency: Float[Array, "*shape"],
    resonant: Float[Array, ""],
    quality: Float[Array, ""],
    dt: float,
) -> Float[Array, "*shape"]:
    """Density of the means over intervals of a fast resonance [1/Hz].

    That of Gauss-Markov noise with a complex rate, times 1 + i a/b. Critical damping is taken a
    millionth above 1/2, where a/b is still small enough.
    """
    damping, turn = _motion(resonant, quality, dt, 0.5000005)
    rate = jax.lax.complex(damping, turn)
    decay = jnp.exp(-rate)
    gap = 1 - decay
    sine = jnp.sin(jnp.pi * frequency * dt) ** 2
    atom = 2 * (rate - gap) + 2 * gap**2 * (gap - 2 * sine) / (gap**2 + 4 * decay * sine)
    return 2 * dt * jnp.real((1 + 1j * damping / turn) * atom / rate**2)
