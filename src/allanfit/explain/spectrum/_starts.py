"""Where the climb to each kind of effect begins, beside a model that is without it."""

import itertools

import numpy as np
from jaxtyping import Float

from ._density import noise_density
from ._in_bins import breadth
from ._model import Model, mean_density, reshaped, shaping_shape
from ._running_mean import running_means
from ._structure import (
    DROOPING,
    EACH,
    ECHO,
    FLAT,
    FLOOR,
    FREE_FILTERS,
    HIGH_PASS,
    LEFT,
    MEANS,
    NOTCH,
    RIPPLE,
    RIPPLED,
    SHAPE,
    TERMS,
    TWO_POLES,
    WINDOWED,
    Data,
    Kinds,
    bounds,
    free,
    free_filter,
    free_floor,
)

# Part of the density that a weak effect has where it is strongest.
_WEAK = 0.3
# A filter with a window is looked for where another is of a higher order, or leaves so much
# deviance a bin; its orders to begin with.
_STEEP, _POOR = 3.0, 1.25
_WINDOWS = (12.0, 36.0, 108.0)
# A steep edge beyond the Nyquist frequency doubles what is before that, where it folds.
_FOLDED = (0.62, 4.5)
# And others beside them, once what the ends leak is left out.
_BETWEEN, _WIDER = 20.0, (1.0, 1.25, 1.6)
# Of filters that have ripple, in dB.
_RIPPLES, _ATTENUATIONS = (1e-8, 0.03, 0.6), (40.0, 80.0)
# Up to such a corner a filter begins over a floor as well, with an edge of such an order.
_OVER_FLOORS, _STEEP_OVER_FLOORS = 0.3, 5.0
# A floor is read off so many bins.
_LOWEST_BINS = 8
# A notch is looked for where neighbours gain so much by being lower; how wide and deep it begins.
_NOTCHED, _NOTCH_WIDTHS, _LEFT_OVER = 12.0, (0.01, 0.05, 0.25), 0.1
# To a peak and to poles apart: free droops to begin with.
_DROOPS = (-1.0, 1.5)
# Samples after which an echo is looked for, and how many of these times are tried.
_DELAYS, _ECHOES = np.arange(2.0, 100.0, 0.25), 3

Start = tuple[str, Kinds, np.ndarray]
# Narrow bands that stand out, as (frequency, half width) in cycles per sample.
Peaks = tuple[tuple[float, float], ...]


def added_starts(name: str, peaks: Peaks, model: Model, data: Data) -> list[Start]:
    """A noise added to the model, of many shapes, each as large as it could be at most."""
    limits = bounds(name, float(data.samples))
    mean, used = mean_density(model, data), data.bins.used
    kinds = model.kinds._replace(added=(*model.kinds.added, name))
    starts: list[Start] = []
    for first, second in _shapes(name, data, peaks):
        three = np.array([0.0, free(first, *limits[0]), free(second, *limits[1])])
        unit = noise_density(name, three[None], data)[0]
        strongest = int(np.argmax(np.where(used, unit / mean, 0.0)))
        if unit[strongest] == 0:
            # A peak among frequencies that are left out, of which no others tell.
            continue
        # As much as the data have there above the model, but no less than a weak effect has.
        seen = float(data.bins.density[strongest] / mean[strongest] - 1)
        much = max(seen, _WEAK)
        for part in sorted({much, _WEAK}) if name == "gauss_markov" else [much]:
            three[0] = np.log(part * mean[strongest] / unit[strongest])
            starts.append((name, kinds, np.concatenate([model.theta, three])))
    families = (FREE_FILTERS, TWO_POLES, DROOPING)
    alike = next((each for each in families if model.kinds.shaping in each), ())
    if starts:
        # What the filter had to bend for before may now be straight.
        best_start = starts[-1][2]
        for kind, cutoff in itertools.product(alike, (0.15, 0.3, 0.45)):
            kinds = kinds._replace(shaping=kind)
            again = best_start.copy()
            order = 2.0 if kind in TWO_POLES else 1.2
            three = free_filter(kind, cutoff, order, float(data.samples), again[TERMS])
            again[TERMS : TERMS + EACH] = three
            starts.append((name, kinds, again))
    return starts


