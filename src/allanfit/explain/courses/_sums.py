"""What a fit of courses asks of the ordinates, summed over bins once.

The likelihood averages ordinates over bins (`_ordinates.binned`). Courses and their sizes enter it
by products of amplitudes, summed over each bin; once these are known, neither sizes nor the noise
beside them cost anything that grows with the length of the record.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..spectrum._ordinates import Bins, Ordinates, binned, runs_between

# Of what a step's ordinates say of its size, the part that those beyond `slow_top` may hold.
_REST = 1e-5

#: The amplitudes that a course gives the ordinates, one column a size. Ordinates beyond the last
#: row are not moved.
Moved = Float[np.ndarray, "_ _"]


class Products(NamedTuple):
    """Products of amplitudes, summed over each bin; the record's own are the first column."""

    #: Shape (bins, columns, columns) [u^2].
    plain: Float[np.ndarray, "bins columns columns"]
    #: Each ordinate weighted by how much less than the mean of its bin the noise has there.
    weighted: Float[np.ndarray, "bins columns columns"]

    def less(self, sizes: Float[np.ndarray, " sizes"]) -> Float[np.ndarray, " bins"]:
        """The sum of squares in each bin, when courses of these sizes are taken out."""
        left = np.append(1.0, -sizes)
        return np.einsum("i,bij,j->b", left, self.plain, left)


class Summing:
    """Sums over the bins of one record, for the noise that a model expects now."""

    def __init__(
        self,
        spectrum: Ordinates,
        edges: Float[np.ndarray, " edges"],
        variance: Float[np.ndarray, " ordinates"],
    ):
        """`variance` is what the model expects of each ordinate [u^2]."""
        kept = spectrum.clean(spectrum.frequency)
        starts, stops, count = runs_between(spectrum.frequency, edges, kept)
        #: Averages of the ordinates as they were recorded.
        self.bins: Bins = binned(spectrum, edges)
        self.count = count
        self._runs = list(zip(starts, stops, strict=True))
        self._kept = None if kept.all() else kept
        of_bin = np.add.reduceat(np.where(kept, variance, 0.0), starts) / count
        # Between bins are only ordinates that are not kept.
        reach = np.diff(np.append(0, starts[1:]), append=kept.size)
        self._weight = np.where(kept, np.repeat(of_bin, reach) / variance, 0.0)
        self._own = spectrum.amplitude[:, None]
        #: Ordinates above this frequency [cycles per sample] say nothing of slow courses.
        self.slow_top = _slow_top(spectrum.frequency[stops - 1], self.bins, of_bin)
        self.alone = self._extended(Products(*np.zeros((2, len(count), 0, 0))), [], self._own)

    def beside(self, before: Products, taken: Sequence[Moved], *more: Moved) -> Products:
        """The products of courses `taken` already, `before`, and of more after them."""
        known = [self._own, *taken]
        for moved in more:
            before = self._extended(before, known, moved)
            known.append(moved)
        return before

    def of(self, taken: Sequence[Moved]) -> Products:
        """The products of several courses."""
        return self.beside(self.alone, [], *taken)

    def _extended(self, before: Products, taken: Sequence[Moved], moved: Moved) -> Products:
        held = before.plain.shape[1]
        columns = held + moved.shape[1]
        found = np.zeros((2, len(self.count), columns, columns))
        found[:, :, :held, :held] = before
        plain, weighted = found
        for place, (start, stop) in enumerate(self._runs):
            mine = moved[start:stop]
            if not len(mine):
                break
            inside = slice(start, start + len(mine))
            kept = mine if self._kept is None else mine * self._kept[inside, None]
            light = mine * self._weight[inside, None]
            end = 0
            for block in (*taken, moved):
                begin, end = end, end + block.shape[1]
                other = block[inside].T
                rows = other.shape[1]
                plain[place, begin:end, held:] = other @ kept[:rows]
                weighted[place, begin:end, held:] = other @ light[:rows]
        found[:, :, held:, :held] = found[:, :, :held, held:].swapaxes(2, 3)
        return Products(plain, weighted)


def _slow_top(
    ends: Float[np.ndarray, " bins"], bins: Bins, variance: Float[np.ndarray, " bins"]
) -> float:
    """Where what ordinates say of a step is as good as all said; its amplitudes fall as 1/f."""
    used = bins.used
    told = np.asarray(bins.shape)[used] / bins.frequency[used] ** 2 / variance
    share = np.cumsum(told) / told.sum()
    return float(ends[np.searchsorted(share, 1 - _REST)])
