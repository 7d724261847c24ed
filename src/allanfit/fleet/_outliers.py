"""Which devices do not belong: the generalised extreme studentised deviate test.

The device farthest from the others is set aside, again and again, up to a third of them; each
time its distance from the middle of those that remain is measured in what they scatter, and
judged by Student's t. Outliers are the longest row of such devices that ends with one beyond its
critical value, so that two bad devices cannot hide one another (Rosner, Technometrics 25, 165,
1983). Here each device also has an error of its own, the scatter between devices is that beyond
the errors, and `alpha` is shared out to the steps, since Rosner's values are too small for ten
devices. Where none is odd and all are normal, any is named in at most `alpha` of all fleets;
benchmarks/fleet.py counts.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from ._spread import SMALLEST_ERROR, Values, centre

#: With fewer, nobody can say which of them is odd.
FEWEST = 5
_LARGEST_SHARE = 3  # one in so many devices may be an outlier


class Deviate(NamedTuple):
    """A device that does not belong."""

    index: int
    distance: float
    """From the middle of the others, in the unit of the values."""
    deviations: float
    """The same in standard deviations of what the others let expect."""


def outliers(values: Values, errors: Values, alpha: float, *, above: bool = False) -> list[Deviate]:
    """The devices that do not belong, the farthest first; none among fewer than `FEWEST`.

    **Arguments:** `values` and their standard `errors`, both of shape (devices,); `alpha` is the
    chance of naming any where there is none. With `above`, only what is larger than the others.
    """
    if len(values) < FEWEST:
        return []
    errors = np.maximum(errors, SMALLEST_ERROR)
    kept = np.arange(len(values))
    aside: list[Deviate] = []
    last = 0
    for step in range(1, len(values) // _LARGEST_SHARE + 1):
        among = centre(values[kept], errors[kept])
        scaled = (values[kept] - among.middle) / np.hypot(among.tau, errors[kept])
        farthest = kept[int(np.argmax(scaled if above else np.abs(scaled)))]
        rest = kept[kept != farthest]
        others = centre(values[rest], errors[rest])
        distance = float(values[farthest] - others.middle)
        variance = others.tau**2 + errors[farthest] ** 2 + others.variance
        deviations = distance / float(np.sqrt(variance))
        aside.append(Deviate(int(farthest), distance, deviations))
        # The farthest of so many against a scatter known from all but two of them.
        tail = deviations if above else abs(deviations)
        sides = 1 if above else 2
        p_value = sides * len(kept) * float(student.sf(tail, len(kept) - 2))
        # These shares of the chance add up to one, whatever the number of steps.
        if p_value < alpha / (step * (step + 1)):
            last = step
        kept = rest
    return sorted(aside[:last], key=lambda each: -abs(each.deviations))
