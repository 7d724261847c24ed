"""Lines and resonances of a model, and the bands that they fill."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.fft import dct, idct

from .._refit import rebin
from .._state import Investigation
from ..lines._moving import Band
from ..lines._tracked import Baseband, inside, narrow_band
from . import _model
from ._density import effects_density, gain_at, noise_at
from ._model import SWINGS, Model
from ._ordinates import bin_edges
from ._structure import EACH, NARROW, shape_of

# Bins within a width to either side of a peak that show its shape.
_RESOLVED = 6
# What is within so many widths of a peak is about it.
_ABOUT = 3.0
# Beside the strongest peak there is such a part of its density at least.
_LEAST = 1e-12
# A band's share of the power is told at so many frequencies.
_SHARES = 512


class Narrow(NamedTuple):
    """One line or resonance of the model, with its free parameters."""

    name: str
    #: Which of the model's added noises it is.
    place: int
    three: Float[np.ndarray, " three"]
    middle: float
    width: float


def narrow_noises(model: Model, samples: float) -> list[Narrow]:
    """Lines and resonances of a model, in the order of its added noises."""
    kinds, found = model.kinds, []
    for place, name in enumerate(kinds.added):
        if name in NARROW:
            begin = kinds.first_slot + EACH * place
            three = model.theta[begin : begin + EACH]
            first, second = (float(each) for each in shape_of(name, three, samples))
            width = first * second if name == "drifting_line" else first / second
            found.append(Narrow(name, place, three, first, width))
    return found


def is_about(frequency: float, peaks: list[Narrow]) -> bool:
    """Whether a frequency is within a few widths of a line or a resonance."""
    return any(abs(frequency - one.middle) < _ABOUT * one.width for one in peaks)


def narrow_groups(state: Investigation) -> list[list[Narrow]]:
    """Lines and resonances in groups whose bands meet: several may describe one cause.

    Not among them is a resonance that hardly swings.
    """
    found = [
        one
        for one in narrow_noises(state.model, float(state.data.samples))
        if one.width * SWINGS < one.middle
    ]
    groups: list[list[Narrow]] = []
    for one in sorted(found, key=lambda each: each.middle):
        last = groups[-1][-1] if groups else None
        if last is not None and one.middle - last.middle < 2 * (one.width + last.width):
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def resolve(state: Investigation) -> None:
    """Bins as fine as the peaks of the model: wider ones say little of a width."""
    coarse = []
    for one in narrow_noises(state.model, float(state.data.samples)):
        near = np.abs(state.edges - one.middle) < one.width
        if np.count_nonzero(near) < _RESOLVED:
            coarse.append((one.middle, one.width / 2))
    if coarse:
        finer = bin_edges(state.spectrum.longest, tuple(coarse))
        state.edges = np.union1d(state.edges, finer)
        rebin(state)


def beside(
    state: Investigation, group: list[Narrow], frequency: Float[np.ndarray, " _"]
) -> Float[np.ndarray, " _"]:
    """What the model expects of ordinates at some frequencies without a group's noises [u^2]."""
    bins = state.data.bins
    every = effects_density(state.model.theta, state.model.kinds, state.data)
    own = np.sum([every[each.place] for each in group], axis=0)
    total = _model.mean_density(state.model, state.data)
    # A difference of two that are nearly equal is still some noise.
    rest = np.maximum(total - own, _LEAST * total)[bins.used]
    return np.exp(np.interp(np.log(frequency), np.log(bins.frequency[bins.used]), np.log(rest)))


def density_of(
    state: Investigation, group: list[Narrow], frequency: Float[np.ndarray, " _"]
) -> Float[np.ndarray, " _"]:
    """What a group puts into ordinates at some frequencies [u^2]."""
    theta, kinds, data = state.model.theta, state.model.kinds, state.data
    return np.sum(
        [
            noise_at(each.name, each.three, frequency, data)
            * gain_at(theta, each.name, kinds, frequency, data)
            for each in group
        ],
        axis=0,
    )


class Demodulated(NamedTuple):
    """A band moved to zero, in which white noise beside a group has a mean square of one."""

    band: Baseband
    #: Of its ordinates [cycles per sample], and how much noise stands beside it there [u^2].
    frequency: Float[np.ndarray, " band"]
    level: Float[np.ndarray, " band"]


def alone(
    state: Investigation,
    white: Float[np.ndarray, " samples"],
    group: list[Narrow],
    middle: float,
    half: float,
) -> Demodulated:
    """The band within `half` of a `middle` of the longest stretch, made white beside a group.

    `white` is that stretch made white by all of the model.
    """
    low, high = max(middle - half, 1 / white.size), min(middle + half, 0.5)
    ordinates = inside(white.size, low, high)
    frequency = np.arange(ordinates.start, ordinates.stop) / white.size
    # As cosines, which is how it was made white: what rings as long as the record differs at its
    # ends, and a narrow peak does.
    coefficients = np.asarray(dct(white, norm="ortho"))
    at = np.arange(white.size) / (2 * white.size)
    near = (at > low - 1 / white.size) & (at < high + 1 / white.size)
    made_white = np.interp(at[near], state.left.frequency, state.variance)
    coefficients[near] *= np.sqrt(made_white / beside(state, group, at[near]))
    flat = np.asarray(idct(coefficients, norm="ortho"))
    return Demodulated(narrow_band(flat, low, high), frequency, beside(state, group, frequency))


def band_of(state: Investigation, group: list[Narrow], widths: float) -> Band:
    """So many widths to either side of a group, and its share of the power there."""
    samples = float(state.data.samples)
    low = max(min(each.middle - widths * each.width for each in group), 1 / samples)
    high = min(max(each.middle + widths * each.width for each in group), 0.5)
    at = np.linspace(low, high, _SHARES)
    own = density_of(state, group, at)
    return Band(low, high, at, own / (own + beside(state, group, at)))
