"""What passes the rails of an output that is clipped at times."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import norm

from ...recording._checks import usable
from .._state import Investigation

# Standard deviations of the noise, and phases of half a period, over which means are taken.
_Z = np.linspace(-8, 8, 4001)
_DENSITY = norm.pdf(_Z) / norm.pdf(_Z).sum()
_COSINES = np.cos((np.arange(64) + 0.5) * np.pi / 64)
# Rounds that find a line, and the part of the variance that is noise at least.
_ROUNDS, _NOISE = 30, 1e-4


class Rails(NamedTuple):
    """Of an output whose signal is about normal."""

    #: The signal's mean, from the median of the values, and its standard deviation [u].
    mean: float
    sigma: float
    #: Lowest and highest value that are logged, from the median of the values [u].
    low: float
    high: float

    @property
    def variance(self) -> float:
        """The part of the noise's variance that is logged."""
        passed = np.clip(self.mean + _Z * self.sigma, self.low, self.high)
        return float((_DENSITY @ passed**2 - (_DENSITY @ passed) ** 2) / self.sigma**2)

    @property
    def gain(self) -> float:
        """The part of what is small beside the noise, or slow, that is logged.

        For a normal signal it is the signal's product with what is logged (Bussgang's theorem).
        """
        passed = np.clip(self.mean + _Z * self.sigma, self.low, self.high)
        return float(_DENSITY @ (_Z * passed) / self.sigma)

    def line(self, amplitude: float) -> float:
        """The amplitude [u] of a line that is logged with this one."""
        found = amplitude
        for _ in range(_ROUNDS):
            noise = np.sqrt(max(self.sigma**2 - found**2 / 2, _NOISE * self.sigma**2))
            signal = self.mean + found * _COSINES + noise * _Z[:, None]
            passed = _DENSITY @ np.clip(signal, self.low, self.high)
            found *= amplitude / (2 * float(np.mean(passed * _COSINES)))
        return found


def rails(state: Investigation) -> Rails | None:
    """Those of the output, if it is clipped but not for most of the time.

    How strong the signal was follows from how many samples stand at a rail: rounded, from half a
    code before it on.
    """
    if not state.format.rails:
        return None
    at, used = np.array(sorted(state.format.rails)), usable(state.values, state.pieces)
    middle = float(np.median(used))
    if middle in at:
        return None
    reach = at - middle
    # In standard deviations from the mean, which is the median if there is but one rail.
    beyond = [np.mean(used == rail) for rail in at]
    place: Float[np.ndarray, " rails"] = np.sign(reach) * norm.isf(np.clip(beyond, 1e-9, 0.49))
    edge = reach - np.sign(reach) * np.minimum(state.format.width, np.abs(reach)) / 2
    both = at.size == 2
    sigma = float(np.ptp(edge) / np.ptp(place)) if both else float(edge[0] / place[0])
    mean = float(np.mean(edge - place * sigma)) if both else 0.0
    low, high = min(reach[0], 0.0), max(reach[-1], 0.0)
    return Rails(mean, sigma, float(low) or -np.inf, float(high) or np.inf)
