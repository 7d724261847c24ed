"""How likely a line of one frequency and phase, whose strength changes, made a narrow band.

Such a line's sidebands mirror each other: all of its power is in phase with it. Half of that of
normal noise, and most of that of a line that wanders, is in quadrature.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import ive, logsumexp

from ._tracked import Baseband

# Frequencies that are tried, in parts of an ordinate; about the best so many times finer, twice.
_APART, _FINER = 0.25, 5
# A line is on for less than this part of the record and holds as much of its power then.
_SHORT, _MOSTLY = 0.8, 0.9
# An interval is looked for among so many moments.
_MOMENTS = 256


class OnePhase(NamedTuple):
    """A line of one phase."""

    #: Log of its likelihood over that of normal noise of the same spectrum.
    gain: float
    #: Its frequency, in ordinates of the band.
    middle: float
    #: When it is on, as parts of the record, if that is one interval.
    on: tuple[float, float] | None


def one_phase(
    band: Baseband, middle: float, reach: float, excess: Callable[[np.ndarray], np.ndarray]
) -> OnePhase:
    """Whether all power of a band is in phase with one frequency.

    `band` is as from `narrow_band`, with white noise of mean square one beside the cause; `excess`
    is the cause's density over that noise, so many ordinates from its middle, which is sought
    within `reach` of `middle`.

    At a distance k the ordinates Y(k) and Y(-k) make an in-phase amplitude (Y(k) e^(-i phi) +
    conj(Y(-k) e^(-i phi)))/sqrt(2), with twice the excess, and one in quadrature, with none. The
    likelihood, whatever the phase phi, is a Bessel function of sum w(k) Y(k) Y(-k).
    """
    time = np.arange(band.size)
    last = int(min(middle, band.size - 1 - middle) - reach)
    order = np.arange(1, max(last, 1) + 1)
    beside, at_middle = excess(order), float(excess(np.zeros(1))[0])
    weight, own = 2 * beside / (1 + 2 * beside), at_middle / (1 + 2 * at_middle)
    known = np.log1p(2 * beside).sum() + np.log1p(2 * at_middle) / 2

    def both(place: float) -> tuple[float, float]:
        """Log-likelihoods of one phase and of normal noise about a middle."""
        turned = band * np.exp(-2j * np.pi * place * time / band.size)
        ordinates = np.fft.fft(turned) / np.sqrt(band.size)
        above, below, carrier = ordinates[order], ordinates[-order], ordinates[0]
        power = np.abs(above) ** 2 + np.abs(below) ** 2
        told = weight @ power / 2 + own * np.abs(carrier) ** 2
        together = float(np.abs(np.sum(weight * above * below) + own * carrier**2))
        noise = (beside / (1 + beside)) @ power + at_middle / (1 + at_middle) * np.abs(carrier) ** 2
        return (
            float(told - known + together) + float(np.log(ive(0, together))),
            float(noise - 2 * np.log1p(beside).sum() - np.log1p(at_middle)),
        )

    # The stronger a line is, the finer its frequency shows.
    best, half, normal, likelihood = middle, reach, -np.inf, -np.inf
    for step in _APART / _FINER ** np.arange(3):
        places = best + np.arange(-half, half + step / 2, step)
        in_phase, noise = np.array([both(place) for place in places]).T
        best, normal = float(places[np.argmax(in_phase)]), max(normal, float(noise.max()))
        # Anywhere within reach it is as likely to be.
        found = float(logsumexp(in_phase) + np.log(step / (2 * reach + step)))
        likelihood, half = max(likelihood, found), min(reach, step)
    turned = band * np.exp(-2j * np.pi * best * time / band.size)
    return OnePhase(likelihood - normal, best, _on(turned))


def _on(turned: Baseband) -> tuple[float, float] | None:
    """The interval, as parts of the record, in which nearly all of a line's power is, if any."""
    phase = np.angle(np.sum(turned**2)) / 2
    envelope = (turned * np.exp(-1j * phase)).real
    together = max(envelope.size // _MOMENTS, 1)
    count = envelope.size // together
    moments = envelope[: count * together].reshape(count, together).sum(axis=1)
    sums = np.concatenate([[0.0], np.cumsum(moments)])
    start, stop = np.triu_indices(count + 1, 1)
    # As a sum over an interval and nothing elsewhere explains best.
    told = (sums[stop] - sums[start]) ** 2 / (stop - start)
    best = int(np.argmax(told))
    a, b = int(start[best]), int(stop[best])
    noise = together / 2
    inside = np.sum(moments[a:b] ** 2) - (b - a) * noise
    whole = np.sum(moments**2) - count * noise
    if b - a > _SHORT * count or not 0 < _MOSTLY * whole < inside:
        return None
    return a / count, b / count
