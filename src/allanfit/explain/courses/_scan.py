"""Where in a record courses are looked for: scans of means over blocks, in the noise as it is."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import dct, dst

from .._chance import course_log_chance
from ..spectrum._ordinates import Ordinates
from ..spectrum._search import Model
from ..spectrum._structure import Data
from ._course import Course, late, ordinate_variance, oscillation, step, warm_up

# Courses are looked for in means over at most this many blocks of a stretch.
_BLOCKS = 4096
# And steps, which are sharp.
_FINE_BLOCKS = 65536
# Of which each is of a few samples at most.
_FINEST_BLOCKS = 2**21
# A shorter stretch of a record with gaps is looked at if it has so many of these, and for steps, so
# many samples; slow courses are looked for in so many stretches.
_FEWEST_BLOCKS, _LONG, _SLOW_PIECES = 32, 256, 4
_SHORTLIST = 3
# Log of the chance of a scan's maximum below which a course is fitted at all.
_WORTH = float(np.log(0.3))
# Slower than this many periods in the record, an oscillation is no line yet.
_FEWEST_PERIODS, _TOO_FEW_PERIODS = 1.5, 1.0
_MOST_PERIODS = 160
# White noise of so many times Q^2/N^2 samples is stronger than one error of the angle.
_FIRST_ERROR = 4.0
# A sensor follows its surroundings late by such parts of the record, or its thermometer does.
_LAGS = (0.0, 0.003, 0.01, 0.03, 0.1, -0.003, -0.01, -0.03, -0.1)


def propose(
    samples: int,
    pieces: tuple[tuple[int, int], ...],
    values: Float[np.ndarray, " samples"],
    spectrum: Ordinates,
    model: Model,
    data: Data,
    drivers: dict[str, Float[np.ndarray, "samples columns"]],
) -> list[Course]:
    """The courses that look most promising, a few of each name.

    Block means of the stretches, and a scan that keeps the noise as it is; once as fitted, and
    once with nearly no random walk, since a course hides behind the walk that it made.
    """
    longest = max(pieces, key=_length)
    slow = _blocks(values, sorted(sorted(pieces, key=_length)[-_SLOW_PIECES:]))
    fine = _blocks(values, [p for p in pieces if p == longest or _length(p) >= _LONG], _FINE_BLOCKS)
    flat = ordinate_variance(spectrum, model, data)
    calm = model._replace(
        theta=np.where(np.arange(model.theta.size) == 3, model.theta - 4.0, model.theta)
    )
    found: list[Course] = []
    # How far a scan goes is a matter of the noise that is believed in.
    paths: dict[str, float] = {}
    # The first and the last error of the angle are rates of which no spectrum knows, soon over.
    brief = _FIRST_ERROR * float(np.exp(np.clip(model.theta[0] - model.theta[1], -50, 50)))
    for variance in (flat, ordinate_variance(spectrum, calm, data)):
        scan = slow.scan(spectrum, variance)
        found += _oscillations(scan, longest, samples)
        found += _warm_ups(scan, samples, paths, brief)
        found += _steps(fine.scan(spectrum, variance), samples, paths, brief)
    for name, columns in drivers.items():
        found += _driven(name, columns, samples)
    return found


def _length(piece: tuple[int, int]) -> int:
    return piece[1] - piece[0]


class _Blocks(NamedTuple):
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

    def scan(self, spectrum: Ordinates, variance: Float[np.ndarray, " ordinates"]) -> "_Scan":
        """A scan in noise that gives the ordinates of the record this variance."""
        stretches, time, scale = [], self.time, np.sqrt(self.size)
        for means, first in zip(self.means, np.cumsum([0, *self.counts]), strict=False):
            orders = np.arange(1, max(means.size // 2, 2))
            at = orders / (2 * means.size * self.size)
            weight = np.interp(at, spectrum.frequency, variance) / 2
            amplitude, ramp = (
                _coefficients(each, scale, orders)
                for each in (means, time[first : first + means.size])
            )
            stretches.append(_Stretch(amplitude, ramp, weight, scale, orders, means.size))
        return _Scan(self, stretches)

    @property
    def counts(self) -> list[int]:
        """How many blocks each stretch has."""
        return [means.size for means in self.means]


def _blocks(
    values: Float[np.ndarray, " samples"], pieces: list[tuple[int, int]], most: int = _BLOCKS
) -> _Blocks:
    """`most` blocks in the longest stretch, and as long ones in those that hold enough."""
    longest = max(_length(piece) for piece in pieces)
    size = max(1, longest // most)
    kept = [p for p in pieces if _length(p) >= min(_FEWEST_BLOCKS * size, longest)]
    ends = [stop - (stop - start) % size for start, stop in kept]
    means = [
        values[start:end].reshape(-1, size).mean(axis=1)
        for (start, _), end in zip(kept, ends, strict=True)
    ]
    return _Blocks(means, [start for start, _ in kept], size)


class _Stretch(NamedTuple):
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
        moved = _coefficients(columns, self.scale, self.orders) / root[:, None]
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


class _Scan(NamedTuple):
    blocks: _Blocks
    stretches: list[_Stretch]

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


def _coefficients(
    columns: Float[np.ndarray, "blocks *columns"], scale: float, orders: np.ndarray
) -> Float[np.ndarray, "orders *columns"]:
    """Cosine coefficients of means, as those of samples."""
    centred = columns - columns.mean(axis=0)
    return scale * np.asarray(dct(centred, axis=0, norm="ortho"))[orders]


def _path(cosines: Float[np.ndarray, " steps"]) -> float:
    """The length of a path on the sphere, from the cosines of its steps."""
    return float(np.sum(np.arccos(np.clip(np.abs(cosines), 0.0, 1.0))))


def _oscillations(scan: _Scan, longest: tuple[int, int], samples: int) -> list[Course]:
    """Each stretch by itself at first, and near what is best all of them with one phase."""
    blocks, length = scan.blocks, _length(longest)
    most = max(blocks.counts)
    periods = np.arange(_FEWEST_PERIODS, min(_MOST_PERIODS, most / 8), 0.25)
    if periods.size == 0:
        return []
    gains, sizes = np.zeros(periods.size), 0
    for stretch in scan.stretches:
        part = stretch.count * blocks.size / length
        # Too few periods in a shorter stretch are no more than its ramp.
        heard = periods * part > _TOO_FEW_PERIODS
        if heard.any():
            gains[heard] += stretch.gains(_slow_waves(stretch.count, part, periods.size)[heard])
            sizes += 2
    courses, time = [], blocks.time - longest[0]
    every = np.arange(samples) - float(longest[0])
    # Each whole period is a place of its own, and the best lies between them.
    places = 3.0 * float(periods[-1])
    reach = float(time[-1] - time[0]) / length
    closely = 2 * int(np.ceil(4 * min(reach, _SLOW_PIECES))) + 1
    for at in _tops(gains, 4, sizes, places):
        fine = (periods[at] + np.linspace(-0.25, 0.25, closely)) / length
        each = [scan.gain(oscillation(float(frequency), time).draw()) for frequency in fine]
        best_place = float(fine[int(np.argmax(each))])
        courses.append(oscillation(best_place, every)._replace(places=places))
    return courses


@lru_cache(maxsize=_SLOW_PIECES)
def _slow_waves(count: int, part: float, waves: int) -> Float[np.ndarray, "waves two orders"]:
    """Cosine coefficients of the cosines and sines that are looked for in every round.

    The `count` blocks of a stretch are a `part` of the longest, in which periods are counted.
    """
    periods = (_FEWEST_PERIODS + 0.25 * np.arange(waves)) * part
    angle = 2 * np.pi * periods[:, None] * (np.arange(count) + 0.5) / count
    columns = np.stack([np.cos(angle), np.sin(angle)], axis=1).reshape(-1, count)
    found = _coefficients(columns.T, 1.0, np.arange(1, max(count // 2, 2)))
    return np.ascontiguousarray(found.T).reshape(len(periods), 2, -1)


def _warm_ups(scan: _Scan, samples: int, paths: dict[str, float], brief: float) -> list[Course]:
    """With constants from a part of the record on, and longer than what is `brief`."""
    time = scan.blocks.time
    length = float(time[-1])
    shortest = min(max(length / 300, 4 * scan.blocks.size, brief), length / 8)
    constants = np.geomspace(shortest, length / 1.5, 24)
    ways = np.stack([scan.directions(np.exp(-time / c)[:, None])[:, 0] for c in constants])
    path = paths.setdefault("warm_up", _path(np.sum(ways[1:] * ways[:-1], axis=1)))
    gains = (ways @ scan.white) ** 2
    return [
        warm_up(float(constants[at]), samples)._replace(length=path)
        for at in _tops(gains, 3, 1, 1.0, path)[:1]
    ]


def _steps(scan: _Scan, samples: int, paths: dict[str, float], brief: float) -> list[Course]:
    """No nearer to the ends of a stretch than what is `brief`."""
    every, times, path = [np.zeros(0)], [np.zeros(0)], 0.0
    for stretch, start in zip(scan.stretches, scan.blocks.starts, strict=True):
        gains, length = _step_gains(stretch, brief / scan.blocks.size)
        every.append(gains)
        within = np.arange(1, gains.size + 1) / (gains.size + 1)
        times.append(within * (stretch.count * scan.blocks.size) + start)
        path += length
    gains, at = np.concatenate(every), np.concatenate(times)
    path = paths.setdefault("step", path)
    return [
        step(round(at[i]), samples)._replace(length=path)
        for i in _tops(gains, gains.size // 85, 1, 1.0, path)
    ]


def _step_gains(stretch: _Stretch, brief: float) -> tuple[Float[np.ndarray, " places"], float]:
    """What steps gain at evenly spaced places within a stretch, and the length of their path.

    None nearer to its ends than `brief` blocks.
    """
    top, bottom, beside = _step_sums(stretch)
    gains = top**2 / bottom
    path = _path(beside / np.sqrt(bottom[1:] * bottom[:-1]))
    # A step at the very ends is an outlier or a ramp, or an error of the angle.
    places = gains.size + 1
    ends = int(np.ceil(places * min(max(1 / 256, brief / stretch.count), 1 / 8)))
    gains[:ends] = gains[-ends:] = 0.0
    return gains, path


def _step_sums(
    stretch: _Stretch,
) -> tuple[
    Float[np.ndarray, " places"], Float[np.ndarray, " places"], Float[np.ndarray, " between"]
]:
    """Products of the record with steps at evenly spaced places, their squares, and of neighbours.

    In white noise, at right angles to the ramp.
    """
    # The cosine coefficients of a step at g blocks are a sine of g: a sine transform has all
    # positions at once. Where a random walk is strong, a step is known to a few samples, and a
    # scan must be as fine.
    orders, places = stretch.orders, 2 ** int(np.ceil(np.log2(stretch.count)))
    half = 2 * np.sin(np.pi * orders / (2 * stretch.count))
    unit = -np.sqrt(2 / stretch.count) * stretch.scale / half
    ramp = stretch.ramp / stretch.variance
    top = _sines(stretch.amplitude * unit / stretch.variance, places)
    bottom = _products(unit**2 / stretch.variance, places, 0)
    across = _sines(ramp * unit, places)
    norm = ramp @ stretch.ramp
    top = top - across * (ramp @ stretch.amplitude) / norm
    bottom = np.maximum(bottom - across**2 / norm, 1e-12 * bottom)
    beside = _products(unit**2 / stretch.variance, places, 1)[:-1]
    beside -= across[1:] * across[:-1] / norm
    return top, bottom, beside


class StepScores(NamedTuple):
    """How a step at places of one stretch stands out."""

    start: int
    stop: int
    #: Samples of the record, how tall what is there stands in standard deviations, and as how tall
    #: a step of one unit would [1/u].
    at: Float[np.ndarray, " places"]
    scores: Float[np.ndarray, " places"]
    known: Float[np.ndarray, " places"]


def step_scores(
    values: Float[np.ndarray, " samples"],
    pieces: list[tuple[int, int]],
    spectrum: Ordinates,
    variance: Float[np.ndarray, " ordinates"],
) -> list[StepScores]:
    """Steps in each stretch, as fine as it is, in noise that gives the ordinates this variance."""
    blocks = _blocks(values, pieces, _FINEST_BLOCKS)
    found = []
    for stretch, start in zip(
        blocks.scan(spectrum, variance).stretches, blocks.starts, strict=True
    ):
        top, bottom, _ = _step_sums(stretch)
        length = stretch.count * blocks.size
        at = start + np.arange(1, top.size + 1) / (top.size + 1) * length
        known = np.sqrt(bottom)
        found.append(StepScores(start, start + length, at, top / known, known))
    return found


def _sines(of_order: Float[np.ndarray, " orders"], places: int) -> Float[np.ndarray, " inner"]:
    """Sums over orders k from 1 on of what is given times sin(pi k i/places), 0 < i < places."""
    return np.asarray(dst(np.pad(of_order, (0, places - 1 - of_order.size)), type=1)) / 2


def _products(
    of_order: Float[np.ndarray, " orders"], places: int, apart: int
) -> Float[np.ndarray, " inner"]:
    """The same of products of sines at i and at i + `apart`, none or one."""
    # sin a sin b = (cos(a - b) - cos(a + b))/2, and a + b goes round twice.
    orders = np.arange(1, of_order.size + 1)
    turned = of_order * np.exp(1j * np.pi * orders * apart / places)
    sums = np.fft.fft(np.pad(turned, (1, places - 1 - orders.size)).conj()).real[1:]
    return (np.sum(of_order * np.cos(np.pi * orders * apart / places)) - sums) / 2


def _driven(name: str, columns: Float[np.ndarray, "samples columns"], samples: int) -> list[Course]:
    if name != "temperature":
        return [Course(name, lambda: columns, columns.shape[1], {})]
    felt = columns[:, 0]
    return [late(felt, lag * samples)._replace(places=float(len(_LAGS))) for lag in _LAGS]


def _tops(
    gains: Float[np.ndarray, " gains"], apart: int, sizes: int, places: float, path: float = 0.0
) -> list[int]:
    """The highest places that are worth a fit, none within `apart` of a higher one."""
    known = 1e9
    left = gains.copy()
    tops = []
    for _ in range(_SHORTLIST):
        at = int(np.argmax(left))
        if left[at] <= 0 or course_log_chance(left[at], sizes, known, places, path) >= _WORTH:
            break
        tops.append(at)
        left[max(0, at - apart) : at + apart + 1] = 0.0
    return tops


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
    coarse, fine = _blocks(values, whole, _BLOCKS), _blocks(values, whole, _FINE_BLOCKS)
    # Every place first, then ever closer ones.
    most = reach // coarse.size
    every = coarse.size * np.arange(-most, most + 1)
    halves = coarse.size / 2.0 ** np.arange(max(np.log2(coarse.size / fine.size), 0) + 1)
    closer = [half * np.array([-1, 0, 1]) for half in halves if half <= reach]
    for blocks, rounds in ((coarse, [every, every]), (fine, closer)):
        scan, time = blocks.scan(spectrum, variance), blocks.time

        def gain(at: Float[np.ndarray, " edges"], scan: _Scan = scan, time=time) -> float:
            told = 2 * ends @ before[np.clip(np.round(at).astype(int), 0, odds.size)]
            return scan.gain(_between(at, time, first)[:, None].astype(float)) + float(told)

        for moves in rounds:
            for i in range(edges.size):
                tried = np.where(np.arange(edges.size) == i, edges + moves[:, None], edges)
                # Edges that change places would swap what is loud.
                tried = tried[np.all(np.diff(tried) > 0, axis=1)]
                edges = max(tried, key=gain)
    return _between(edges, np.arange(loud.size) + 0.5, first)


def _between(
    edges: Float[np.ndarray, " edges"], time: Float[np.ndarray, " times"], first: bool
) -> Bool[np.ndarray, " times"]:
    """Whether it is loud at some times; `first` before all edges."""
    return (np.searchsorted(edges, time) % 2 == 1) != first
