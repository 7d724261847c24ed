"""The shortest record that tells a coefficient well enough."""

import math
from bisect import bisect_left
from collections.abc import Mapping

from ..physics import Sampling
from ..recording._checks import FEWEST_SAMPLES
from ._errors import relative_errors

#: The longest record that anybody is told to make.
LONGEST_YEARS = 10
_YEAR_S = 365.25 * 86400
_TOLERANCE = 1e-3


def shortest_samples(
    symbol: str,
    error: float,
    coefficients: Mapping[str, float],
    rate_hz: float,
    sampling: Sampling,
) -> int | None:
    """Samples of the shortest record with this relative standard error; None beyond ten years.

    Errors fall as a record grows. Bisection over octaves, which channels of one rate share, then
    the false position between two of them: an error is nearly a power of the length.
    """

    def excess(samples: int) -> float:
        return math.log(relative_errors(coefficients, rate_hz, samples, sampling)[symbol] / error)

    longest = longest_samples(rate_hz)
    if excess(longest) > 0:
        return None
    octaves = math.ceil(math.log2(longest / FEWEST_SAMPLES))
    octave = bisect_left(range(octaves), True, key=lambda k: excess(FEWEST_SAMPLES << k) <= 0)
    if octave == 0:
        return FEWEST_SAMPLES
    low, high = FEWEST_SAMPLES << (octave - 1), min(FEWEST_SAMPLES << octave, longest)
    above, below = excess(low), excess(high)
    while high - low > 1:
        guess = low * (high / low) ** (above / (above - below))
        middle = min(max(math.ceil(guess), low + 1), high - 1)
        found = excess(middle)
        if abs(found) < _TOLERANCE:
            return middle
        if found > 0:
            low, above = middle, found
        else:
            high, below = middle, found
    return high


def longest_samples(rate_hz: float) -> int:
    """Samples of the longest record that is considered."""
    return math.floor(LONGEST_YEARS * _YEAR_S * rate_hz)
