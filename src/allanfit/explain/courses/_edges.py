"""Where loud times begin and end, by the shift of the mean that goes with them."""

import numpy as np
from jaxtyping import Bool, Float

from ..spectrum._ordinates import Ordinates
from ._blocks import BLOCKS, FINE_BLOCKS, Scan, blocks_of


def sharpened(
    loud: Bool[np.ndarray, " samples"],
    reach: int,
    values: Float[np.ndarray, " samples"],
    spectrum: Ordinates,
    variance: Float[np.ndarray, " ordinates"],
    odds: Float[np.ndarray, " samples"],
) -> Bool[np.ndarray, " samples"]:
    """Loud times of a stretch with edges where a shift of the mean and the noise have them.

    Each edge is moved by `reach` samples at most. Noise that grows with time makes edges all that
    is known of a shift: one that begins elsewhere is found too small, and edges that only the mean
    has chosen make it too large. `odds` is the log of how much likelier the strength of its noise
    makes each sample of the loud times.
    """
    edges, first = np.flatnonzero(np.diff(loud)) + 1.0, bool(loud[0])
    before = np.concatenate([[0.0], np.cumsum(odds)])
    # Each edge is an end of loud times, or their beginning.
    ends = np.where((np.arange(edges.size) % 2 == 1) != first, 1.0, -1.0)
    whole = [(0, values.size)]
    coarse, fine = blocks_of(values, whole, BLOCKS), blocks_of(values, whole, FINE_BLOCKS)
    # Every place first, then ever closer ones.
    most = reach // coarse.size
    every = coarse.size * np.arange(-most, most + 1)
    halves = coarse.size / 2.0 ** np.arange(max(np.log2(coarse.size / fine.size), 0) + 1)
    closer = [half * np.array([-1, 0, 1]) for half in halves if half <= reach]
    for blocks, rounds in ((coarse, [every, every]), (fine, closer)):
        scan, time = blocks.scan(spectrum, variance), blocks.time

        def gains(
            tried: Float[np.ndarray, "tries edges"], scan: Scan = scan, time=time
        ) -> Float[np.ndarray, " tries"]:
            told = 2 * before[np.clip(np.round(tried).astype(int), 0, odds.size)] @ ends
            shapes = np.stack([_between(at, time, first) for at in tried], axis=1)
            return scan.gains(shapes[..., None].astype(float)) + told

        for moves in rounds:
            for i in range(edges.size):
                tried = np.where(np.arange(edges.size) == i, edges + moves[:, None], edges)
                # Edges that change places would swap what is loud.
                tried = tried[np.all(np.diff(tried) > 0, axis=1)]
                edges = tried[np.argmax(gains(tried))]
    return _between(edges, np.arange(loud.size) + 0.5, first)


def _between(
    edges: Float[np.ndarray, " edges"], time: Float[np.ndarray, " times"], first: bool
) -> Bool[np.ndarray, " times"]:
    """Whether it is loud at some times; `first` before all edges."""
    return (np.searchsorted(edges, time) % 2 == 1) != first
