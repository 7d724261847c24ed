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
_NEXT_TO_NOTHING = 1e-300


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


class Waves(NamedTuple):
    """Cosines and their sines by their coefficients, for a scale of one."""

    both: Float[np.ndarray, "waves two orders"]
    #: The cosine's squared, the two multiplied, the sine's squared.
    products: Float[np.ndarray, "waves three orders"]


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

    def gains(self, waves: Waves) -> Float[np.ndarray, " waves"]:
        """What each cosine and its sine gain."""
        weight = 1 / self.variance
        ramp = self.ramp * weight
        ramp /= np.sqrt(ramp @ self.ramp)
        own, along = np.moveaxis(waves.both @ np.stack([self.amplitude * weight, ramp], 1), 2, 0)
        # What is left of the amplitudes at right angles to the ramp matters alone.
        cosine, sine = (own - (ramp @ self.amplitude) * along).T
        squares = waves.products @ weight
        squares -= np.stack([along[:, 0] ** 2, along[:, 0] * along[:, 1], along[:, 1] ** 2], 1)
        of_cosine, both, of_sine = squares.T
        value = cosine**2 * of_sine - 2 * cosine * sine * both + sine**2 * of_cosine
        return value / (of_cosine * of_sine - both**2)


class Scan(NamedTuple):
    """What columns of numbers gain in the noise of a record, its ramps beside them."""

    blocks: Blocks
    stretches: list[Stretch]

    @property
    def white(self) -> Float[np.ndarray, " orders"]:
        """The coefficients of all stretches in white noise."""
        return np.concatenate([stretch.white for stretch in self.stretches])

    def gains(
        self, columns: Float[np.ndarray, "blocks sets columns"]
    ) -> Float[np.ndarray, " sets"]:
        """What generalised least squares gains by each set of columns beside the ramps."""
        beside = self._beside_ramps(columns.reshape(len(columns), -1))
        sets = np.moveaxis(beside.reshape(-1, *columns.shape[1:]), 0, 2)
        along = sets @ self.white
        # What is constant gains nothing.
        gram = sets @ sets.swapaxes(1, 2) + _NEXT_TO_NOTHING * np.eye(columns.shape[2])
        return np.sum(along * np.linalg.solve(gram, along[..., None])[..., 0], axis=1)

    def directions(
        self, columns: Float[np.ndarray, "blocks columns"]
    ) -> Float[np.ndarray, "orders columns"]:
        """The unit vector of each column in white noise, at right angles to the ramps."""
        beside = self._beside_ramps(columns)
        return beside / np.linalg.norm(beside, axis=0)

    def _beside_ramps(
        self, columns: Float[np.ndarray, "blocks columns"]
    ) -> Float[np.ndarray, "orders columns"]:
        parts = np.split(columns, np.cumsum(self.blocks.counts)[:-1])
        return np.concatenate(
            [stretch.beside_ramp(part) for stretch, part in zip(self.stretches, parts, strict=True)]
        )


def block_coefficients(
    columns: Float[np.ndarray, "blocks *columns"], scale: float, orders: np.ndarray
) -> Float[np.ndarray, "orders *columns"]:
    """Cosine coefficients of means, as those of samples."""
    centred = columns - columns.mean(axis=0)
    return scale * np.asarray(dct(centred, axis=0, norm="ortho"))[orders]


def length_of(piece: tuple[int, int]) -> int:
    """Samples of a stretch, given where it begins and ends."""
    return piece[1] - piece[0]
