"""Every ordinate of a record's mirror spectrum, and averages of them over any bins.

A fit of five smooth terms needs few bins. What is left out of it may be narrow, so that here all
ordinates are kept, on the host, and averaged as each question asks. Frequencies are in cycles per
sample and densities for a sampling interval of one, as in `curves`.
"""

from functools import lru_cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import scipy.fft
from jaxtyping import Array, Bool, Float, Float32, Int, Shaped
from scipy.ndimage import median_filter

from ...curves._bins import logarithmic_edges
from ...curves._design import NOISE_TERMS, expected_ordinates
from ...curves._spectrum import RampProjection
from ...physics import AngleCodes, Sampling
from .._intervals import runs

BINS_PER_DECADE = 48
# Bins of no weight fill a spectrum up to so many, or to a multiple of the second: one compilation
# serves most records, and short ones too.
_FEWEST, _PADDING = 256, 128
# Distances from the Nyquist frequency [cycles per sample] between which bins are finer.
_NEAR_NYQUIST = (0.05, 5e-4)
_BINS_NEAR_NYQUIST = 24
#: What leaks comes at the ends of the record, where a tenth of the noise is a disturbance.
LEAST = 10.0
# Of so many blocks for each of the first cosine coefficients, means give these within (pi/4)^2/24.
_BLOCKS_A_MODE = 4
# An order that is at a frequency to this part counts as there.
_ROUNDED = 1e-6
# Bins that a line fills at most.
_NARROW = 5
# Above this frequency [cycles per sample] the largest density says what the ends may leak.
_FAST = 0.01
#: Where leakage asks for a density: from zero to the Nyquist frequency [cycles per sample].
LEAKAGE_GRID = np.linspace(0.0, 0.5, 2049)
# Gauss-Legendre nodes of three points on (0, 1), exact to fifth order.
_NODES = np.array([0.5 - np.sqrt(0.15), 0.5, 0.5 + np.sqrt(0.15)])
_WEIGHTS = np.array([5, 8, 5]) / 18


class Ordinates(NamedTuple):
    """Squared cosine coefficients of all stretches, in order of frequency."""

    #: Cycles per sample, shape (ordinates,).
    frequency: Float[np.ndarray, " ordinates"]
    #: sqrt(2) c with the ramp projected out [u]: linear in the samples, and squared an ordinate.
    amplitude: Float[np.ndarray, " ordinates"]
    #: What unit powers of Q, N, B, K put there, shape (ordinates, 4). Seven digits are enough.
    expected: Float32[np.ndarray, "ordinates terms"]
    #: Which half of the record's ordinates each belongs to, for scores on what was not fitted.
    fold: Int[np.ndarray, " ordinates"]
    #: Samples of the longest stretch.
    longest: int
    #: How many ordinates count as one: more than one where the noise is not as strong at all
    #: times, which makes neighbours alike (mean of sigma^4 over the square of the mean sigma^2).
    dilution: float = 1.0
    #: Above this frequency, and in these bands, ordinates are what the ends of the record leak.
    top: float = 0.5
    holes: tuple[tuple[float, float], ...] = ()

    def clean(self, frequency: Float[np.ndarray, " _"]) -> Bool[np.ndarray, " _"]:
        """Whether ordinates at some frequencies are the noise's own."""
        kept = frequency <= self.top
        for low, high in self.holes:
            kept &= (frequency < low) | (frequency > high)
        return kept

    def less(self, mean: Float[np.ndarray, " ordinates"]) -> "Ordinates":
        """What is left when something with these amplitudes is taken out."""
        return self._replace(amplitude=self.amplitude - mean)


class Bins(NamedTuple):
    """Averages over bins, padded with bins of no weight; made for JAX."""

    #: Mean ordinate, shape (bins,) [u^2].
    density: Float[np.ndarray, " bins"] | Float[Array, " bins"]
    #: What unit powers of Q, N, B, K put there, shape (bins, 4).
    expected: Float[np.ndarray, "bins terms"] | Float[Array, "bins terms"]
    #: Half the number of ordinates: the shape of a Gamma variate.
    shape: Float[np.ndarray, " bins"] | Float[Array, " bins"]
    #: Three frequencies inside each bin, at which an effect's density is averaged.
    nodes: Float[np.ndarray, "bins three"] | Float[Array, "bins three"]

    @property
    def frequency(self) -> Float[np.ndarray, " bins"]:
        """Middle of each bin [cycles per sample]."""
        return np.asarray(self.nodes)[:, 1]

    @property
    def used(self) -> Bool[np.ndarray, " bins"]:
        """Which bins are no padding."""
        return np.asarray(self.shape) > 0


def averaged(values: Float[Array, "*shape three"]) -> Float[Array, "*shape"]:
    """The mean over each bin of what was computed at its `nodes`."""
    return values @ jnp.asarray(_WEIGHTS, values.dtype)


def points(frequency: Float[np.ndarray, " bins"]) -> Float[np.ndarray, "bins three"]:
    """The nodes of bins without width: a density is asked for at these frequencies."""
    return np.stack([frequency] * 3, axis=1)


