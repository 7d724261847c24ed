"""Means over blocks of a record, and a scan of them in the noise as it is."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.fft import dct

from ..spectrum._ordinates import Ordinates

# Courses are looked for in means over at most this many blocks of a stretch.
BLOCKS = 4096
# And steps, which are sharp.
FINE_BLOCKS = 65536
# Of which each is of a few samples at most.
FINEST_BLOCKS = 2**21
# A shorter stretch of a record with gaps is looked at if it has so many of these.
_FEWEST_BLOCKS = 32


class Blocks(NamedTuple):
    """Means over blocks of stretches of a record."""

    #: One array a stretch.
    means: list[Float[np.ndarray, " blocks"]]
    #: Where the stretches begin.
    starts: list[int]
    #: Samples in each block.
    size: int

    @property
    def time(self) -> Float[np.ndarray, " blocks"]:
        """The middles of all blocks, in samples of the record."""
        return np.concatenate(
            [
                start + (np.arange(means.size) + 0.5) * self.size
                for start, means in zip(self.starts, self.means, strict=True)
            ]
        )

    def scan(self, spectrum: Ordinates, variance: Float[np.ndarray, " ordinates"]) -> "Scan":
        """A scan in noise that gives the ordinates of the record this variance."""
        stretches, time, scale = [], self.time, np.sqrt(self.size)
        for means, first in zip(self.means, np.cumsum([0, *self.counts]), strict=False):
            orders = np.arange(1, max(means.size // 2, 2))
            at = orders / (2 * means.size * self.size)
            weight = np.interp(at, spectrum.frequency, variance) / 2
            amplitude, ramp = (
                block_coefficients(each, scale, orders)
                for each in (means, time[first : first + means.size])
            )
            stretches.append(Stretch(amplitude, ramp, weight, scale, orders, means.size))
        return Scan(self, stretches)

    @property
    def counts(self) -> list[int]:
        """How many blocks each stretch has."""
        return [means.size for means in self.means]


def blocks_of(
    values: Float[np.ndarray, " samples"], pieces: list[tuple[int, int]], most: int = BLOCKS
) -> Blocks:
    """`most` blocks in the longest stretch, and as long ones in those that hold enough."""
    longest = max(length_of(piece) for piece in pieces)
    size = max(1, longest // most)
    kept = [p for p in pieces if length_of(p) >= min(_FEWEST_BLOCKS * size, longest)]
    ends = [stop - (stop - start) % size for start, stop in kept]
    means = [
        values[start:end].reshape(-1, size).mean(axis=1)
        for (start, _), end in zip(kept, ends, strict=True)
    ]
    return Blocks(means, [start for start, _ in kept], size)


class Stretch(NamedTuple):
    """The cosine coefficients of one stretch, of its ramp, and their variance."""

    amplitude: Float[np.ndarray, " orders"]
    ramp: Float[np.ndarray, " orders"]
    variance: Float[np.ndarray, " orders"]
    scale: float
    orders: np.ndarray
    #: How many blocks it has.
    count: int

    @property
    def white(self) -> Float[np.ndarray, " orders"]:
        """The coefficients in white noise."""
        return self.amplitude / np.sqrt(self.variance)

    def beside_ramp(
        self, columns: Float[np.ndarray, "blocks columns"]
    ) -> Float[np.ndarray, "orders columns"]:
        """Some columns in white noise, at right angles to the ramp."""
        root = np.sqrt(self.variance)
        moved = block_coefficients(columns, self.scale, self.orders) / root[:, None]
        ramp = self.ramp / root
        return moved - np.outer(ramp, ramp @ moved) / (ramp @ ramp)

    def gains(self, waves: Float[np.ndarray, "waves two orders"]) -> Float[np.ndarray, " waves"]:
        """What each cosine and its sine gain, given as their coefficients for a scale of one."""
        root = np.sqrt(self.variance)
        ramp = self.ramp / root
        ramp /= np.sqrt(ramp @ ramp)
        beside = waves * self.scale / root
        beside -= (beside @ ramp)[..., None] * ramp
        # What is left of the amplitudes at right angles to the ramp matters alone.
        along = beside @ self.white
        gram = beside @ beside.swapaxes(1, 2)
        return np.sum(along * np.linalg.solve(gram, along[..., None])[..., 0], axis=1)


class Scan(NamedTuple):
    """What columns of numbers gain in the noise of a record, its ramps beside them."""

    blocks: Blocks
    stretches: list[Stretch]

    @property
    def white(self) -> Float[np.ndarray, " orders"]:
        """The coefficients of all stretches in white noise."""
        return np.concatenate([stretch.white for stretch in self.stretches])

    def gain(self, columns: Float[np.ndarray, "blocks columns"]) -> float:
        """What generalised least squares gains by some columns beside the ramps."""
        return float(np.sum((self.directions(columns).T @ self.white) ** 2))

    def directions(
        self, columns: Float[np.ndarray, "blocks columns"]
    ) -> Float[np.ndarray, "orders columns"]:
        """Unit vectors of some columns in white noise, at right angles to the ramps."""
        parts = np.split(columns, np.cumsum(self.blocks.counts)[:-1])
        beside = [
            stretch.beside_ramp(part) for stretch, part in zip(self.stretches, parts, strict=True)
        ]
        return np.linalg.qr(np.concatenate(beside))[0]


def block_coefficients(
    columns: Float[np.ndarray, "blocks *columns"], scale: float, orders: np.ndarray
) -> Float[np.ndarray, "orders *columns"]:
    """Cosine coefficients of means, as those of samples."""
    centred = columns - columns.mean(axis=0)
    return scale * np.asarray(dct(centred, axis=0, norm="ortho"))[orders]


def length_of(piece: tuple[int, int]) -> int:
    """Samples of a stretch, given where it begins and ends."""
    return piece[1] - piece[0]
