"""The mirror spectrum of a record longer than memory, from its blocks as they come.

A stretch is cut into segments of one length. Their spectra, averaged, hold all that is above their
64th order. What is below are the first coefficients of the stretch as a whole, which a coarser
series keeps: the record smoothed by a quadratic spline, three running means of 512 samples one
after another, and read every 512 samples. Reflected at its ends, as the record is, it has the
record's own coefficients times the known response of the spline. What folds back from higher
frequencies is below 1e-6 of a white spectrum, and below 1e-4 where it rises as the square of the
frequency. So each ordinate has the expectation that a shorter record's would have, and the fit of
a short record serves for long ones.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
from jaxtyping import Float

from ._rows import ROW, Waiting
from ._spectrum import RampProjection

# An Allan variance of the same samples takes its rows from here.
_SEGMENT = ROW
_FIRST = 64
_SPACING = _SEGMENT // (8 * _FIRST)
# A last segment shorter than this tells little that the others do not.
_SHORTEST = _SEGMENT // 8
# Ordinates are added up in slots much narrower than any bin, as the edges of bins depend on the
# length, which is known last. From 1e-13 cycles per sample to 0.5.
_SLOTS_A_DECADE = 2048
_SLOTS = 13 * _SLOTS_A_DECADE


@dataclass(frozen=True)
class Part:
    """Coefficients of one cosine transform, and which of them count as ordinates."""

    samples: int
    first: int
    """The lowest order that counts."""
    modes: int
    """How many coefficients are known, from order 1 on."""

    @property
    def frequency(self) -> Float[np.ndarray, " ordinates"]:
        """Of the orders that count, in cycles per sample."""
        return np.arange(self.first, self.modes + 1) / (2 * self.samples)


def whole_part(length: int) -> Part:
    """That part of a stretch which reaches down to its lowest order."""
    if length <= _SEGMENT:
        return Part(length, 2, length - 1)
    return _low_part(length // _SPACING)


def segment_parts(length: int) -> dict[Part, int]:
    """The other parts of a stretch and how many there are of each, none for a short stretch."""
    if length <= _SEGMENT:
        return {}
    times, rest = divmod(length, _SEGMENT)
    last = {_segment(rest): 1} if rest >= _SHORTEST else {}
    return {_segment(_SEGMENT): times} | last


def slot_centres() -> Float[np.ndarray, " slots"]:
    """Frequencies in the middle of the slots, in cycles per sample."""
    return 10 ** ((np.arange(_SLOTS) - _SLOTS + 0.5) / _SLOTS_A_DECADE)


def in_slots(
    frequency: Float[np.ndarray, " ordinates"],
    values: Float[np.ndarray, " ordinates"] | None = None,
) -> Float[np.ndarray, " slots"]:
    """The sum of `values` in each slot, or how many frequencies are in it."""
    place = np.floor(np.log10(frequency) * _SLOTS_A_DECADE).astype(np.int64) + _SLOTS
    return np.bincount(np.maximum(place, 0), values, minlength=_SLOTS).astype(float)


class LongSpectrum:
    """Ordinates of the mirror spectrum [u^2], the ramp taken out, of samples [u] block by block.

    Memory grows by 24 bytes for every 512 samples of a stretch, and hardly with anything else.
    """

    def __init__(self):
        self._sums = np.zeros(_SLOTS)
        self._segments = np.zeros(_SEGMENT - _FIRST)
        #: The power of the cosines of all segments, by order from zero, with the ramp in it.
        self.power = np.zeros(_SEGMENT)
        # One more sample than a segment tells that the stretch is a long one.
        self._waiting = Waiting(_SEGMENT)
        self._smooth: list[Float[np.ndarray, "places 3"]] = []
        self._offset = 0.0

    def add(self, block: Float[np.ndarray, " samples"]) -> None:
        """Take the next samples, finite ones, of the present stretch."""
        if block.size and not self._waiting.rest.size:
            self._offset = float(block.mean())
        for segment in self._waiting.add(block):
            segment -= self._offset
            self._add_segment(segment)

    def end_stretch(self) -> Float[np.ndarray, " modes"]:
        """The first coefficients of the stretch that ends, the ramp in them."""
        rest = self._waiting.rest - self._offset
        if not self._smooth:
            part, coefficients = Part(rest.size, 2, rest.size - 1), _cosine(rest)
            if rest.size == _SEGMENT:
                self.power[1:] += coefficients * coefficients
        else:
            if rest.size == _SEGMENT:
                self._add_segment(rest)
            else:
                self._smooth.append(_smooth(rest))
                if rest.size >= _SHORTEST:
                    short = _segment(rest.size)
                    self._add(short, 2 * _ordinates(short, _cosine(rest)))
            part, coefficients = _low_coefficients(np.concatenate(self._smooth))
        self._add(part, 2 * _ordinates(part, coefficients))
        self._waiting.clear()
        self._smooth = []
        return coefficients

    def sums(self) -> Float[np.ndarray, " slots"]:
        """The sum of the ordinates in each slot, over the stretches that have ended."""
        return self._sums + in_slots(_segment(_SEGMENT).frequency, self._segments)

    def _add_segment(self, x: Float[np.ndarray, " samples"]) -> None:
        """Take a segment, whose place in memory is used for its transform."""
        self._smooth.append(_smooth(x))
        cosines = _cosine(x, overwrite=True)
        self.power[1:] += cosines * cosines
        self._segments += 2 * _ordinates(_segment(_SEGMENT), cosines)

    def _add(self, part: Part, ordinates: Float[np.ndarray, " ordinates"]) -> None:
        self._sums += in_slots(part.frequency, ordinates)


def _low_part(places: int) -> Part:
    """What a coarse series of so many places tells."""
    samples = places * _SPACING
    return Part(samples, 2, -(-_FIRST * samples // _SEGMENT) - 1)


def _segment(samples: int) -> Part:
    return Part(samples, max(-(-_FIRST * samples // _SEGMENT), 2), samples - 1)


def _cosine(
    x: Float[np.ndarray, " samples"], *, overwrite: bool = False
) -> Float[np.ndarray, " modes"]:
    """On the host: a transform of each length would have to be compiled."""
    return np.asarray(scipy.fft.dct(x, type=2, norm="ortho", overwrite_x=overwrite))[1:]


def _ordinates(
    part: Part, coefficients: Float[np.ndarray, " modes"]
) -> Float[np.ndarray, " ordinates"]:
    """Squares of the coefficients that count, without the ramp."""
    by, taken = _projector(part.samples, part.modes)
    # Not by BLAS, whose threads would wait for one another on a busy machine.
    ramp = np.einsum("i,i->", by, coefficients)
    rest = coefficients[part.first - 1 :] - taken[part.first - 1 :] * ramp
    return rest * rest


@lru_cache(maxsize=2)
def _projector(
    samples: int, modes: int
) -> tuple[Float[np.ndarray, " modes"], Float[np.ndarray, " modes"]]:
    """Vectors b and t that take the ramp out of coefficients c as c - t (b c)."""
    projection = RampProjection(samples, modes)
    weight = projection.weight
    return np.asarray(projection.mix) * weight, np.asarray(projection.direction) / weight


def _spline() -> Float[np.ndarray, "spacing 3"]:
    """What a block of samples gives to the place before its own, its own, and the one after."""
    box = np.ones(_SPACING)
    kernel = np.pad(np.convolve(np.convolve(box, box), box) / _SPACING**3, 1)
    return np.ascontiguousarray(kernel.reshape(3, _SPACING)[::-1].T)


def _smooth(x: Float[np.ndarray, " samples"]) -> Float[np.ndarray, "places 3"]:
    whole = x.size // _SPACING * _SPACING
    return x[:whole].reshape(-1, _SPACING) @ _SPLINE


def _low_coefficients(
    given: Float[np.ndarray, "places 3"],
) -> tuple[Part, Float[np.ndarray, " modes"]]:
    """The first cosine coefficients of a stretch, from what its blocks give to a coarse series."""
    before, own, after = given.T
    # Reflected at the ends: what would fall beyond comes back.
    coarse = own + np.append(before[1:], after[-1]) + np.append(before[0], after[:-1])
    part = _low_part(len(coarse))
    frequency = np.arange(1, part.modes + 1) / (2 * part.samples)
    response = np.sin(np.pi * frequency * _SPACING) / (_SPACING * np.sin(np.pi * frequency))
    return part, _cosine(coarse)[: part.modes] * np.sqrt(_SPACING) / response**3


_SPLINE = _spline()
