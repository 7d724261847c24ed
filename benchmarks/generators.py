"""Noise in the time domain, by other means than the library's own sampler."""

import numpy as np
from scipy.signal import fftconvolve, lfilter


def white(rng, samples, coefficient, dt, averaged):
    return coefficient / np.sqrt(dt) * rng.standard_normal(samples)


def quantization(rng, samples, coefficient, dt, averaged):
    """The difference of an angle that is rounded: a uniform error, not a normal one."""
    step = coefficient * np.sqrt(12)
    return np.diff(step * rng.uniform(-0.5, 0.5, samples + 1)) / dt


def flicker_by_fractional_filter(rng, samples, coefficient, dt, averaged):
    """White noise through (1 - z^-1)^(-1/2), four records long so that its start is forgotten."""
    count = 4 * samples
    ratio = (np.arange(1, count) - 0.5) / np.arange(1, count)
    response = np.concatenate([[1.0], np.cumprod(ratio)])
    drawn = rng.standard_normal(count)
    return coefficient * fftconvolve(drawn, response)[3 * samples : count]


def flicker_by_relaxations(rng, samples, coefficient, dt, averaged):
    """First-order relaxations, eight a decade, from a tenth of dt to ten records."""
    times = np.geomspace(0.1 * dt, 10 * samples * dt, 8 * int(np.log10(100 * samples)) + 1)
    # Equal variance a decade makes 1/f: S = 4 s^2 T/(1 + (2 pi f T)^2), summed over ln T.
    variance = coefficient**2 / np.pi * np.log(times[1] / times[0]) * 1.0
    total = np.zeros(samples)
    for time in times:
        decay = np.exp(-dt / time)
        drive = np.sqrt(variance * (1 - decay**2)) * rng.standard_normal(samples)
        drive[0] = np.sqrt(variance) * rng.standard_normal()
        total += lfilter([1.0], [1.0, -decay], drive)
    return total


def walk(rng, samples, coefficient, dt, averaged):
    """Steps; or the mean of sixteen sub-steps an interval."""
    if not averaged:
        return np.cumsum(coefficient * np.sqrt(dt) * rng.standard_normal(samples))
    steps = coefficient * np.sqrt(dt / 16) * rng.standard_normal(16 * samples)
    return np.cumsum(steps).reshape(samples, 16).mean(axis=1)


def record(rng, samples, dt, coefficients, *, averaged=False, relaxations=False):
    """The sum of the five terms, shape (samples,)."""
    flicker = flicker_by_relaxations if relaxations else flicker_by_fractional_filter
    makers = {"Q": quantization, "N": white, "B": flicker, "K": walk}
    total = coefficients.get("R", 0.0) * dt * np.arange(samples)
    for symbol, make in makers.items():
        if coefficients.get(symbol):
            total = total + make(rng, samples, coefficients[symbol], dt, averaged)
    return total
