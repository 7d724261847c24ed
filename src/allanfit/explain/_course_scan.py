"""Where in a record courses are looked for: scans of means over blocks, in the noise as it is."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import dct, dst

from ._chance import course_log_chance
from ._means import Course, late, ordinate_variance, oscillation, step, warm_up
from ._ordinates import Ordinates
from ._search import Model
from ._structure import Data

# Courses are looked for in means over at most this many blocks of the record.
_BLOCKS = 4096
# And steps, which are sharp.
_FINE_BLOCKS = 65536
_SHORTLIST = 3
# Log of the chance of a scan's maximum below which a course is fitted at all.
_WORTH = float(np.log(0.3))
# Slower than this many periods in the record, an oscillation is no line yet.
_FEWEST_PERIODS = 1.5
_MOST_PERIODS = 160
# A sensor follows its surroundings late by such parts of the record.
_LAGS = (0.0, 0.003, 0.01, 0.03, 0.1)


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

    In the longest stretch, block means and a scan that keeps the noise as it is; once as fitted,
    and once with nearly no random walk, since a course hides behind the walk that it made.
    """
    start, stop = max(pieces, key=lambda piece: piece[1] - piece[0])
    length = stop - start
    blocks = _blocks(values[start:stop])
    flat = ordinate_variance(spectrum, model, data)
    calm = model._replace(
        theta=np.where(np.arange(model.theta.size) == 3, model.theta - 4.0, model.theta)
    )
    found: list[Course] = []
    # How far a scan goes is a matter of the noise that is believed in.
    paths: dict[str, float] = {}
    time = blocks.time
    fine = _blocks(values[start:stop], _FINE_BLOCKS)
    for variance in (flat, ordinate_variance(spectrum, calm, data)):
        scan = blocks.scan(spectrum, variance)
        found += _oscillations(scan, time, length, start, samples)
        found += _warm_ups(scan, time, length, samples, paths)
        scan = fine.scan(spectrum, variance)
        found += _steps(scan, fine.means.size, fine.size, start, samples, paths)
    for name, columns in drivers.items():
        found += _driven(name, columns, samples)
    return found


