"""Both curves of a record longer than memory, and what a fit expects of them."""

from collections import Counter
from concurrent.futures import Future, ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..physics import AngleCodes, Sampling, check_sampling
from ..recording._checks import codes_of
from ..recording._lateness import SHORTEST_STRETCH
from ._bins import logarithmic_edges
from ._cluster_sizes import cluster_sizes
from ._design import (
    BINS_PER_DECADE,
    RAMP_MODES,
    Design,
    expected_allan,
    mode_variances,
)
from ._long import LongAllanVariance
from ._long_spectrum import LongSpectrum, Part, in_slots, segment_parts, slot_centres, whole_part
from ._spectrum import RampProjection, ramp_coefficients
from ._statistics import Statistics

# No record is longer, and sizes beyond its length cost next to nothing.
_LONGEST = 2**44
# As many of the first samples tell whether all are differences of an angle in wide codes.
_TELLING = 2**18


class LongStatistics:
    """Takes the samples [u] of one sensor block by block, and then gives what a fit needs.

    The Allan variance is that of `LongAllanVariance`, the spectrum that of `LongSpectrum`.
    Stretches of fewer than 16 samples are left out. Whether the samples are differences of an angle
    in wide codes is asked of the first ones alone. The spectrum is taken in a thread of its own,
    beside the variance; samples handed over must not be changed afterwards.
    """

    def __init__(self):
        self._allan = LongAllanVariance(cluster_sizes(_LONGEST))
        self._spectrum = LongSpectrum()
        # One transform of each row serves both.
        self._allan.share(self._spectrum.power)
        self._beside = ThreadPoolExecutor(1)
        self._spectral: Future | None = None
        self._odd_modes: list[Float[np.ndarray, " modes"]] = []
        self._lengths: list[int] = []
        self._short: list[Float[np.ndarray, " samples"]] = []
        self._length = 0
        self._total = 0.0
        self._first: list[Float[np.ndarray, " samples"]] = []
        self._wanted = _TELLING
        #: The first sample of the present stretch, and whether any was not like its stretch's.
        self._level: float | None = None
        self._varies = False

    @property
    def lengths(self) -> tuple[int, ...]:
        """Of the stretches that have ended, in samples."""
        return tuple(self._lengths)

    @property
    def constant(self) -> bool:
        """Whether no two neighbours in these stretches differ."""
        return not self._varies

    @property
    def mean(self) -> float:
        """Of the samples in these stretches [u]."""
        return self._total / max(sum(self._lengths), 1)

    def add(self, block: Float[np.ndarray, " samples"]) -> None:
        """Take the next samples of the present stretch.

        **Raises:** `ValueError` for samples that are not finite.
        """
        self._length += block.size
        if self._length < SHORTEST_STRETCH:
            self._short.append(block)
            return
        block = np.concatenate([*self._short, block]) if self._short else block
        self._short = []
        if self._level is None:
            self._level = float(block[0])
        self._varies = self._varies or bool(np.any(block != self._level))
        if self._wanted:
            self._first.append(block[: self._wanted].copy())
            self._wanted -= self._first[-1].size
        self._await_spectrum()
        self._spectral = self._beside.submit(self._spectrum.add, block)
        self._allan.add(block)
        self._total += float(block.sum())

    def end_stretch(self) -> None:
        """What comes next is behind a gap."""
        if self._length >= SHORTEST_STRETCH:
            self._await_spectrum()
            self._allan.end_stretch()
            odd = self._spectrum.end_stretch()[: 2 * RAMP_MODES : 2]
            self._odd_modes.append(np.pad(odd, (0, RAMP_MODES - len(odd))))
            self._lengths.append(self._length)
        self._short, self._length, self._level = [], 0, None

    def _await_spectrum(self) -> None:
        """No more than one block waits, so that memory stays bounded."""
        if self._spectral is not None:
            self._spectral.result()
            self._spectral = None

    def value(self, sampling: Sampling = "point") -> tuple[Statistics, Design]:
        """The statistics of all stretches that have ended, and their design.

        The design has no `projection` and no `bin_index`, which belong to samples in memory.

        **Raises:** `ValueError` for another sampling.
        """
        check_sampling(sampling)
        layout, bins = _design(self.lengths, sampling, codes_of(np.concatenate(self._first)))
        sums = np.bincount(bins, self._spectrum.sums(), minlength=len(layout.ordinates))
        allan = self._allan.value()[: len(layout.cluster_sizes)]
        found = (sums / layout.ordinates, allan, np.stack(self._odd_modes))
        return Statistics(*map(jnp.asarray, found)), layout


def _design(
    lengths: tuple[int, ...], sampling: Sampling, codes: AngleCodes | None
) -> tuple[Design, np.ndarray]:
    """As `allanfit.curves.design`, of the parts of long stretches, and the bin of each slot."""
    wholes = [whole_part(length) for length in lengths]
    times = Counter(wholes)
    for length in lengths:
        times.update(segment_parts(length))
    with jax.enable_x64(True):
        expected = {
            part: 2 * mode_variances(part.samples, part.modes, sampling, codes) for part in times
        }
        sizes = cluster_sizes(max(lengths))
        allan = expected_allan(sizes, sampling, codes)
    ramps = [_ramp(part, expected[part]) for part in wholes]
    slots = sum(number * _in_slots(part, expected[part]) for part, number in times.items())
    spacing = 1 / (2 * max(part.samples for part in wholes))
    edges = logarithmic_edges(2 * spacing, spacing, BINS_PER_DECADE)
    place = np.searchsorted(edges, slot_centres(), side="right") - 1
    place = np.clip(place, 0, len(edges) - 2)
    totals = np.stack([np.bincount(place, column) for column in np.asarray(slots).T], axis=-1)
    used = totals[:, 0] > 0
    ordinates, frequency, *_ = means = totals[used].T
    layout = Design(
        lengths=lengths,
        sampling=sampling,
        projection=(),
        bin_index=(),
        ordinates=ordinates,
        frequency=frequency / ordinates,
        density=means[2:].T / ordinates[:, None],
        ramp=np.stack([ramp for ramp, _ in ramps]),
        ramp_variance=np.stack([variance for _, variance in ramps]),
        cluster_sizes=sizes,
        differences=np.sum([np.maximum(length - 2 * sizes + 1, 0) for length in lengths], axis=0),
        allan=allan,
    )
    return layout, np.maximum(np.cumsum(used) - 1, 0)[place]


def _in_slots(
    part: Part, expected: Float[np.ndarray, "modes terms"]
) -> Float[np.ndarray, "slots columns"]:
    """How many ordinates are in each slot, their frequencies, and what the terms put there."""
    projection = RampProjection(part.samples, part.modes)
    seen = [projection.expectation(column)[part.first - 2 :] for column in expected.T]
    columns = [None, part.frequency, *map(np.asarray, seen)]
    return np.stack([in_slots(part.frequency, column) for column in columns], axis=-1)


def _ramp(
    part: Part, expected: Float[np.ndarray, "modes terms"]
) -> tuple[Float[np.ndarray, " odd"], Float[np.ndarray, "odd terms"]]:
    """The odd coefficients of a ramp, and their variances per unit power."""
    odd = slice(0, 2 * RAMP_MODES, 2)
    ramp = ramp_coefficients(part.samples, part.modes)[odd]
    empty = RAMP_MODES - len(ramp)
    # An ordinate is 2 dt c^2, so c has half its variance.
    variance = np.pad(expected[odd] / 2, ((0, empty), (0, 0)), constant_values=1)
    return np.pad(ramp, (0, empty)), variance
