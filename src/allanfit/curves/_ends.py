"""The errors of an angle at the two ends of a stretch, which nothing cancels.

A rate that was made of an angle with white errors, of standard deviation q a sample, holds the
differences of these: each error comes twice and cancels at low frequency, but for the first and the
last. These two numbers alone put 4 q^2/n into each of the low modes of n samples, on average as
expected. Beside little white noise they are most of what is there, and a likelihood that counts
the modes takes their chance for knowledge of N (`python -m benchmarks.ends`).

The summed rate is a walk beneath the errors. Seen from its end, the level of the walk is the error
there, known to q N by what follows (a steady Kalman filter run towards the end). It is put in the
place of one that is exactly as large as expected, and of the same sign.
"""

from typing import Any

import numpy as np
from jaxtyping import Float

# So much of N squared is worth the trouble.
_HEARD = 0.02
# Less white noise than this times q/sqrt(n) no record of n samples knows.
_LEAST = 2.0
# Times over which the filter remembers, whose mean rate counts as none.
_MEMORIES = 32
# An error larger than so many of its standard deviations is the drift of a rate, and left alone.
_LARGEST = 4.0


def ends_matter(samples: int, error: Any, white: Any) -> Any:
    """Whether errors at the ends of a stretch are heard beside white noise, of one sensor or many.

    Both for a sampling interval of one, as `even_ends` takes them.
    """
    return (error > 0) & (4 * error**2 / samples > _HEARD * white**2)


def even_ends(
    piece: Float[np.ndarray, " samples"], error: float | np.floating, white: float | np.floating
) -> Float[np.ndarray, " samples"]:
    """A stretch whose errors at both ends are as large as expected; the same if none matters.

    **Arguments:**

    - `piece`: samples between gaps, shape (samples,) [u].
    - `error`: of the angle, Q for a sampling interval of one [u].
    - `white`: noise, N for a sampling interval of one [u].
    """
    if not ends_matter(piece.size, error, white):
        return piece
    ratio = max(white / error, _LEAST / piece.size**0.5)
    gain = ratio * (np.hypot(1, ratio / 2) - ratio / 2)
    near = min(int(_MEMORIES / gain) + 1, piece.size)
    weight = (1 - gain) ** np.arange(near)
    # An error at random, as far as what follows does not know better.
    known = 1 / (1 + ratio)
    even = np.array(piece)
    for place, side, sign in ((0, piece[:near], -1.0), (-1, piece[::-1][:near], 1.0)):
        found = sign * known * (weight @ (side - side.mean()))
        if abs(found) > _LARGEST * error:
            continue
        # The first error is in the first sample with a minus, the last one in the last with a plus.
        even[place] += sign * (np.copysign(error, found) - found)
    return even
