"""Are values better predicted by what was found in them, on samples that were not fitted?

What rounding, rails, spikes and loud times do shows in no spectrum, so that the score of ordinates
says nothing of them. Here one half of the samples says how often, how large and when, and the other
is scored: log-probabilities [nats] of what the five terms and what was found expect. Only when a
brief disturbance was, and with what period the noise swings or a waveform repeats, is found on all
samples.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import norm

from ..strength._modulation import PULLED_IN, modulation
from ._contamination import contamination, log_body, log_mixture

# Within this part of a code's width a value lies on a code.
_ON_CODE = 0.02
# Events are dealt out by so many samples at once, for they may come at every other one.
_TOGETHER = 64


class Gain(NamedTuple):
    """By how much the log-probability of the scored samples rises, and the variance of that."""

    nats: float
    variance: float


def of_samples(difference: Float[np.ndarray, " samples"]) -> Gain:
    """The sum of independent differences."""
    return Gain(float(difference.sum()), float(difference.size * np.var(difference)))


def of_events(happened: Bool[np.ndarray, " samples"], expected: float) -> Gain:
    """Something that happens to samples more often than the share that the noise lets expect."""
    scored = np.arange(happened.size) // _TOGETHER % 2 == 1
    known = happened[~scored]
    share = (known.sum() + 0.5) / (known.size + 1)
    least = 0.5 / (known.size + 1)
    before = min(max(expected, least), 1 - least)
    gains = np.log((1 - share) / (1 - before)), np.log(share / before)
    differences = np.where(happened[scored], gains[1], gains[0])
    return of_samples(differences)


def of_codes(values: Float[np.ndarray, " samples"], width: float) -> Gain:
    """Values that lie on multiples of a code's width, counted from one of them."""
    # From the nearest neighbour, for a width that is a little off would add up.
    steps = np.diff(values) / width
    near = np.abs(steps - np.round(steps)) < _ON_CODE
    return of_events(near, 2 * _ON_CODE)


def of_rails(values: Float[np.ndarray, " samples"], rails: tuple[float, ...]) -> Gain:
    """Values at the rails, against a normal distribution that goes on beyond."""
    even = values[::2]
    beyond = norm.sf(np.abs(np.asarray(rails) - even.mean()), scale=even.std()).sum()
    # Of those beyond, none would lie at the rail itself: that it counts so is generous to it.
    return of_events(np.isin(values, rails), float(beyond))


def of_spikes(white: Float[np.ndarray, " samples"], boxes: tuple[float, ...], seed: int) -> Gain:
    """Spikes in whitened samples, against one distribution, of which `boxes` are uniform."""

    def differences(known: slice, scored: slice):
        found = contamination(white[known], seed, boxes)
        plain = log_body(white[scored], float(white[known].std()), found.boxes)
        return log_mixture(found, white[scored]) - plain

    return _crossed(white.size, differences)


def of_loud_times(white: Float[np.ndarray, " samples"], seed: int) -> Gain:
    """Loud and quiet times of whitened samples, against one variance."""
    pulled = np.clip(white, -PULLED_IN, PULLED_IN)

    def differences(known: slice, scored: slice):
        found = modulation(pulled[known], seed)
        if found.strength is None:
            return _two_levels(pulled[known], found.loud, pulled[scored], found.loud)
        width = float(np.std(pulled[known] / found.strength))
        usual = norm.logpdf(pulled[scored], scale=pulled[known].std())
        return norm.logpdf(pulled[scored], scale=width * found.strength) - usual

    return _crossed(white.size, differences)


def of_times(white: Float[np.ndarray, " samples"], loud: Bool[np.ndarray, " samples"]) -> Gain:
    """As `of_loud_times`, for brief times found on all samples: half may not show them."""
    pulled = np.clip(white, -PULLED_IN, PULLED_IN)

    def differences(known: slice, scored: slice):
        return _two_levels(pulled[known], loud[known], pulled[scored], loud[scored])

    return _crossed(white.size, differences)


def _two_levels(known, loud_known, scored, loud_scored) -> Float[np.ndarray, " half"]:
    """Of the scored samples, with the deviations of the known loud and quiet ones."""
    if loud_known.all() or not loud_known.any():
        return np.zeros(scored.size)
    usual = known.std()

    def deviation(values):
        # From zero, since a few that are pulled in may all be equal; and as if one more had been
        # seen, as large as others are.
        return np.sqrt((np.sum(values**2) + usual**2) / (values.size + 1))

    scale = np.where(loud_scored, deviation(known[loud_known]), deviation(known[~loud_known]))
    return norm.logpdf(scored, scale=scale) - norm.logpdf(scored, scale=usual)


def of_swing(white: Float[np.ndarray, " samples"], period: float) -> Gain:
    """Noise whose variance swings, its period [samples] found on all, against one that lasts."""
    squares = np.clip(white, -PULLED_IN, PULLED_IN) ** 2
    angle = 2 * np.pi * np.arange(white.size) / period
    waves = np.column_stack([np.cos(angle), np.sin(angle)])

    def differences(known: slice, scored: slice):
        level = squares[known].mean()
        size, *_ = np.linalg.lstsq(waves[known], squares[known] / level - 1)
        swing = np.maximum(1 + waves[scored] @ size, 0.05)
        return -(np.log(swing) + squares[scored] / level * (1 / swing - 1)) / 2

    return _crossed(white.size, differences, halves=True)


def of_phases(white: Float[np.ndarray, " samples"], phase: Int[np.ndarray, " samples"]) -> Gain:
    """A mean of its own in each phase of a period, which is found on all samples, against none."""

    def differences(known: slice, scored: slice):
        counts = np.maximum(np.bincount(phase[known], minlength=phase.max() + 1), 1)
        mean = np.bincount(phase[known], white[known], minlength=counts.size) / counts
        here = mean[phase[scored]]
        return here * (white[scored] - here / 2) / np.mean(white[known] ** 2)

    return _crossed(white.size, differences, halves=True)


def _crossed(
    samples: int,
    differences: Callable[[slice, slice], Float[np.ndarray, " half"]],
    *,
    halves: bool = False,
) -> Gain:
    """Even samples known and odd ones scored, and the other way round.

    Or the first half and the last: of what has an even period each is seen at half of its phases.
    """
    even, odd = (slice(start, samples // 2 * 2, 2) for start in (0, 1))
    if halves:
        even, odd = slice(0, samples // 2), slice(samples // 2, samples // 2 * 2)
    return of_samples(np.concatenate([differences(even, odd), differences(odd, even)]))
