"""How likely the phase of a line of steady strength goes on evenly, by diffusion, and by jumps.

A hidden Markov model whose state is the phase beside an even course (forward and backward
algorithm: Rabiner 1989, Proc. IEEE 77:257). Jumps are a compound Poisson process: within a moment
the phase turns with the characteristic function exp(r (c_k - 1)), for r jumps on average, each with
c_k (Feller, An Introduction to Probability Theory and Its Applications II, XVII.2).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ._tracked import Baseband

# So many phases are told apart, as the angle of a jump asks for.
_FEWEST, _MOST = 48, 96
# In a moment the phase of a line of a greater power is no better known, the noise's being one.
_CLEAREST = 6.0
# No phase is out of reach.
_LEAST = 1e-12
# Where drifts are begun with, in half-widths of the band to either side; what part of the jumps
# that make such a band there are; and how the phase diffuses [rad^2].
_REACH, _PLACES = 2.0, 9
_PARTS, _SPREADS = (1 / 16, 1 / 4, 1 / 2, 1.0), (1e-4, 3e-3, 1e-1)
# Then steps become finer, so many times.
_TIMES, _ASIDE, _LESS, _ENOUGH = 6, (-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0), 0.5, 1.0
# Numbers of jumps and drifts that are compared with the likeliest: up to so many times as large and
# so many deviations away, and how many of each.
_WIDE, _AWAY, _GRID = 3.0, 3.0, 17

Moves = Float[np.ndarray, "ways phases phases"]


class Jumps(NamedTuple):
    """What may happen to a phase, and of how many phases, so that a jump is by whole steps."""

    #: The steps of a jump, or None for one to any phase.
    steps: int | None
    phases: int

    def moves(self, ways: Sequence["Turning"], *, counted: bool = False) -> Moves:
        """The chances of going from one phase to another in a moment, or times how many jumps."""
        order = np.arange(self.phases // 2 + 1)
        if self.steps is None:
            jump = (order == 0).astype(complex)
        else:
            jump = np.exp(-2j * np.pi * order * self.steps / self.phases)
        _, often, spread = (np.array(each)[:, None] for each in zip(*ways, strict=True))
        # It diffuses by single steps to either side, which keeps all chances above zero.
        step = 2 * np.pi / self.phases
        diffusion = spread / step**2 * (np.cos(order * step) - 1)
        turned = np.exp(often * (jump - 1) + diffusion)
        # The sum over j of j times the chance of j jumps has the factor r c_k.
        turned = turned * often * jump if counted else turned
        chances = np.maximum(np.fft.irfft(turned, self.phases), _LEAST)
        place = np.arange(self.phases)
        return chances[:, (place[:, None] - place) % self.phases]


def jumps_by(angle: float) -> Jumps:
    """By the same angle [rad] each time."""
    phases = np.arange(_FEWEST, _MOST + 1, 2)
    steps = angle / (2 * np.pi) * phases
    best = int(np.argmin(np.abs(steps - np.round(steps)) / phases))
    return Jumps(round(float(steps[best])), int(phases[best]))


NO_JUMPS, ANY_JUMPS = Jumps(0, _FEWEST), Jumps(None, _FEWEST)


class Turning(NamedTuple):
    """How the phase goes on in a moment: its drift [rad], the jumps on average, and [rad^2]."""

    drift: float
    jumps: float
    spread: float


def search(band: Baseband, drift: float, width: float, jumps: Jumps, most: float) -> Turning:
    """The likeliest way to turn about a drift [rad], of a band of such a half-width [rad].

    The band's white noise has a mean square of one. `most` is how many jumps in a moment make such
    a band, or zero for none.
    """
    # Jumps on average move the phase as well, and the middle of a band tells of both.
    ahead = 0.0
    if jumps.steps is not None:
        ahead = most * float(np.sin(2 * np.pi * jumps.steps / jumps.phases))
    low, high = sorted((drift, drift - ahead))
    step = 2 * _REACH * width / (_PLACES - 1)
    drifts = np.arange(low - _REACH * width, high + _REACH * width + step, step)
    often = [part * most for part in _PARTS] if most else [0.0]
    best, _ = _likeliest(band, drifts, often, _SPREADS, jumps)
    return refined(band, best, step, jumps)


def refined(band: Baseband, best: Turning, step: float, jumps: Jumps) -> Turning:
    """A way to turn that is likelier still, near to one; at first drifts are a `step` apart."""
    highest = log_likelihood(band, best, jumps)
    factor, spreading = 2.0, 5.0
    for _ in range(_TIMES):
        drifts = best.drift + step * np.array(_ASIDE)
        often = [best.jumps * each for each in (1 / factor, 1.0, factor)] if best.jumps else [0.0]
        spreads = [best.spread * each for each in (1 / spreading, 1.0, spreading)]
        found, likelihood = _likeliest(band, drifts, often, spreads, jumps)
        gained, best = likelihood - highest, found if likelihood > highest else best
        highest = max(highest, likelihood)
        # While it is another way that is likelier, it may be further on.
        if gained < _ENOUGH:
            step, factor, spreading = step * _LESS, factor**_LESS, spreading**_LESS
    return best


def jumps_told(band: Baseband, way: Turning, jumps: Jumps) -> tuple[float, float]:
    """How many jumps there are in a moment, and the standard deviation of that.

    By how likely each number is, averaged over drifts: a phase that jumps by chance leaves the
    drift of the rest as uncertain as the mean of its steps.
    """
    angle = 2 * np.pi * (jumps.steps or 0) / jumps.phases
    angle = abs(np.angle(np.exp(1j * angle)))
    often = way.jumps * np.geomspace(1 / _WIDE, _WIDE, _GRID)
    ways = [way._replace(jumps=each) for each in often.tolist()]
    unsure = angle * np.sqrt(way.jumps / band.size)
    drifts = way.drift + unsure * np.linspace(-_AWAY, _AWAY, _GRID)
    likelihoods = _log_likelihoods(band, drifts, ways, jumps)
    # Evenly in the logarithm, as all scales are.
    chance = np.exp(likelihoods - likelihoods.max()).sum(axis=1)
    mean = float(np.average(often, weights=chance))
    return mean, float(np.sqrt(np.average((often - mean) ** 2, weights=chance)))


def _likeliest(
    band: Baseband,
    drifts: Float[np.ndarray, " drifts"],
    often: Sequence[float],
    spreads: Sequence[float],
    jumps: Jumps,
) -> tuple[Turning, float]:
    ways = [Turning(0.0, each, spread) for each in often for spread in spreads]
    # To tell which is likelier six digits are enough, and take half of the time.
    likelihoods = _log_likelihoods(band, drifts, ways, jumps, np.float32)
    way, drift = np.unravel_index(int(np.argmax(likelihoods)), likelihoods.shape)
    best = ways[way]._replace(drift=float(drifts[drift]))
    return best, float(likelihoods[way, drift])


def log_likelihood(band: Baseband, way: Turning, jumps: Jumps) -> float:
    """Of a way to turn, over white noise alone."""
    return float(_log_likelihoods(band, np.array([way.drift]), [way], jumps)[0, 0])


def _log_likelihoods(
    band: Baseband,
    drifts: Float[np.ndarray, " drifts"],
    ways: Sequence[Turning],
    jumps: Jumps,
    precision: type[np.floating] = np.float64,
) -> Float[np.ndarray, "ways drifts"]:
    """Of each way to turn with each drift, whatever drift it has itself."""
    told = np.stack([_told(band, drift, jumps.phases) for drift in drifts.tolist()], axis=2)
    top = told.max(axis=1)
    likelihood = np.exp(told - top[:, None]).astype(precision)
    moves = jumps.moves(ways).astype(precision)
    states = np.full((len(ways), jumps.phases, drifts.size), 1 / jumps.phases, precision)
    found = np.tile(top.sum(axis=0), (len(ways), 1))
    for at, here in enumerate(likelihood):
        states = (moves @ states if at else states) * here
        total = states.sum(axis=1)
        states /= total[:, None]
        found += np.log(total)
    return found


def _told(band: Baseband, drift: float, phases: int) -> Float[np.ndarray, "moments phases"]:
    """The log-likelihood of each phase beside an even course, over that of white noise alone."""
    power = max(float(np.mean(np.abs(band) ** 2)) - 1, 1e-3)
    even = band * np.exp(-1j * drift * np.arange(band.size))
    turned = np.exp(-2j * np.pi * np.arange(phases) / phases)
    told = 2 * np.sqrt(power) * np.real(np.outer(even, turned)) - power
    return min(1.0, _CLEAREST / power) * told


def jumps_between(band: Baseband, way: Turning, jumps: Jumps) -> Float[np.ndarray, " band"]:
    """How many jumps are expected before each moment since the one before, by all of the band."""
    (move,), (counted,) = jumps.moves([way]), jumps.moves([way], counted=True)
    told = _told(band, way.drift, jumps.phases)
    likelihood = np.exp(told - told.max(axis=1, keepdims=True))
    until = np.empty_like(likelihood)
    state = np.full(jumps.phases, 1 / jumps.phases)
    for at, here in enumerate(likelihood):
        state = (move @ state if at else state) * here
        state /= state.sum()
        until[at] = state
    expected, after = np.zeros(band.size), np.ones(jumps.phases)
    for at in range(band.size - 1, 0, -1):
        after = after * likelihood[at]
        expected[at] = after @ counted @ until[at - 1] / (after @ move @ until[at - 1])
        after = after @ move
        after /= after.sum()
    return expected
