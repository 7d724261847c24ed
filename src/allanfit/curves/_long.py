"""Allan variance of a record longer than memory, from its blocks as they come.

Small sizes go through `overlapping_sums` in pieces of one length, compiled once; large ones, which
need few positions, are added up on the host.
"""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from ._allan import overlapping_sums

# Positions of a cluster within its own length that are enough: with white noise, leaving out the
# others moves the variance by a thousandth of its standard error.
_POSITIONS = 1024
# Samples of one piece: many times what the differences reach back, little beside any memory.
_PIECE = 2**18


class LongAllanVariance:
    """The overlapping Allan variance [u^2] of samples [u] that are handed over block by block.

    Sizes below 2048 take all positions, as `allanfit.allan_variance` does, and equal it to
    rounding. A larger size n takes every s-th position, where s is the largest power of two that
    divides n and is at most n/1024: what that leaves out is below 0.2 % of the standard error for
    white noise, less for what is slower; for quantization noise alone, which no record shows at
    such averaging times, it is more. Memory does not grow with the record.

    **Arguments:**

    - `cluster_sizes`: increasing positive integers; `allanfit.cluster_sizes(samples)` for the
      record's length. An odd size above 2048 takes all its positions, and so its
      time, and memory for twice as many samples.

    **Raises:** `ValueError` for sizes that are not increasing positive integers.

    ```python
    variance = LongAllanVariance(allanfit.cluster_sizes(samples))
    for block in blocks:
        variance.add(block)
    variance.value()
    ```

    `end_stretch` between blocks keeps differences from bridging a gap.
    """

    def __init__(self, cluster_sizes: Sequence[int] | np.ndarray):
        sizes = np.asarray(cluster_sizes)
        whole = sizes.ndim == 1 and len(sizes) > 0 and np.issubdtype(sizes.dtype, np.integer)
        if not whole or sizes[0] < 1 or np.any(np.diff(sizes) <= 0):
            raise ValueError(
                f"cluster_sizes must be increasing positive integers; got {cluster_sizes!r}"
            )
        self.cluster_sizes = sizes
        strides = _strides(sizes)
        every = sizes[strides == 1]
        # Sizes beyond a piece, odd ones among them, are not worth a piece of their own.
        near = every[2 * every <= _PIECE // 8]
        self._exact = [_Exact(near)] if len(near) else []
        self._levels = [
            _Level(int(s), mine)
            for s in np.unique(strides)
            if len(mine := np.setdiff1d(sizes[strides == s], near))
        ]
        self._samples = 0
        self._before = 0
        self._offset = 0.0
        self._phase = 0.0

    def add(self, block: Float[np.ndarray, " samples"] | np.ndarray) -> None:
        """Take the next samples.

        **Raises:** `ValueError` for a block of another shape or with values that are not finite.
        """
        x = np.asarray(block, np.float64)
        if x.ndim != 1:
            raise ValueError(f"a block must have shape (samples,); got {x.shape}")
        if not np.isfinite(x).all():
            bad = self._before + self._samples + int(np.argmin(np.isfinite(x)))
            raise ValueError(
                f"sample {bad} is not finite: hand over the stretches between gaps one by one"
            )
        if not x.size:
            return
        if not self._samples:
            # Less about its mean, the running sum stays small. A constant changes nothing.
            self._offset = float(x.mean())
        x = x - self._offset
        for exact in self._exact:
            exact.add(x)
        phase = self._phase + np.cumsum(x)
        for level in self._levels:
            level.add(phase, self._samples + 1)
        self._samples += x.size
        self._phase = float(phase[-1])

    def end_stretch(self) -> None:
        """What comes next is behind a gap: stretches add, as in a fit."""
        for each in (*self._exact, *self._levels):
            each.end()
        self._before += self._samples
        self._samples, self._phase = 0, 0.0

    def value(self) -> Float[np.ndarray, " sizes"]:
        """The variances so far, NaN for sizes beyond half of the longest stretch."""
        every = [*self._exact, *self._levels]
        parts = [each.value() for each in every]
        sizes = np.concatenate([each.sizes for each in every])
        return np.concatenate(parts)[np.argsort(sizes)]


class _Exact:
    """Sizes that take every position."""

    def __init__(self, sizes: Int[np.ndarray, " sizes"]):
        self.sizes = sizes
        self._reach = 2 * int(sizes.max())
        self._sums = np.zeros(len(sizes))
        self._positions = np.zeros(len(sizes))
        self._blocks: list[Float[np.ndarray, " samples"]] = []
        self._waiting = 0

    def add(self, x: Float[np.ndarray, " samples"]) -> None:
        self._blocks.append(x)
        self._waiting += x.size
        if self._waiting < _PIECE:
            return
        known = np.concatenate(self._blocks)
        step = _PIECE - self._reach
        begin = 0
        while begin + _PIECE <= known.size:
            piece = known[begin : begin + _PIECE]
            # Positions wholly within what the next piece begins with are counted there.
            self._sums += self._sums_of(piece) - self._sums_of(piece[step:])
            self._positions += step
            begin += step
        self._blocks = [known[begin:].copy()]
        self._waiting = known.size - begin

    def end(self) -> None:
        self._sums, self._positions = self._with_rest()
        self._blocks, self._waiting = [], 0

    def value(self) -> Float[np.ndarray, " sizes"]:
        sums, positions = self._with_rest()
        with np.errstate(invalid="ignore"):
            return sums / positions

    def _with_rest(self) -> tuple[Float[np.ndarray, " sizes"], Float[np.ndarray, " sizes"]]:
        """Sums and positions with those of the samples that do not fill a piece."""
        rest = np.concatenate([np.zeros(0), *self._blocks])
        positions = np.maximum(rest.size - 2 * self.sizes + 1, 0)
        sums = squared_differences(rest, self.sizes) / (2.0 * self.sizes**2)
        return self._sums + sums, self._positions + positions

    def _sums_of(self, x: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " sizes"]:
        # In float32 the sums would be carried in pairs, which is slower and less exact.
        with jax.enable_x64(True):
            return np.asarray(overlapping_sums(jnp.asarray(x), jnp.asarray(self.sizes)))


class _Level:
    """Sizes that share a stride between positions."""

    def __init__(self, stride: int, sizes: Int[np.ndarray, " sizes"]):
        self.stride, self.sizes = stride, sizes
        self._steps = sizes // stride
        self.sums = np.zeros(len(sizes))
        self.counts = np.zeros(len(sizes))
        #: As much of the phase as the longest difference reaches back: zero before all samples.
        self._tail = np.zeros(1)

    def add(self, phase: Float[np.ndarray, " samples"], first: int) -> None:
        """Take the phase at positions `first` and after."""
        fresh = phase[-first % self.stride :: self.stride]
        known = np.concatenate([self._tail, fresh])
        for place, step in enumerate(self._steps):
            begin = max(len(self._tail), 2 * step)
            if begin < len(known):
                end = len(known)
                difference = known[begin - step : end - step] * -2.0
                difference += known[begin:]
                difference += known[begin - 2 * step : end - 2 * step]
                # Not by BLAS, whose threads would wait for one another on a busy machine.
                self.sums[place] += np.einsum("i,i->", difference, difference)
                self.counts[place] += len(difference)
        self._tail = known[-2 * int(self._steps.max()) :].copy()

    def end(self) -> None:
        self._tail = np.zeros(1)

    def value(self) -> Float[np.ndarray, " sizes"]:
        with np.errstate(invalid="ignore"):
            return self.sums / self.counts / (2.0 * self.sizes.astype(float) ** 2)


def squared_differences(
    x: Float[np.ndarray, " samples"], sizes: Int[np.ndarray, " sizes"]
) -> Float[np.ndarray, " sizes"]:
    """Sums of squared differences of adjacent sums of n samples, over all positions, on the host.

    Zero for sizes beyond half of the samples.
    """
    every = _Level(1, sizes)
    every.add(np.cumsum(x), 1)
    return every.sums


def _strides(sizes: Int[np.ndarray, " sizes"]) -> Int[np.ndarray, " sizes"]:
    """The largest power of two that divides each size and leaves positions enough."""
    divides = sizes & -sizes
    enough = np.maximum(sizes // _POSITIONS, 1)
    return np.minimum(divides, 2 ** np.floor(np.log2(enough)).astype(sizes.dtype))