def ordinates(
    pieces: tuple[Float[np.ndarray, " _"], ...],
    sampling: Sampling,
    codes: AngleCodes | None = None,
) -> Ordinates:
    """All ordinates of the stretches of a record, each of at least 16 samples [u]."""
    orders = [np.arange(2, x.size) for x in pieces]
    frequency = [order / (2 * x.size) for order, x in zip(orders, pieces, strict=True)]
    # Neighbours in pairs, so that each half has as many odd orders as even ones.
    fold = [(order // 2 % 2).astype(np.int8) for order in orders]
    expected = [_expected(x.size, sampling, codes) for x in pieces]
    by_frequency = _order(frequency)
    return Ordinates(
        _joined(frequency, by_frequency),
        amplitudes(pieces),
        _joined(expected, by_frequency),
        _joined(fold, by_frequency),
        max(x.size for x in pieces),
    )


@lru_cache(maxsize=8)
def _expected(
    length: int, sampling: Sampling, codes: AngleCodes | None
) -> Float32[np.ndarray, "ordinates terms"]:
    """What unit powers of Q, N, B, K put into the ordinates of a stretch, term by term."""
    frequency = np.arange(1, length) / (2 * length)
    found = np.empty((length - 2, len(NOISE_TERMS)), np.float32)
    for place, term in enumerate(NOISE_TERMS):
        with jax.enable_x64(True):
            variance = expected_ordinates(term, length, frequency, sampling, codes)
        found[:, place] = _projection(length).expectation(variance)
    return found


def _order(frequency: list[Float[np.ndarray, " _"]]) -> Int[np.ndarray, " ordinates"] | None:
    """That of the ordinates of several stretches by frequency."""
    if len(frequency) == 1:
        return None
    return np.argsort(np.concatenate(frequency), kind="stable")


def _joined(
    parts: list[np.ndarray], order: Int[np.ndarray, " ordinates"] | None
) -> Shaped[np.ndarray, "ordinates *columns"]:
    """Of one stretch as they are, which takes no more room."""
    return parts[0] if order is None else np.concatenate(parts)[order]


def amplitudes(
    pieces: tuple[Float[np.ndarray, " _"], ...], top: float = 0.5
) -> Float[np.ndarray, " ordinates"]:
    """Signed amplitudes of the ordinates of anything with a value at each sample.

    Those up to a frequency of `top` only [cycles per sample], to a part in 40 of what is there.
    """
    # On the host: between gaps no two stretches are alike, and each length would be compiled.
    modes = [min(x.size - 1, int(2 * x.size * top + _ROUNDED)) for x in pieces]
    found = [
        np.asarray(_projection(x.size).project(_coefficients(x, most)))
        for x, most in zip(pieces, modes, strict=True)
        if most > 0
    ]
    frequency = [
        np.arange(2, most + 1) / (2 * x.size) for x, most in zip(pieces, modes, strict=True)
    ]
    return 2**0.5 * _joined(found, _order(frequency))


def _coefficients(x: Float[np.ndarray, " samples"], modes: int) -> Float[np.ndarray, " modes"]:
    """The first cosine coefficients; from means over blocks where they are few."""
    blocks = 2 ** int(np.ceil(np.log2(_BLOCKS_A_MODE * modes)))
    calm = x - x.mean()
    if blocks < x.size:
        # Of equal length, not of whole samples, so that the basis is that of all samples.
        edges = np.linspace(0.0, x.size, blocks + 1)
        index = np.minimum(edges.astype(int), x.size - 1)
        sums = np.cumsum(calm)[index] - (index + 1 - edges) * calm[index]
        calm = np.diff(sums) * np.sqrt(blocks / x.size)
    return np.asarray(scipy.fft.dct(calm, norm="ortho", overwrite_x=True))[1 : modes + 1]


@lru_cache(maxsize=32)
def _projection(length: int) -> RampProjection:
    return RampProjection(length)


def bin_edges(
    longest: int, peaks: tuple[tuple[float, float], ...] = ()
) -> Float[np.ndarray, " edges"]:
    """Edges equally spaced in log f, and finer about each peak (frequency, half width).

    Toward the Nyquist frequency they are spaced in the logarithm of the distance to it: a filter
    in a sensor's processor has a zero there, and a wide bin would hold powers of all sizes.
    """
    spacing = 1 / (2 * longest)
    edges = logarithmic_edges(2 * spacing, spacing, BINS_PER_DECADE)
    distance = np.geomspace(*_NEAR_NYQUIST, _BINS_NEAR_NYQUIST + 1)
    near = (np.round((0.5 - distance) / spacing - 0.5) + 0.5) * spacing
    edges = np.union1d(edges, near[(near > edges[0]) & (near < edges[-1])])
    for centre, width in peaks:
        # From the peak outward, each bin wider in proportion to its distance.
        reach = width * np.sinh(np.linspace(0.0, 4.5, 14)) / 2
        fine = np.concatenate([centre - reach, centre + reach])
        fine = np.round(fine / spacing - 0.5) + 0.5
        fine = np.unique(fine) * spacing
        fine = fine[(fine > edges[0]) & (fine < edges[-1])]
        if fine.size:
            edges = np.union1d(edges, fine)
    return edges


def binned(
    spectrum: Ordinates,
    edges: Float[np.ndarray, " edges"],
    fold: int | None = None,
) -> Bins:
    """Averages of all ordinates, or of one half of them, between the edges."""
    kept = spectrum.clean(spectrum.frequency)
    if fold is not None:
        kept &= spectrum.fold == fold
    whole = bool(kept.all())
    frequency = spectrum.frequency if whole else spectrum.frequency[kept]
    starts, _, count = runs_between(frequency, edges)

    def mean(values: Float[np.ndarray, " ordinates"]) -> Float[np.ndarray, " bins"]:
        return np.add.reduceat(values if whole else values[kept], starts, dtype=float) / count

    # A bin reaches half a spacing beyond its outermost ordinates.
    half = 1 / (4 * spectrum.longest)
    low = frequency[starts] - half
    high = np.minimum(frequency[starts + count - 1] + half, 0.5)
    density = mean(spectrum.amplitude**2)
    expected = np.stack([mean(column) for column in spectrum.expected.T], axis=1)
    padding = max(_FEWEST - density.size, -density.size % _PADDING)
    nodes = low[:, None] + (high - low)[:, None] * _NODES
    return Bins(
        np.pad(density, (0, padding), constant_values=1.0),
        np.pad(expected, ((0, padding), (0, 0)), constant_values=1.0),
        np.pad(count / (2 * spectrum.dilution), (0, padding)),
        np.pad(nodes, ((0, padding), (0, 0)), constant_values=0.25),
    )


def runs_between(
    frequency: Float[np.ndarray, " ordinates"],
    edges: Float[np.ndarray, " edges"],
    kept: Bool[np.ndarray, " ordinates"] | None = None,
) -> tuple[Int[np.ndarray, " bins"], Int[np.ndarray, " bins"], Int[np.ndarray, " bins"]]:
    """Where the bins that hold ordinates start and stop among them, and how many are `kept` there.

    In order of frequency each bin is a run of them; the outermost bins take the rest.
    """
    starts = np.searchsorted(frequency, edges[:-1])
    starts[0] = 0
    stops = np.append(starts[1:], frequency.size)
    if kept is None:
        count = stops - starts
    else:
        before = np.append(0, np.cumsum(kept))
        count = before[stops] - before[starts]
    held = count > 0
    return starts[held], stops[held], count[held]


def above_leakage(spectrum: Ordinates, bins: Bins) -> Ordinates:
    """The ordinates with their `top`, where a steep filter leaves less than the ends may leak.

    Before the filter is known a bound has to do: the ends of n samples leak less than an n-th of
    the largest density. Lines are none: they are taken out, and what they leak with them.
    """
    frequency, density = bins.frequency[bins.used], np.asarray(bins.density)[bins.used]
    # What slow noise leaks is in `expected`.
    fast = frequency > _FAST
    broad = median_filter(density[fast], _NARROW, mode="nearest").max(initial=0.0)
    faint = fast & (density < LEAST * broad / spectrum.longest)
    # Each bin reaches half way to the next.
    middle = (frequency[1:] + frequency[:-1]) / 2
    low, high = np.append(0.0, middle), np.append(middle, 0.5)
    return less_bands(spectrum, [(low[a], high[b - 1]) for a, b in runs(faint)])


def less_bands(spectrum: Ordinates, bands: list[tuple[float, float]]) -> Ordinates:
    """The ordinates without some bands, of which the last may reach up to the end."""
    end = float(spectrum.frequency[-1])
    top = min((low for low, high in bands if high >= end), default=0.5)
    holes = tuple((float(low), float(high)) for low, high in bands if high < end)
    return spectrum._replace(top=float(top), holes=holes)


def leakage(
    density: Float[np.ndarray, " grid"], at: Float[np.ndarray, " frequencies"]
) -> Float[np.ndarray, " frequencies"]:
    """What the ends of a record add to its mirror spectrum at some frequencies, times its samples.

    `density` is that of the process at `LEAKAGE_GRID`, and g its autocovariance. Of a stationary
    process of n samples an ordinate has the expectation

        S(w) - 1/n sum_m g_m (|m| cos(w m) + sin(w |m|)/sin w),

    by summing the products of two cosines over all pairs of samples.
    """
    lag = np.arange(2 * LEAKAGE_GRID.size - 2)
    covariance = np.where((lag > 0) & (lag < LEAKAGE_GRID.size - 1), np.fft.irfft(density), 0.0)
    turn = 2 * np.pi * LEAKAGE_GRID[1:-1]
    slope = np.fft.rfft(lag * covariance).real[1:-1]
    odd = -np.fft.rfft(covariance).imag[1:-1] / np.sin(turn)
    # It ends at zero like the square of a cosine, between whose points lines are too coarse.
    smooth = -2 * (slope + odd) / np.cos(turn / 2) ** 2
    return np.interp(at, LEAKAGE_GRID[1:-1], smooth) * np.cos(np.pi * at) ** 2