class _Blocks(NamedTuple):
    """Means over blocks of a stretch."""

    means: Float[np.ndarray, " blocks"]
    #: Samples in each.
    size: int

    @property
    def time(self) -> Float[np.ndarray, " blocks"]:
        """The middles of the blocks, in samples of the stretch."""
        return (np.arange(self.means.size) + 0.5) * self.size

    def scan(self, spectrum: Ordinates, variance: Float[np.ndarray, " ordinates"]) -> "_Scan":
        """A scan in noise that gives the ordinates of the record this variance."""
        scale, count = np.sqrt(self.size), self.means.size
        orders = np.arange(1, max(count // 2, 2))
        weight = np.interp(orders / (2 * count * self.size), spectrum.frequency, variance) / 2
        means, time = (_coefficients(each, scale, orders) for each in (self.means, self.time))
        return _Scan(means, time, weight, scale, orders)


def _blocks(values: Float[np.ndarray, " samples"], most: int = _BLOCKS) -> _Blocks:
    size = max(1, values.size // most)
    count = values.size // size
    return _Blocks(values[: count * size].reshape(count, size).mean(axis=1), size)


class _Scan(NamedTuple):
    amplitude: Float[np.ndarray, " orders"]
    ramp: Float[np.ndarray, " orders"]
    variance: Float[np.ndarray, " orders"]
    scale: float
    orders: np.ndarray

    def gain(self, columns: Float[np.ndarray, "blocks columns"]) -> float:
        """What generalised least squares gains by some columns beside the ramp."""
        projected = self.directions(columns).T @ (self.amplitude / np.sqrt(self.variance))
        return float(np.sum(projected**2))

    def gains(self, waves: Float[np.ndarray, "waves two orders"]) -> Float[np.ndarray, " waves"]:
        """The same of each cosine and its sine, given as their coefficients for a scale of one."""
        root = np.sqrt(self.variance)
        ramp = self.ramp / root
        ramp /= np.sqrt(ramp @ ramp)
        beside = waves * self.scale / root
        beside -= (beside @ ramp)[..., None] * ramp
        # What is left of the amplitudes at right angles to the ramp matters alone.
        along = beside @ (self.amplitude / root)
        gram = beside @ beside.swapaxes(1, 2)
        return np.sum(along * np.linalg.solve(gram, along[..., None])[..., 0], axis=1)

    def directions(
        self, columns: Float[np.ndarray, "blocks columns"]
    ) -> Float[np.ndarray, "orders columns"]:
        """Unit vectors of some columns in white noise, at right angles to the ramp."""
        moved = _coefficients(columns, self.scale, self.orders)
        root = np.sqrt(self.variance)
        basis, _ = np.linalg.qr(np.column_stack([self.ramp, moved]) / root[:, None])
        return basis[:, 1:]


def _coefficients(
    columns: Float[np.ndarray, "blocks *columns"], scale: float, orders: np.ndarray
) -> Float[np.ndarray, "orders *columns"]:
    """Cosine coefficients of means, as those of samples."""
    centred = columns - columns.mean(axis=0)
    return scale * np.asarray(dct(centred, axis=0, norm="ortho"))[orders]


def _path(cosines: Float[np.ndarray, " steps"]) -> float:
    """The length of a path on the sphere, from the cosines of its steps."""
    return float(np.sum(np.arccos(np.clip(np.abs(cosines), 0.0, 1.0))))


def _oscillations(scan: _Scan, time, length, start, samples) -> list[Course]:
    periods = np.arange(_FEWEST_PERIODS, min(_MOST_PERIODS, time.size / 8), 0.25)
    if periods.size == 0:
        return []
    gains = scan.gains(_slow_waves(time.size, float(time[-1] / length), periods.size))
    courses = []
    # Each whole period is a place of its own, and the best lies between them.
    places = 3.0 * float(periods[-1])
    for at in _tops(gains, 4, 2, places):
        fine = periods[at] + np.linspace(-0.25, 0.25, 9)
        values = scan.gains(_waves(fine, time.size, float(time[-1] / length)))
        best_place = float(fine[int(np.argmax(values))]) / length
        courses.append(
            oscillation(best_place, np.arange(samples) - float(start))._replace(places=places)
        )
    return courses


@lru_cache(maxsize=2)
def _slow_waves(count: int, end: float, waves: int) -> Float[np.ndarray, "waves two orders"]:
    """Those that are looked for in every round, in all of one record."""
    return _waves(_FEWEST_PERIODS + 0.25 * np.arange(waves), count, end)


def _waves(
    periods: Float[np.ndarray, " waves"], count: int, end: float
) -> Float[np.ndarray, "waves two orders"]:
    """Cosine coefficients of cosines and sines, so many periods in a stretch.

    The middles of the `count` blocks lie within the part `end` of the stretch.
    """
    angle = 2 * np.pi * periods[:, None] * (np.arange(count) + 0.5) / (count - 0.5) * end
    columns = np.stack([np.cos(angle), np.sin(angle)], axis=1).reshape(-1, count)
    found = _coefficients(columns.T, 1.0, np.arange(1, max(count // 2, 2)))
    return np.ascontiguousarray(found.T).reshape(len(periods), 2, -1)


def _warm_ups(scan: _Scan, time, length, samples, paths) -> list[Course]:
    constants = np.geomspace(max(length / 300, 4 * (time[1] - time[0])), length / 1.5, 24)
    ways = np.stack([scan.directions(np.exp(-time / c)[:, None])[:, 0] for c in constants])
    path = paths.setdefault("warm_up", _path(np.sum(ways[1:] * ways[:-1], axis=1)))
    gains = (ways @ (scan.amplitude / np.sqrt(scan.variance))) ** 2
    return [
        warm_up(float(constants[at]), samples)._replace(length=path)
        for at in _tops(gains, 3, 1, 1.0, path)[:1]
    ]


def _steps(scan: _Scan, count, block, start, samples, paths) -> list[Course]:
    # The cosine coefficients of a step at g blocks are a sine of g: a sine transform has all
    # positions at once. Where a random walk is strong, a step is known to a few samples, and a
    # scan must be as fine.
    orders, places = scan.orders, 2 ** int(np.ceil(np.log2(count)))
    half = 2 * np.sin(np.pi * orders / (2 * count))
    unit = -np.sqrt(2 / count) * scan.scale / half
    ramp = scan.ramp / scan.variance
    top = _sines(scan.amplitude * unit / scan.variance, places)
    bottom = _products(unit**2 / scan.variance, places, 0)
    across = _sines(ramp * unit, places)
    norm = ramp @ scan.ramp
    top = top - across * (ramp @ scan.amplitude) / norm
    bottom = np.maximum(bottom - across**2 / norm, 1e-12 * bottom)
    gains = top**2 / bottom
    beside = _products(unit**2 / scan.variance, places, 1)[:-1]
    beside -= across[1:] * across[:-1] / norm
    path = paths.setdefault("step", _path(beside / np.sqrt(bottom[1:] * bottom[:-1])))
    # A step at the very ends is an outlier or a ramp.
    ends = -(-places // 256)
    gains[:ends] = gains[-ends:] = 0.0
    return [
        step(round((i + 1) / places * count * block) + start, samples)._replace(length=path)
        for i in _tops(gains, places // 85, 1, 1.0, path)
    ]


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
        return [Course(name, columns, {})]
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
) -> Bool[np.ndarray, " samples"]:
    """Loud times of a stretch with edges where a shift of the mean beside them explains most.

    Each edge is moved by `reach` samples at most. Noise that grows with time makes edges all that
    is known of a shift, and a shift that begins elsewhere is found too small.
    """
    edges, first = np.flatnonzero(np.diff(loud)) + 1.0, bool(loud[0])
    coarse, fine = _blocks(values, _BLOCKS), _blocks(values, _FINE_BLOCKS)
    # Every place first, then ever closer ones.
    every = np.arange(-reach, reach + 1, coarse.size)
    halves = coarse.size / 2.0 ** np.arange(max(np.log2(coarse.size / fine.size), 0) + 1)
    closer = [half * np.array([-1, 0, 1]) for half in halves]
    for blocks, rounds in ((coarse, [every, every]), (fine, closer)):
        scan, time = blocks.scan(spectrum, variance), blocks.time

        def gain(at: Float[np.ndarray, " edges"], scan: _Scan = scan, time=time) -> float:
            return scan.gain(_between(at, time, first)[:, None].astype(float))

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
