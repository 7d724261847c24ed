"""How long the levels of a telegraph last, from switches of which brief dwells hide some."""

import numpy as np
from jaxtyping import Float

from ._course import Course

# Levels are held for different times if their shares differ by so many standard deviations.
_UNEVEN = 3.0
# How far off the shortest dwell that is seen may be, as a standard deviation of its logarithm.
_ROUGH = 0.3
# And the longest that is believed, as a part of how long the briefer level seems to last.
_HIDDEN = 0.15
_ITERATIONS = 40


def dwells(
    course: Course, rng: np.random.Generator, draws: int
) -> tuple[Float[np.ndarray, " draws"], Float[np.ndarray, " draws"], bool]:
    """Draws of the mean dwell [samples] and of the upper level's share, and whether that is uneven.

    Dwells too short to be seen join their neighbours: a level that is left at the rate a, and the
    other at b, seems to last for (exp(b d) - 1)/b + exp(b d)/a, if none shorter than d is seen
    (Colquhoun and Sigworth 1983, in Single-Channel Recording, for two states).
    """
    shape = course.shape
    upper, samples, switches = shape["upper"], shape["samples"], shape["switches"]
    seems = samples / rng.gamma(switches, 1.0, draws)
    # Of the time on one level, by turns of exponential length.
    deviation = 2 * upper * (1 - upper) / np.sqrt(switches)
    share = np.clip(upper + deviation * rng.normal(size=draws), 0.01, 0.99)
    uneven = bool(abs(upper - 0.5) > _UNEVEN * deviation)
    part = share if uneven else np.full(draws, 0.5)
    unseen = shape["unseen"] * np.exp(_ROUGH * rng.normal(size=draws))
    # Beyond, what seems to last tells nothing any more of what does.
    unseen = np.minimum(unseen, _HIDDEN * seems * 2 * np.minimum(part, 1 - part))
    dwell = seems.copy()
    for _ in range(_ITERATIONS):
        high, low = 2 * part * dwell, 2 * (1 - part) * dwell
        past_high, past_low = np.exp(unseen / high), np.exp(unseen / low)
        both = (past_low - 1) * low + past_low * high
        both += (past_high - 1) * high + past_high * low
        dwell *= 2 * seems / both
    return dwell, share, uneven
