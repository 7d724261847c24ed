"""How likely a line of steady amplitude, whose frequency wanders, made a narrow band.

A spectrum knows no more of it than of normal noise of the same shape, but a line is at one
frequency at a time, and keeps its phase from one moment to the next. A hidden Markov model with
frequency and phase as its states knows both: frequency reverts to its mean as an
Ornstein-Uhlenbeck process does, and phase goes on by it (forward algorithm: Rabiner 1989, Proc.
IEEE 77:257). A line that is switched has one state more, in which it is off.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from jaxtyping import Complex, Float

# Frequencies of a band, and phases: one sample later a phase has gone on by whole steps.
_STEPS = 32
# How long a frequency lasts, in samples of the band; any of them may be.
_MEMORIES = (10.0, 30.0, 100.0, 300.0, 1000.0)
# Where no frequency and phase is likely at all.
_LEAST = 1e-280
# Steps of which a normal distribution is sampled well.
_SMOOTH = 0.6

Baseband = Complex[np.ndarray, " band"]


def narrow_band(white: Float[np.ndarray, " samples"], low: float, high: float) -> Baseband:
    """A band of a white record, moved to zero and taken as often as it has ordinates.

    Its samples are independent and complex normal, with a mean square of one.
    """
    spectrum = np.fft.rfft(white)[inside(white.size, low, high)] / np.sqrt(white.size)
    return np.fft.ifft(spectrum) * np.sqrt(spectrum.size)


def inside(samples: int, low: float, high: float) -> slice:
    """The ordinates of a band; neither zero nor the Nyquist frequency."""
    last = (samples + 1) // 2
    return slice(max(int(low * samples), 1), min(int(np.ceil(high * samples)), last))


def normal_likelihood(band: Baseband, excess: Float[np.ndarray, " band"]) -> float:
    """Log-likelihood of normal noise in the band, over that of white noise alone.

    `excess` is its density over that of white noise, at frequencies evenly across the band.
    """
    power = np.abs(np.fft.fft(band)) ** 2 / band.size
    return float(np.sum(power * excess / (1 + excess) - np.log1p(excess)))


class Tracked(NamedTuple):
    """A line that wanders in a band."""

    #: Log-likelihood over that of white noise alone, the mean over all memories and parts.
    log_likelihood: float
    #: For how long its frequency lasts [samples of the band]: the mean, by how likely each is.
    memory: float
    #: How likely it is on at each sample, by the samples up to that one.
    on: Float[np.ndarray, " band"]


class Moments(NamedTuple):
    """Of a line, each with its standard deviation by the noise beside it."""

    #: Its squared amplitude [u^2].
    square: tuple[float, float]
    #: Mean and standard deviation of the frequency [cycles per sample].
    mean: tuple[float, float]
    width: tuple[float, float]


class Followed(NamedTuple):
    """A line that wanders, followed in time."""

    #: For what part of the longest stretch its frequency lasts.
    lasts: float
    moments: Moments | None


def tracked(
    band: Baseband,
    middle: float,
    width: float,
    power: float,
    *,
    on: tuple[float, ...] = (1.0,),
    changes: float = 0.0,
) -> Tracked:
    """How likely a line that wanders made the band.

    `middle` and `width` are mean and standard deviation of its frequency as parts of the band, and
    `power` is its mean squared amplitude where white noise has a mean square of one. It is on for
    one of the parts `on` of the record, any of which may be, goes on or off so many times, and
    comes back at any frequency and phase. If it is never off it changes these as often.
    """
    memories = [each for each in _MEMORIES if each < band.size] or [_MEMORIES[0]]
    memory, part = np.array([*product(memories, on)]).T
    frequency, step = np.arange(_STEPS) / _STEPS, np.arange(_STEPS)
    apart = ((frequency - middle) / width) ** 2 / 2
    # A line much narrower than a step still is at one.
    start = np.exp(apart.min() - apart)
    start = np.repeat(start[:, None] / start.sum() / _STEPS, _STEPS, axis=1)
    moves = np.stack([_moves(middle * _STEPS, width * _STEPS, each) for each in memory])
    # Of a line at step k of the frequency the phase goes on by k steps.
    earlier = (_STEPS * step[:, None] + (step[None, :] - step[:, None]) % _STEPS).ravel()
    squared = (power / part)[:, None]
    turned = np.exp(-2j * np.pi * frequency)
    often, away = changes / 2 / band.size, np.maximum(1 - part, 1 / band.size)
    goes, comes = np.minimum(often / part, 0.5), np.minimum(often / away, 0.5)
    states, off = part[:, None, None] * start, 1 - part
    found, there = np.zeros(memory.size), np.zeros((band.size, memory.size))
    for at, value in enumerate(band):
        if at:
            flat = states.reshape(memory.size, -1)[:, earlier]
            gone = goes * states.sum(axis=(1, 2))
            back = np.where(part < 1, comes * off, gone)
            off = off + gone - back
            stays = (1 - goes)[:, None, None] * (moves @ flat.reshape(states.shape))
            states = stays + back[:, None, None] * start
        told = 2 * np.sqrt(squared) * (value * turned).real - squared
        # Relative to the likeliest: of a strong line the largest is beyond all numbers.
        most = np.where(off > 0, np.maximum(told.max(axis=1), 0.0), told.max(axis=1))
        states = states * np.exp(told - most[:, None])[:, None, :]
        # Of one that is never off it is zero, however unlikely it is anywhere.
        off = off * np.exp(-np.maximum(most, 0.0))
        total = np.maximum(states.sum(axis=(1, 2)) + off, _LEAST)
        states, off = states / total[:, None, None], off / total
        found += np.log(total) + most
        there[at] = 1 - off
    likelihood = np.exp(found - found.max())
    likely = float(found.max() + np.log(likelihood.mean()))
    likelihood /= likelihood.sum()
    return Tracked(likely, float(likelihood @ memory), there @ likelihood)


def _moves(middle: float, width: float, memory: float) -> Float[np.ndarray, "to come_from"]:
    """Chances of going from one frequency to another within one sample, all in steps."""
    step = np.arange(_STEPS)
    kept = np.exp(-1 / memory)
    mean, variance = middle + kept * (step - middle), width**2 * (1 - kept**2)
    if variance > _SMOOTH**2:
        chances = np.exp(-((step[:, None] - mean) ** 2) / (2 * variance))
    else:
        # One step up, one down, or none: with the same mean and variance.
        drift = mean - step
        up, down = ((variance + drift**2 + sign * drift) / 2 for sign in (1, -1))
        up, down = np.maximum(up, 0.0), np.maximum(down, 0.0)
        chances = np.diag(np.maximum(1 - up - down, 0.0))
        chances += np.diag(up[:-1], -1) + np.diag(down[1:], 1)
    return chances / chances.sum(axis=0)