def _shapes(name: str, data: Data, peaks: Peaks) -> list[tuple[float, float]]:
    samples = float(data.samples)
    if name == "gauss_markov":
        return [(t, 1.0) for t in np.geomspace(0.6, samples / 12, 8)]
    if name == "power_law":
        return [(exponent, 1.0) for exponent in (0.6, 1.5, 2.5)]
    if name == "resonance":
        broad = [(f, 2.0) for f in np.geomspace(8 / samples, 0.4, 8)]
        return broad + [(f, f / (2 * w)) for f, w in peaks]
    return [(f, w / f) for f, w in peaks]


def highest(model: Model, data: Data) -> Peaks:
    """Where the spectrum stands highest above the model: a narrow and a broad band."""
    mean, apart = _neighbours(model, data, 3)
    at = int(np.argmax(np.where(mean > 1, apart, 0.0)))
    frequency = float(data.bins.frequency[at])
    return (frequency, 0.03 * frequency), (frequency, 0.15 * frequency)


def _neighbours(
    model: Model, data: Data, many: int
) -> tuple[Float[np.ndarray, " bins"], Float[np.ndarray, " bins"]]:
    """About each bin the mean of neighbours over the model's, and how much deviance that is."""
    ratio = np.where(data.bins.used, data.bins.density / mean_density(model, data), 1.0)
    shape = np.asarray(data.bins.shape)
    kernel = np.ones(many)
    weight = np.convolve(shape, kernel, "same")
    mean = np.convolve(shape * ratio, kernel, "same") / np.maximum(weight, 1e-9)
    return mean, weight * (mean - 1 - np.log(np.maximum(mean, 1e-9)))


def filter_starts(model: Model, data: Data) -> list[Start]:
    """A low-pass filter of each kind, corners all over the spectrum."""
    density, used, frequency = data.bins.density, data.bins.used, data.bins.frequency
    starts = []
    shapes = [*itertools.product((0.02, 0.08, 0.25, 0.48), (1.0, 2.5)), _FOLDED]
    for kind, (cutoff, order) in itertools.product(FREE_FILTERS, shapes):
        if cutoff > bounds(kind, float(data.samples))[0][1]:
            continue
        three = free_filter(kind, cutoff, order, float(data.samples))
        _, kinds, theta = _shaping_start(kind, three, model)
        # White noise as it is below the cut-off, and little of what rises beyond it.
        below = used & (frequency > cutoff / 8) & (frequency < cutoff / 2)
        if below.any():
            theta[1] = np.log(np.median(density[below]) / 2)
        theta[0] = min(theta[0], np.log(np.median(density[used][-8:]) / 80))
        starts.append(("low_pass", kinds, theta))
        if cutoff < _OVER_FLOORS and order > 1:
            # Else a hump beside white noise would stand for it.
            three = free_filter(kind, cutoff, _STEEP_OVER_FLOORS, float(data.samples))
            _, kinds, steep = _shaping_start(kind, three, model)
            steep[1] = theta[1]
            starts.append(("low_pass", *_floored(kinds, steep, theta[1], data)))
    for kind, cutoff, order in running_means(data):
        three = free_filter(kind, cutoff, order, float(data.samples))
        starts.append(("low_pass", *_shaping_start(kind, three, model)[1:]))
    return starts


def filtered_last(starts: list[Start]) -> list[Start]:
    """The same with added noises in front of the filter too, where it is behind the converter."""
    return [
        (name, kinds._replace(last=True), theta)
        for name, kinds, theta in starts
        if kinds.angle_filtered and kinds.added and not kinds.last
    ]


