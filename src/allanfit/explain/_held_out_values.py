"""Are values better predicted by what was found in them, on samples that it was not found in?

What rounding, rails, spikes and loud times do shows in no spectrum, so that the score of ordinates
says nothing of them. Here one half of the samples says how often, how large and when, and the other
is scored: log-probabilities [nats] of what the five terms and what was found expect.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import norm

from ._spread import PULLED_IN, contamination, log_mixture, modulation

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


def of_spikes(white: Float[np.ndarray, " samples"], seed: int) -> Gain:
    """Spikes in whitened samples, against one normal distribution."""

    def differences(known, scored):
        found = contamination(known, seed)
        return log_mixture(found, scored) - norm.logpdf(scored, scale=known.std())

    return _crossed(white, differences)


def of_loud_times(white: Float[np.ndarray, " samples"], seed: int) -> Gain:
    """Loud and quiet times of whitened samples, against one variance."""

    def differences(known, scored):
        loud = modulation(known, seed).loud
        if loud.all() or not loud.any():
            return np.zeros(scored.size)
        scale = np.where(loud, known[loud].std(), known[~loud].std())
        return norm.logpdf(scored, scale=scale) - norm.logpdf(scored, scale=known.std())

    return _crossed(np.clip(white, -PULLED_IN, PULLED_IN), differences)


def of_times(white: Float[np.ndarray, " samples"], loud: Bool[np.ndarray, " samples"]) -> Gain:
    """As `of_loud_times`, where short spectra told when it is loud."""
    pulled = np.clip(white, -PULLED_IN, PULLED_IN)

    def differences(known, scored, loud_known, loud_scored):
        levels = known[~loud_known].std(), known[loud_known].std()
        scale = np.where(loud_scored, levels[1], levels[0])
        return norm.logpdf(scored, scale=scale) - norm.logpdf(scored, scale=known.std())

    half = white.size // 2
    halves = [(pulled[i : 2 * half : 2], loud[i : 2 * half : 2]) for i in (0, 1)]
    return of_samples(
        np.concatenate(
            [
                differences(one, other, loud_one, loud_other)
                for (one, loud_one), (other, loud_other) in (halves, halves[::-1])
            ]
        )
    )


def of_swing(white: Float[np.ndarray, " samples"], period: float) -> Gain:
    """Noise whose variance swings with a period [samples], against one that does not."""
    pulled = np.clip(white, -PULLED_IN, PULLED_IN)
    angle = 2 * np.pi * np.arange(white.size) / period
    waves = np.column_stack([np.cos(angle), np.sin(angle)])
    half = white.size // 2
    gains = []
    for known, scored in ((0, 1), (1, 0)):
        squares, other = (pulled[i : 2 * half : 2] ** 2 for i in (known, scored))
        level = squares.mean()
        size = 2 * (squares / level - 1) @ waves[known : 2 * half : 2] / half
        swing = np.maximum(1 + waves[scored : 2 * half : 2] @ size, 0.05)
        gains.append(-(np.log(swing) + other / level * (1 / swing - 1)) / 2)
    return of_samples(np.concatenate(gains))


def _crossed(
    white: Float[np.ndarray, " samples"], differences: Callable[..., Float[np.ndarray, " half"]]
) -> Gain:
    """Even samples known and odd ones scored, and the other way round."""
    half = white.size // 2
    even, odd = white[: 2 * half : 2], white[1 : 2 * half : 2]
    return of_samples(np.concatenate([differences(even, odd), differences(odd, even)]))
