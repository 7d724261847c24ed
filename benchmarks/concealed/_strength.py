"""How strong an effect is: lambda, from expected spectra.

    lambda = 2 E[ln L(truth) - ln L(best five terms)]

with the five terms fitted anew to what the effect makes of the spectrum (PSD one-sided, u^2/Hz).
A record of n samples has about n - 2 ordinates at k/(2T), each the square of one cosine
coefficient, two degrees of freedom lost to mean and slope; with r = truth/best an ordinate is
worth r - 1 - ln r. A deterministic part adds its energy to what is expected but not to the
variance that the truth knows: (S + M)/best - 1 - ln(S/best).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import dct
from scipy.optimize import nnls

from ._device import SUB, Device

Density = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Bins:
    """Ordinates in groups, single at the lowest frequencies and around narrow features."""

    first: np.ndarray
    """Number k of each group's first ordinate; its end is the next one's first."""
    count: np.ndarray
    frequency: np.ndarray
    """Geometric middle [Hz]."""


def bins(device: Device, features: Sequence[tuple[float, float]] = (), lowest: int = 2) -> Bins:
    """About 300 bins, and 200 more over four widths either side of each (frequency, width).

    From 2/(2T) up, as the ramp is fitted; from `lowest` = 1 where that is done explicitly.
    """
    n = device.samples
    edges = [np.arange(lowest, 60), np.geomspace(60, n, 240)]
    for frequency, width in features:
        offsets = width * np.concatenate([[0], np.geomspace(0.02, 4, 100)])
        around = np.concatenate([frequency - offsets, frequency + offsets])
        edges.append(2 * device.duration * around)
    edges = np.unique(np.round(np.concatenate(edges)).astype(int))
    edges = edges[(edges >= lowest) & (edges <= n)]
    first, last = edges[:-1], edges[1:] - 1
    return Bins(first, np.diff(edges), np.sqrt(first * last) / (2 * device.duration))


def basis(device: Device, frequency: np.ndarray) -> np.ndarray:
    """Densities of unit Q^2, N^2, B^2, K^2 in sampled data, shape (4, frequencies).

    White angle error differenced; white; (1 - 1/z)^(-1/2) flicker, which other flickers approach
    wherever flicker shows; a summed walk, or its interval means.
    """
    dt, sine = device.dt, np.sin(np.pi * frequency * device.dt)
    walk = dt**2 / 2 * (1 / sine**2 - (2 / 3 if device.averaged else 0))
    return np.stack([8 * sine**2 / dt, np.full_like(sine, 2.0), dt / sine, walk])


def five_terms(device: Device) -> Density:
    squares = np.array([device.term(symbol) for symbol in "QNBK"]) ** 2
    return lambda frequency: squares @ basis(device, frequency)


def folded(device: Device, density: Density, frequency: np.ndarray) -> np.ndarray:
    """Density at the output of the converter, of what has `density` at the front end."""
    fs = device.rate_hz
    images = [abs(frequency + j * fs) for j in range(-(SUB // 2), SUB // 2)]
    return np.sum([density(f) * passes(device, f) for f in images], axis=0)


def passes(device: Device, frequency):
    """Power gain of the converter at a front-end frequency [Hz]: 1, or that of a mean."""
    if not device.averaged:
        return np.ones_like(frequency)
    x = np.pi * np.asarray(frequency) * device.dt
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(x == 0, 1.0, (np.sin(x) / (SUB * np.sin(x / SUB))) ** 2)


def best_five_terms(design: np.ndarray, expected: np.ndarray, count: np.ndarray) -> np.ndarray:
    """The five-term density closest to `expected`: non-negative scoring, halved where it rises."""

    def cost(model):
        return np.sum(count * (expected / model + np.log(model)))

    power, model = np.zeros(4), expected
    least = np.inf
    for _ in range(60):
        weight = np.sqrt(count) / model
        size = np.linalg.norm(design * weight, axis=1)
        step = nnls((design * weight / size[:, None]).T, expected * weight)[0] / size
        if not np.isfinite(least):
            power, model = step, step @ design
            least = cost(model)
            continue
        share = 1.0
        while (new := cost((power + share * (step - power)) @ design)) > least and share > 1e-3:
            share /= 2
        if new > least:
            break
        power = power + share * (step - power)
        model, gain, least = power @ design, least - new, new
        if gain < 1e-7:
            break
    return model


def information(
    device: Device,
    density: Density | None = None,
    mean: np.ndarray | None = None,
    features: Sequence[tuple[float, float]] = (),
) -> tuple[Bins, np.ndarray]:
    """What each bin adds to lambda for a device of `density` [u^2/Hz] and `mean` [u]."""
    grid = bins(device, features, 2 if mean is None else 1)
    design = basis(device, grid.frequency)
    true = (density or five_terms(device))(grid.frequency)
    if mean is None:
        best = best_five_terms(design, true, grid.count)
        ratio = true / best
        return grid, grid.count * (ratio - 1 - np.log(ratio))
    line = np.arange(device.samples) - (device.samples - 1) / 2
    wave, slope = (dct(x, norm="ortho") * np.sqrt(2 * device.dt) for x in (mean, line))
    best, energy = true, np.zeros_like(true)
    for _ in range(3):  # The ramp is the best fit in the noise that it leaves.
        weight = np.repeat(1 / best, grid.count)
        part = slice(grid.first[0], grid.first[0] + weight.size)
        ramp = np.sum(wave[part] * slope[part] * weight) / np.sum(slope[part] ** 2 * weight)
        left = (wave - ramp * slope)[part] ** 2
        energy = np.add.reduceat(left, grid.first - grid.first[0]) / grid.count
        best = best_five_terms(design, true + energy, grid.count)
    return grid, grid.count * ((true + energy) / best - 1 - np.log(true / best))


def line_strength(device: Device, amplitude: float, frequency: float) -> float:
    """A^2 T/S: twice the expected gain of a sinusoid of known frequency in noise of density S."""
    density = five_terms(device)(np.array([frequency]))[0]
    return float(amplitude**2 * device.duration / density)


def modulation_strength(device: Device, white_power: np.ndarray) -> float:
    """Lambda of a white noise whose power, relative to its mean, takes these equally long values.

    n <ln <S> - <ln S>>, the inner means over time and the outer one over frequency.
    """
    frequency = (np.arange(200) + 0.5) / 400 * device.rate_hz
    rest = five_terms(device)(frequency)
    white = 2 * device.term("N") ** 2
    local = rest + white * (white_power / white_power.mean() - 1)[:, None]
    gain = np.log(local.mean(axis=0)) - np.log(local).mean(axis=0)
    return float(device.samples * gain.mean())


def deviation(device: Device) -> float:
    """Standard deviation of the samples about a slow drift [u]."""
    frequency = (np.arange(2000) + 0.5) / 4000 * device.rate_hz
    return float(np.sqrt(five_terms(device)(frequency).mean() * device.rate_hz / 2))


def innovation(device: Device) -> float:
    """Deviation of white noise in which one odd sample shows as well as in this noise [u]."""
    frequency = (np.arange(2000) + 0.5) / 4000 * device.rate_hz
    return float(np.sqrt(device.rate_hz / 2 / np.mean(1 / five_terms(device)(frequency))))


def holding_band(grid: Bins, contribution: np.ndarray, share: float = 0.8) -> tuple[float, float]:
    """The shortest band in ln f that holds `share` of the information [Hz]."""
    edges = np.append(grid.first, grid.first[-1] + grid.count[-1]) - 0.5
    total = np.concatenate([[0], np.cumsum(contribution)])
    total /= total[-1]
    last = np.searchsorted(total, total + share - 1e-12)
    start = np.flatnonzero(last < total.size)
    best = start[np.argmin(edges[last[start]] / edges[start])]
    scale = grid.frequency[0] / grid.first[0]
    return float(edges[best] * scale), float(edges[last[best]] * scale)