def droop_starts(model: Model, data: Data) -> list[Start]:
    """The filter that the model has, of another shape."""
    starts = []
    cutoff, order = shaping_shape(model, data)
    for kind, droop in itertools.product(DROOPING, _DROOPS):
        starts.append(("droop", *reshaped(model, kind, cutoff, order, data, droop)))
    return starts + [("droop", *start) for start in windowed_starts(model, data)]


def two_pole_starts(model: Model, data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """The filter that the model has, if its order is free, as one of two poles."""
    if model.kinds.shaping not in FREE_FILTERS:
        return []
    cutoff, _ = shaping_shape(model, data)
    shapes = itertools.product(TWO_POLES, _DROOPS)
    return [reshaped(model, kind, cutoff, 2.0, data, droop) for kind, droop in shapes]


def floored_starts(model: Model, data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """The filter that the model has, with white noise behind it; steeper, if its order is free."""
    kinds, (cutoff, order) = model.kinds, shaping_shape(model, data)
    shapes = [(kinds.shaping or "", order)]
    if kinds.shaping in FREE_FILTERS:
        shapes = [*itertools.product(FREE_FILTERS, (order, 2 * order))]
    starts = []
    for kind, each in () if kinds.floored or kinds.shaping in MEANS else shapes:
        shaped = reshaped(model, kind, cutoff, each, data, model.theta[TERMS])
        starts.append(_floored(*shaped, model.theta[1], data))
    return starts


def _floored(kinds: Kinds, theta: np.ndarray, white: float, data: Data) -> tuple[Kinds, np.ndarray]:
    """The same with a floor where the spectrum is lowest, and no quantization in its place.

    `white` is the logarithm of the white power that the floor is a part of.
    """
    lowest = np.sort(data.bins.density[data.bins.used])[:_LOWEST_BINS].mean()
    theta = theta.copy()
    theta[0], theta[SHAPE.stop - 1] = FLOOR, free_floor(lowest / (2 * np.exp(white)))
    return kinds._replace(floored=True), theta


def floored_or_not(
    starts: list[tuple[Kinds, np.ndarray]], model: Model, data: Data
) -> list[tuple[Kinds, np.ndarray]]:
    """Filters beside the terms of a model, each with white noise behind it and without."""
    every = []
    for kinds, theta in starts:
        bare = theta.copy()
        bare[SHAPE.stop - 1] = FLOOR
        every += [
            (kinds._replace(floored=False), bare),
            _floored(kinds, theta, model.theta[1], data),
        ]
    return every


def windowed_starts(model: Model, data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """The filter that the model has, with an edge as steep as it asks for."""
    cutoff, order = shaping_shape(model, data)
    poor = model.deviance > _POOR * np.count_nonzero(data.bins.used)
    starts = []
    for taps in _WINDOWS if (order > _STEEP or poor) and cutoff < 0.5 else ():
        starts.append(reshaped(model, WINDOWED, cutoff, taps, data))
    return starts


def rippled_starts(model: Model, data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """The filter that the model has, if it is a poor one, with ripple and any number of poles."""
    cutoff, _ = shaping_shape(model, data)
    poor = model.deviance > _POOR * np.count_nonzero(data.bins.used)
    starts = []
    shapes = itertools.product(RIPPLED, _RIPPLES, _ATTENUATIONS)
    for kind, ripple, attenuation in shapes if poor else ():
        if cutoff > 0.9 * bounds(kind, data.samples)[0][1]:
            continue
        starts.append(reshaped(model, kind, cutoff, attenuation, data, free(ripple, *RIPPLE)))
    return starts


def other_windows(model: Model, data: Data) -> list[tuple[Kinds, np.ndarray]]:
    """The window that the model has, of other lengths and wider, without quantization."""
    cutoff, _ = shaping_shape(model, data)
    starts = []
    for wider, taps in itertools.product(_WIDER, (*_WINDOWS, _BETWEEN)):
        kinds, theta = reshaped(model, WINDOWED, min(wider * cutoff, 0.45), taps, data)
        # What another filter needed of it would make a window of half the length do.
        theta[0] = FLOOR
        starts.append((kinds, theta))
    return starts


def bump_starts(model: Model, data: Data) -> list[Start]:
    """A bump at each octave and of each kind, as high as the data are there."""
    starts = []
    mean, density, shape = mean_density(model, data), data.bins.density, data.bins.shape
    frequency = data.bins.frequency
    low, high = frequency[data.bins.used].min(), frequency[data.bins.used].max()
    for centre in np.geomspace(2 * low, high * 0.9, 12):
        for shaping, width in itertools.product(("bump", FLAT), (0.15, 0.5)):
            weight = shape * np.exp(-((np.log(frequency / centre) / width) ** 2) / 2)
            if weight.sum() < 1:
                continue
            height = np.log(np.sum(weight * density / mean) / weight.sum())
            three = [6 * np.arctanh(np.clip(height, -5, 5) / 6)]
            limits = bounds(shaping, data.samples)
            three += [free(centre, *limits[0]), free(width, *limits[1])]
            starts.append(("bump", *_shaping_start(shaping, three, model)[1:]))
    starts += notch_starts(model, data)
    starts += echo_starts(model, data)
    limits = bounds(HIGH_PASS, data.samples)
    for centre, width in itertools.product(np.geomspace(2 * low, high / 4, 8), (0.25, 0.5)):
        three = [0.0, free(centre, *limits[0]), free(width, *limits[1])]
        starts.append(("bump", *_shaping_start(HIGH_PASS, three, model)[1:]))
    return starts


def notch_starts(model: Model, data: Data, least: float = 0.0) -> list[Start]:
    """A notch where the spectrum lies lowest below the model.

    None where it hardly does, or what it lacks there is no such deviance.
    """
    starts, limits, place = [], bounds(NOTCH, data.samples), model.kinds.first_slot
    kinds = model.kinds._replace(notches=model.kinds.notches + 1)
    for many in (1, 3, 9):
        mean, apart = _neighbours(model, data, many)
        lack = np.where(mean < 1, apart, 0.0)
        at = int(np.argmax(lack))
        if lack[at] < max(_NOTCHED, least):
            continue
        centre = float(data.bins.frequency[at])
        for width in _NOTCH_WIDTHS:
            three = [free(_LEFT_OVER, *LEFT), free(centre, *limits[0]), free(width, *limits[1])]
            starts.append(("bump", kinds, np.insert(model.theta, place, three)))
    return starts


def echo_starts(model: Model, data: Data, least: float = 0.0) -> list[Start]:
    """An echo of each of the times after which the spectrum's ripples are the largest.

    None whose ripple gains no such deviance.
    """
    if model.kinds.shaping is not None:
        return []
    shape, nodes = np.asarray(data.bins.shape), np.asarray(data.bins.nodes)
    wide = breadth(nodes)[:, None]
    excess = np.asarray(data.bins.density) / mean_density(model, data) - 1
    ripples = np.cos(2 * np.pi * nodes[:, 1:2] * _DELAYS) * np.sinc(wide * _DELAYS)
    ripples -= np.average(ripples, axis=0, weights=shape)
    told = (shape * excess) @ ripples
    known = np.maximum(shape @ ripples**2, 1e-12)
    # Whose neighbours gain less.
    gained = told**2 / known
    peaks = 1 + np.flatnonzero((gained[1:-1] > gained[:-2]) & (gained[1:-1] > gained[2:]))
    limits, starts = bounds(ECHO, data.samples), []
    for at in peaks[np.argsort(-gained[peaks])][:_ECHOES]:
        if gained[at] < least:
            break
        part = np.clip(told[at] / known[at] / 2, -0.9, 0.9)
        three = [float(np.arctanh(part)), free(1 / float(_DELAYS[at]), *limits[0]), 0.0]
        starts.append(("bump", *_shaping_start(ECHO, three, model)[1:]))
    return starts


def _shaping_start(name: str, three: list[float], model: Model) -> Start:
    theta = np.concatenate([model.theta[:TERMS], three, [FLOOR], model.theta[TERMS:]])
    return name, model.kinds._replace(shaping=name), theta
