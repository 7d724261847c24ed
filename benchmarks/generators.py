"""Noise in the time domain, by other means than the library's own sampler."""

from functools import lru_cache

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import lfilter


def white(rng, samples, coefficient, dt, averaged):
    return coefficient / np.sqrt(dt) * rng.standard_normal(samples)


def quantization(rng, samples, coefficient, dt, averaged):
    """The difference of an angle that is rounded: a uniform error, not a normal one."""
    step = coefficient * np.sqrt(12)
    return np.diff(step * rng.uniform(-0.5, 0.5, samples + 1)) / dt


def flicker_by_fractional_filter(rng, samples, coefficient, dt, averaged):
    """White noise through (1 - z^-1)^(-1/2), four records long so that its start is forgotten."""
    count = 4 * samples
    size = next_fast_len(2 * count, real=True)
    drawn = rfft(rng.standard_normal(count), size)
    return coefficient * irfft(drawn * _half_sum(count, size), size)[3 * samples : count]


@lru_cache(maxsize=1)
def _half_sum(count, size):
    """Transfer function of the fractional filter, cut off after `count` samples."""
    ratio = (np.arange(1, count) - 0.5) / np.arange(1, count)
    return rfft(np.concatenate([[1.0], np.cumprod(ratio)]), size)


def flicker_by_relaxations(rng, samples, coefficient, dt, averaged):
    """First-order relaxations, six a decade, to thirty records and beyond.

    Where a sensor takes values, noise faster than its samples folds into white noise, which an
    engineer counts to N: the fastest relaxation is a third of dt there, as behind a filter, and a
    thousandth of it else. Where a sensor averages, each relaxation's mean over an interval is
    drawn exactly: integrating dx = -x/T dt + q dW says that it is (x_k - x_(k+1) + q W) T/dt.
    """
    fastest, slowest = (1e-3 if averaged else 0.3) * dt, 30 * samples * dt
    times = np.geomspace(fastest, slowest, 6 * int(np.log10(slowest / fastest)) + 1)
    # Equal variance a decade makes 1/f: S = 4 s^2 T/(1 + (2 pi f T)^2), summed over ln T.
    variance = coefficient**2 / np.pi * np.log(times[1] / times[0])
    total = np.zeros(samples)
    for time in times:
        decay, strength = np.exp(-dt / time), np.sqrt(2 * variance / time)
        step = np.sqrt(dt) * rng.standard_normal(samples)
        # The part of the increment that follows the Wiener step, and the rest.
        share = strength * time * -np.expm1(-dt / time) / dt
        rest = variance * -np.expm1(-2 * dt / time) - share**2 * dt
        drive = share * step + np.sqrt(max(rest, 0.0)) * rng.standard_normal(samples)
        start = np.sqrt(variance) * rng.standard_normal()
        after, _ = lfilter([1.0], [1.0, -decay], drive, zi=[decay * start])
        before = np.concatenate([[start], after[:-1]])
        total += (before - after + strength * step) * time / dt if averaged else before
    return total


def walk(rng, samples, coefficient, dt, averaged):
    """Steps; or the mean of sixteen sub-steps an interval."""
    if not averaged:
        return np.cumsum(coefficient * np.sqrt(dt) * rng.standard_normal(samples))
    steps = coefficient * np.sqrt(dt / 16) * rng.standard_normal(16 * samples)
    return np.cumsum(steps).reshape(samples, 16).mean(axis=1)


def record(rng, samples, dt, coefficients, *, averaged=False):
    """The sum of the five terms, shape (samples,)."""
    flicker = flicker_by_relaxations if averaged else flicker_by_fractional_filter
    makers = {"Q": quantization, "N": white, "B": flicker, "K": walk}
    total = coefficients.get("R", 0.0) * dt * np.arange(samples)
    for symbol, make in makers.items():
        if coefficients.get(symbol):
            total = total + make(rng, samples, coefficients[symbol], dt, averaged)
    return total
