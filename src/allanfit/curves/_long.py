"""Allan variance of a record longer than memory, from its blocks as they come.

Small sizes share one cosine transform; large ones, which need few positions, are added up from
running sums. All is done on the host, whose transforms are as fast as the samples are read.
"""

from collections.abc import Sequence

import numpy as np
import scipy.fft
from jaxtyping import Float, Int

from ._rows import ROW, Waiting

# Positions of a cluster within its own length that are enough: with white noise, leaving out the
# others moves the variance by a thousandth of its standard error.
_POSITIONS = 1024
# Rows whose ends, and sums whose differences, are taken together: threads that do much at a time
# are seldom in each other's way.
_ROWS, _TOGETHER = 4, 2**17
# The largest size whose differences across the ends of rows are few beside those within.
_NEAR = ROW // 32
# The phase before all samples.
_START = np.zeros(1)


class LongAllanVariance:
    """The overlapping Allan variance [u^2] of samples [u] that are handed over block by block.

    Sizes up to 8192 take all positions, as `allanfit.allan_variance` does, and equal it to
    rounding. A larger size n takes every s-th position, where s is the largest power of two that
    divides n and is at most n/1024: what that leaves out is below 0.2 % of the standard error for
    white noise, less for what is slower; for quantization noise alone, which no record shows at
    such averaging times, it is more. Memory does not grow with the record.

    **Arguments:**

    - `cluster_sizes`: increasing positive integers; `allanfit.cluster_sizes(samples)` for the
      record's length. An odd size above 8192 takes all its positions, and so its
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
        near, far = sizes[sizes <= _NEAR], sizes[sizes > _NEAR]
        self._exact = [_Exact(near)] if len(near) else []
        strides = _strides(far)
        # Of running sums every so many samples are enough.
        self._spacing = int(strides.min(initial=_NEAR))
        self._levels = [
            _Level(int(s) // self._spacing, far[strides == s], self._spacing)
            for s in np.unique(strides)
        ]
        self._samples = 0
        self._before = 0
        self._offset = 0.0
        #: Samples since the last of the sums over `_spacing`, and sums not yet taken to the levels.
        self._since = np.zeros(0)
        self._sums = Waiting(_TOGETHER)
        #: The running sum, and of how many.
        self._phase, self._phases = 0.0, 0

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
        for exact in self._exact:
            exact.add(x)
        if self._levels:
            self._add_phase(x)
        self._samples += x.size

    def _add_phase(self, x: Float[np.ndarray, " samples"]) -> None:
        known = np.concatenate([self._since, x]) if self._since.size else x
        whole = known.size // self._spacing * self._spacing
        self._since = known[whole:].copy()
        # Not by BLAS, whose threads would wait for one another on a busy machine.
        sums = np.einsum("ij->i", known[:whole].reshape(-1, self._spacing))
        for together in self._sums.add(sums - self._offset * self._spacing):
            self._take_sums(together)

    def _take_sums(self, sums: Float[np.ndarray, " sums"]) -> None:
        if sums.size:
            phase = self._phase + np.cumsum(sums)
            for level in self._levels:
                level.add(phase, self._phases + 1)
            self._phase = float(phase[-1])
            self._phases += phase.size

    def _take_waiting(self) -> None:
        self._take_sums(self._sums.rest)
        self._sums.clear()

    def share(self, power: Float[np.ndarray, " row"]) -> None:
        """Leave it to somebody else to add up the power of the cosines of whole rows.

        They take the same stretches in rows of `ROW` samples, and add to `power` in place.
        """
        for exact in self._exact:
            exact.power, exact.shared = power, True

    def end_stretch(self) -> None:
        """What comes next is behind a gap: stretches add, as in a fit."""
        self._take_waiting()
        for each in (*self._exact, *self._levels):
            each.end()
        self._before += self._samples
        self._samples, self._since = 0, np.zeros(0)
        self._phase, self._phases = 0.0, 0

    def value(self) -> Float[np.ndarray, " sizes"]:
        """The variances so far, NaN for sizes beyond half of the longest stretch."""
        self._take_waiting()
        every = [*self._exact, *self._levels]
        parts = [each.value() for each in every]
        sizes = np.concatenate([each.sizes for each in every])
        return np.concatenate(parts)[np.argsort(sizes)]


class _Exact:
    """Sizes that take every position.

    A row of samples, mirrored at its ends, goes round in a circle. There the squared differences of
    adjacent sums add up to the powers of the row's cosines, each times what such a difference
    passes (Parseval), for all sizes from one transform. The circle has every difference within the
    row twice, and those across its two ends, which are taken off; those across the joint of two
    rows are added.
    """

    def __init__(self, sizes: Int[np.ndarray, " sizes"]):
        self.sizes = sizes
        self._reach = 2 * int(sizes.max())
        #: Of the cosines of all rows, and whether somebody else adds it up.
        self.power = np.zeros(ROW)
        self.shared = False
        #: Squared differences that are in no row.
        self._across = np.zeros(len(sizes))
        self._positions = np.zeros(len(sizes))
        self._waiting = Waiting(ROW)
        #: The ends of rows whose joints have not been looked at, and the end of the row before.
        self._heads, self._tails = np.empty((2, _ROWS, self._reach))
        self._rows = 0
        self._before = np.zeros(0)

    def add(self, x: Float[np.ndarray, " samples"]) -> None:
        for row in self._waiting.add(x):
            self._take_row(row)

    def end(self) -> None:
        if self._waiting.full:
            self._take_row(self._waiting.rest)
            self._waiting.clear()
        self._join()
        across, positions = self._rest()
        self._across += across
        self._positions += positions
        self._before = np.zeros(0)
        self._waiting.clear()

    def value(self) -> Float[np.ndarray, " sizes"]:
        self._join()
        across, positions = self._rest()
        within = _within(self.power, self.sizes)
        with np.errstate(invalid="ignore"):
            sums = (within + self._across + across) / (2.0 * self.sizes.astype(float) ** 2)
            return sums / (self._positions + positions)

    def _take_row(self, row: Float[np.ndarray, " row"]) -> None:
        self._heads[self._rows] = row[: self._reach]
        self._tails[self._rows] = row[-self._reach :]
        self._rows += 1
        if not self.shared:
            # A constant changes no difference; less about its mean a row is exact to more digits.
            row -= row.mean()
            cosines = np.asarray(scipy.fft.dct(row, norm="ortho", overwrite_x=True))
            self.power += cosines * cosines
        if self._rows == _ROWS:
            self._join()

    def _join(self) -> None:
        """Take the differences across the ends of rows."""
        if not self._rows:
            return
        first, last = self._heads[: self._rows], self._tails[: self._rows]
        continued = self._before.size > 0
        before = np.concatenate([self._before[None], last[:-1]]) if continued else last[:-1]
        joints = _phase(before, first if continued else first[1:])
        # Both sides of a mirror have the same differences.
        mirrors = np.concatenate([_phase(first[:, ::-1], first), _phase(last, last[:, ::-1])])
        for place, n in enumerate(self.sizes.tolist()):
            self._across[place] += _across(joints, n, 2 * n - 1) - _across(mirrors, n, n - 1)
        self._positions += self._rows * ROW - (0 if continued else 2 * self.sizes - 1)
        self._before = last[-1].copy()
        self._rows = 0

    def _rest(self) -> tuple[Float[np.ndarray, " sizes"], Float[np.ndarray, " sizes"]]:
        """Squared differences of the samples that do not fill a row, and how many."""
        known = np.concatenate([self._before, self._waiting.rest])
        phase = np.append(0.0, np.cumsum(known - known[:1]))
        fresh = self._before.size + 1
        every = _Level(1, self.sizes, known=phase[:fresh])
        every.add(phase[fresh:], fresh)
        return every.sums, every.counts


def _within(
    power: Float[np.ndarray, " row"], sizes: Int[np.ndarray, " sizes"]
) -> Float[np.ndarray, " sizes"]:
    """Sums of squared differences in the circles of rows, from the power of their cosines.

    The difference of adjacent sums passes |H|^2 = 4 sin^4(n w/2)/sin^2(w/2) at w = pi k/row.
    """
    order = np.arange(1, ROW)
    weighted = 4 * power[1:] / np.sin(np.pi * order / (2 * ROW)) ** 2
    # Sines of whole parts of a turn repeat.
    fourth = np.sin(np.pi * np.arange(2 * ROW) / (2 * ROW)) ** 4
    return np.array([weighted @ fourth[n * order % (2 * ROW)] for n in sizes.tolist()])


def _phase(
    before: Float[np.ndarray, "joints reach"], after: Float[np.ndarray, "joints reach"]
) -> Float[np.ndarray, "joints places"]:
    """Running sums over joints, which are in the middle."""
    # First a zero, which stays one.
    every = np.concatenate([np.zeros((len(before), 1)), before, after], axis=1)
    every[:, 1:] -= every[:, 1:].mean(axis=1, keepdims=True)
    return np.cumsum(every, axis=1, out=every)


def _across(phase: Float[np.ndarray, "joints places"], n: int, windows: int) -> float:
    """The sum of squared differences of sums of n samples across joints.

    Of `windows` of them, from that which has one sample behind the joint.
    """
    first = phase.shape[1] // 2 + 1
    difference = phase[:, first - n : first - n + windows] * -2.0
    difference += phase[:, first : first + windows]
    difference += phase[:, first - 2 * n : first - 2 * n + windows]
    return float(np.einsum("ij,ij->", difference, difference))


class _Level:
    """Sizes that share a stride between positions.

    The phase is handed over once in `spacing` samples, and every `stride`-th is taken.
    """

    def __init__(
        self,
        stride: int,
        sizes: Int[np.ndarray, " sizes"],
        spacing: int = 1,
        known: Float[np.ndarray, " places"] = _START,
    ):
        self.stride, self.sizes = stride, sizes
        self._steps = sizes // (stride * spacing)
        self.sums = np.zeros(len(sizes))
        self.counts = np.zeros(len(sizes))
        #: As much of the phase as the longest difference reaches back.
        self._tail = known

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
        self._tail = _START

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
