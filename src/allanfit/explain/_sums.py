"""What a fit of courses asks of the ordinates, summed over bins once.

The likelihood averages ordinates over bins (`_ordinates.binned`). Courses and their sizes enter it
by products of amplitudes, summed over each bin; once these are known, neither sizes nor the noise
beside them cost anything that grows with the length of the record.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ._ordinates import Bins, Ordinates, binned, runs_between

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
        rows = len(moved)
        plain = moved if self._kept is None else moved * self._kept[:rows, None]
        both = np.concatenate([plain, moved * self._weight[:rows, None]], axis=1)
        held = before.plain.shape[1]
        columns = held + moved.shape[1]
        found = np.zeros((2, len(self.count), columns, columns))
        found[:, :, :held, :held] = before
        end = 0
        for block in (*taken, moved):
            begin, end = end, end + block.shape[1]
            across = self._summed(block, both).reshape(len(self.count), -1, 2, moved.shape[1])
            for each, part in zip(found, across.transpose(2, 0, 1, 3), strict=True):
                each[:, begin:end, held:] = part
                each[:, held:, begin:end] = part.swapaxes(1, 2)
        return Products(*found)

    def _summed(self, first: Moved, second: Moved) -> Float[np.ndarray, "bins some others"]:
        rows = min(len(first), len(second))
        found = np.zeros((len(self._runs), first.shape[1], second.shape[1]))
        for into, (start, stop) in zip(found, self._runs, strict=True):
            if start >= rows:
                break
            inside = slice(start, min(stop, rows))
            np.matmul(first[inside].T, second[inside], out=into)
        return found


def _slow_top(
    ends: Float[np.ndarray, " bins"], bins: Bins, variance: Float[np.ndarray, " bins"]
) -> float:
    """Where what ordinates say of a step is as good as all said; its amplitudes fall as 1/f."""
    used = bins.used
    told = np.asarray(bins.shape)[used] / bins.frequency[used] ** 2 / variance
    share = np.cumsum(told) / told.sum()
    return float(ends[np.searchsorted(share, 1 - _REST)])
