"""Whether noise has two levels that last, by the likelihood of all that these may be.

Weak changes of the strength are seen in no window. How much likelier a hidden Markov model of two
levels makes all windows together than one level does, on average over how much they differ and how
long they last, is the most powerful statistic on average over the same (Neyman and Pearson 1933;
the forward algorithm: Rabiner 1989, Proc. IEEE 77:257, section III.A).
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

# A record is cut into so many windows, or into fewer that are as long as the shortest.
_WINDOWS, _FEWEST = 256, 64
# Parts of the record that a level lasts on average, and the deviations by which levels are apart
# when all windows are taken together.
_LASTING = (1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4)
_APART = (2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 30.0)
# The log of the chance that the log of the mean ratio is beyond x by chance alone is this less this
# times x, for 64 to 256 windows: `python -m benchmarks.strength`. The mean ratio itself is one on
# average, so that a fall of one is true of any.
_CHANCE, _FALL = -2.9, 1.4

Windows = Float[np.ndarray, " windows"]


class Levels(NamedTuple):
    """Two levels of noise."""

    p_value: float
    #: The chance that each window is of the louder one, if there are two.
    loud: Windows

    @property
    def path(self) -> Bool[np.ndarray, " windows"]:
        return self.loud > 0.5


def window_of(samples: int, shortest: int) -> int | None:
    """Samples a window, if there are enough for as many as it takes."""
    window = max(samples // _WINDOWS, shortest)
    return window if samples // window >= _FEWEST else None


def log_mean_ratio(power: Windows, weight: float) -> tuple[float, Windows]:
    """The log of the mean likelihood ratio, and the chance that each window is loud if it is one.

    `power` is the mean square in windows, as certain as that of `weight` independent normal
    samples. Its cube root is all but normal (Wilson and Hilferty 1931, PNAS 17:684).
    """
    spread = np.sqrt(2 / weight) / 3
    normal = np.cbrt(power / power.mean()) / spread
    normal = normal - normal.mean()
    lasting = power.size * np.array(_LASTING)
    grid = np.meshgrid(lasting, lasting, np.array(_APART), indexing="ij")
    louder, quieter, apart = (each.ravel() for each in grid)
    share = louder / (louder + quieter)
    apart = apart / np.sqrt(power.size * share * (1 - share))
    # Levels about the mean that all windows have.
    means = np.stack([-share * apart, (1 - share) * apart])
    ratios = np.exp(means * normal[:, None, None] - means**2 / 2)
    begin, end = -np.expm1(-1 / quieter), -np.expm1(-1 / louder)

    loud, evidence = np.empty((power.size, share.size)), np.zeros(share.size)
    before = share
    for now, (quiet_ratio, loud_ratio) in enumerate(ratios):
        odds = np.stack([(1 - before) * quiet_ratio, before * loud_ratio])
        total = odds.sum(axis=0)
        evidence += np.log(total)
        loud[now] = odds[1] / total
        before = loud[now] * (1 - end) + (1 - loud[now]) * begin
    # What comes later tells as well (Rabiner, section III.B, as a chain that runs backward).
    for now in range(power.size - 2, -1, -1):
        until = loud[now] * (1 - end) + (1 - loud[now]) * begin
        stays = loud[now] * (1 - end) / until
        leaves = loud[now] * end / (1 - until)
        loud[now] = loud[now + 1] * stays + (1 - loud[now + 1]) * leaves
    total = float(np.logaddexp.reduce(evidence))
    return total - np.log(evidence.size), loud @ np.exp(evidence - total)


def levels_that_last(power: Windows, weight: float) -> Levels:
    """Two levels of the mean square in windows that is as certain as that of `weight` samples."""
    ratio, loud = log_mean_ratio(power, weight)
    return Levels(float(np.exp(min(_CHANCE - _FALL * ratio, 0.0))), loud)
