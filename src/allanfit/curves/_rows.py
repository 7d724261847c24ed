"""Blocks of any length, cut into rows of one length."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

#: Samples of one cosine transform, which the spectrum and the Allan variance share.
ROW = 2**18


class Waiting:
    """What waits until it fills a row, and more comes: the last row may be all that there is."""

    def __init__(self, row: int):
        self._place = np.empty(row)
        self._filled = 0

    @property
    def rest(self) -> Float[np.ndarray, " waiting"]:
        """What waits now, at most a row, in a place that is used again."""
        return self._place[: self._filled]

    @property
    def full(self) -> bool:
        """Whether it is a whole row."""
        return self._filled == self._place.size

    def add(self, block: Float[np.ndarray, " any"]) -> Iterator[Float[np.ndarray, " row"]]:
        """Take a block and give the rows that it leaves behind, each to be used before the next."""
        while block.size:
            if self.full:
                yield self._place
                self._filled = 0
            some = block[: self._place.size - self._filled]
            self._place[self._filled :][: some.size] = some
            self._filled += some.size
            block = block[some.size :]

    def clear(self) -> None:
        """Nothing waits any more."""
        self._filled = 0
