"""Both curves, the course in time and the lines, before and after, as plain data."""

from collections import Counter
from typing import Any

import numpy as np
from jaxtyping import Float

from ..curves import allan_variance
from ..identify import Fit
from ..identify._curves_document import curves_document, listed
from ._effect import Effect
from ._state import Investigation
from .courses._course import fallen
from .spectrum._density import effects_density
from .spectrum._model import mean_density
from .spectrum._narrow import beside, density_of, narrow_noises
from .spectrum._structure import EACH, NARROW
from .values._clock import logged_density

_BLOCKS = 360
_LINE_POINTS = 161
# Frequencies within what a point of these stands for.
_WITHIN = 8
_GRID = 24_000


def explained_curves(
    fit: Fit, after: Fit, state: Investigation, effects: list[Effect], factor: float
) -> dict[str, Any]:
    """The `curves` of one channel in the explain JSON, in the unit that the user gave."""
    dt = 1 / float(fit.rate_hz)
    before = curves_document(fit, factor)
    course = state.drawn
    allan, psd = before["allan"], before["psd"]
    density, added = _density(fit, state, course)
    names = _labels(state, effects)
    psd_effects = {
        name: listed(each * dt / factor**2) for name, each in zip(names, added, strict=False)
    }
    sizes = np.asarray(allan["tau_s"]) / dt
    variance, parts = _allan_after(sizes, after, state, course, dt)
    return {
        "allan": {
            "tau_s": allan["tau_s"],
            "deviation": allan["deviation"],
            "model_before": allan["model"],
            "model_after": listed(np.sqrt(variance) / factor),
            "band_95": allan["band_95"],
            "effects": {
                name: listed(np.sqrt(np.maximum(part, 0)) / factor)
                for name, part in zip(names, parts, strict=False)
            },
        },
        "psd": {
            "frequency_hz": psd["frequency_hz"],
            "density": psd["density"],
            "model_before": psd["model"],
            "model_after": listed(density * dt / factor**2),
            "band_95": psd["band_95"],
            "effects": psd_effects,
        },
        "time": _time(state, course, effects, state.stride * dt, factor),
        "lines": _lines(state, effects, state.stride * dt, factor),
    }


def _labels(state: Investigation, effects: list[Effect]) -> list[str]:
    """Names of the added noises, each its own: of one name the strongest has no number."""
    kinds, names, powers = state.model.kinds, [], []
    for place, kind in enumerate(kinds.added):
        name, power = kind, 0.0
        if kind in NARROW:
            # As effects are listed; twice the power of a line is the square of its amplitude.
            power = float(state.model.theta[kinds.first_slot + EACH * place])
            power -= np.log(2) if kind == "drifting_line" else 0.0
        if place in state.wandering:
            name = "drifting_line"
        elif place in state.disowned_noises:
            # It describes what has no name.
            name = "bump"
        shown = next(
            (
                e.name
                for e in effects
                if e.name == name
                or (name == "gauss_markov" and e.name in ("random_telegraph", "temperature"))
            ),
            name,
        )
        names.append(shown)
        powers.append(power)
    labels, told = names.copy(), Counter[str]()
    for place in sorted(range(len(names)), key=lambda place: -powers[place]):
        name = names[place]
        told[name] += 1
        if told[name] > 1:
            labels[place] = f"{name} {told[name]}"
    return labels


def _density(fit: Fit, state: Investigation, course):
    """Mean of the better model over each bin of the fit's spectrum, and of each added noise."""
    spectrum, data = state.spectrum, state.data
    total = state.variance
    if state.sized is not None and course is not None:
        moved = spectrum.amplitude - state.left.amplitude
        total = total + moved**2
    at = spectrum.frequency
    if state.stride > 1:
        # Of the log, not of the fresh values.
        at = np.arange(1, int(at.size * state.stride)) / (2 * at.size * state.stride)
    middle = np.asarray(fit.design.frequency)
    bounds = np.sqrt(middle[1:] * middle[:-1])
    index = np.searchsorted(bounds, at)
    count = np.maximum(np.bincount(index, minlength=middle.size), 1)
    added = effects_density(state.model.theta, state.model.kinds, data)
    used = data.bins.used
    frequency = data.bins.frequency[used]

    def of_log(known, density):
        return logged_density(at, state.stride, lambda f: np.interp(f, known, density))

    def mean(density):
        return np.bincount(index, density, minlength=middle.size) / count

    shares = [mean(of_log(frequency, each[used])) for each in added]
    return mean(total if state.stride == 1 else of_log(spectrum.frequency, total)), shares


def _allan_after(sizes, after: Fit, state: Investigation, course, dt: float):
    """Expected Allan variance of the better model: of its density through the Allan filter."""
    data, used = state.data, state.data.bins.used
    frequency = data.bins.frequency[used]
    first = frequency[0]
    mean = np.log(mean_density(state.model, data)[used])
    power = np.where(data.terms, np.exp(state.model.theta[:4]), 0.0)

    def noise(f):
        f = np.maximum(f, first / 100)
        density = np.exp(np.interp(np.log(f), np.log(frequency), mean))
        # Below the record's lowest frequency flicker and random walk go on as they are.
        slow = power[3] / (2 * np.pi**2 * f**2) + power[2] / (np.pi * f)
        least = np.exp(mean[0]) * fallen(state.model, data, f, first)
        return np.where(f < first, np.minimum(slow + least, 1e3 * least), density)

    stride = state.stride
    grid = np.geomspace(first / 30 / stride, 0.5, _GRID)
    density = logged_density(grid, stride, noise)
    added = effects_density(state.model.theta, state.model.kinds, data)[:, used]
    parts = [
        logged_density(grid, stride, lambda f, each=each: np.interp(f, frequency, each))
        for each in added
    ]
    step = np.gradient(grid)
    sine = np.sin(np.pi * grid) ** 2
    rows = [density, *parts]
    found = np.empty((len(rows), len(sizes)))
    for i, size in enumerate(sizes):
        phase = np.pi * grid * size
        # Where the filter oscillates within a step its mean is taken.
        filtering = np.where(np.pi * step * size < 0.7, np.sin(phase) ** 4, 3 / 8)
        weight = 2 * filtering / (size**2 * sine) * step
        found[:, i] = [row @ weight for row in rows]
    total = found[0]
    slope = float(after.coefficients["R"]) * dt if bool(after.resolved["R"]) else 0.0
    total = total + (slope * np.asarray(sizes)) ** 2 / 2
    if course is not None:
        start, stop = state.longest
        whole = np.unique(np.maximum(np.round(sizes / stride), 1).astype(int))
        whole = whole[2 * whole <= stop - start]
        drawn = np.asarray(allan_variance(course[start:stop], rate_hz=1.0, cluster_sizes=whole))
        total = total + np.interp(sizes / stride, whole, drawn)
    return total, found[1:]


def _time(state: Investigation, course, effects, dt: float, factor: float) -> dict[str, Any]:
    used = np.zeros(state.values.size, bool)
    for start, stop in state.pieces:
        used[start:stop] = True
    block = max(1, state.values.size // _BLOCKS)
    count = state.values.size // block
    shape = (count, block)
    weight = used[: count * block].reshape(shape)
    values = np.where(weight, state.values[: count * block].reshape(shape), 0.0)
    number = weight.sum(axis=1)
    with np.errstate(all="ignore"):
        mean = np.where(number > 0, values.sum(axis=1) / number, np.nan)
        spread = np.where(weight, values - mean[:, None], 0.0)
        deviation = np.sqrt((spread**2).sum(axis=1) / np.maximum(number - 1, 1))
    model = None
    if course is not None:
        level = float(np.nanmean(mean)) - float(course[used].mean())
        model = listed((course[: count * block].reshape(shape).mean(axis=1) + level) / factor)
    intervals = [pair for e in effects for pair in e.lists.get("intervals", [])]
    return {
        "time_s": [state.moment((k + 0.5) * block) * dt for k in range(count)],
        "mean": listed(mean / factor),
        "deviation": listed(np.where(number > 1, deviation, np.nan) / factor),
        "model": model,
        "intervals": intervals,
    }


def _lines(state: Investigation, effects, dt: float, factor: float) -> list[dict[str, Any]]:
    """The spectrum about each narrow effect, at the resolution of the record."""
    start, stop = state.longest
    piece = state.values[start:stop]
    power = None
    found = []
    for effect in effects:
        if effect.name not in ("sinusoid", "drifting_line", "resonance"):
            continue
        if power is None:
            window = np.hanning(piece.size)
            power = np.abs(np.fft.rfft((piece - piece.mean()) * window)) ** 2
            power *= 2 * dt / np.sum(window**2)
        line = effect.value("frequency")
        assert effect.band_hz is not None
        spacing = 1 / (piece.size * dt)
        reach = max(40 * spacing, 2 * (effect.band_hz[1] - effect.band_hz[0]))
        if effect.name == "sinusoid":
            reach = 40 * spacing
        low = max(int((line - reach) / spacing), 1)
        high = min(int((line + reach) / spacing) + 1, power.size)
        group = max(1, (high - low) // _LINE_POINTS)
        count = (high - low) // group
        shown = power[low : low + count * group].reshape(count, group).mean(axis=1)
        frequency = (low + (np.arange(count) + 0.5) * group - 0.5) * spacing
        # Of each point as of the record: the mean over all that it stands for.
        fine = low - 0.5 + (np.arange(count * _WITHIN) + 0.5) * group / _WITHIN
        model = _at_full_resolution(state, fine * spacing * dt) * dt
        model = model.reshape(count, _WITHIN).mean(axis=1)
        if effect.name == "sinusoid":
            # A Hann window spreads a line over four ordinates, and noise over one and a half.
            peak = effect.value("amplitude") ** 2 / 2 / (1.5 * spacing)
            away = (frequency - line) / spacing
            lobe = np.sinc(away) + (np.sinc(away - 1) + np.sinc(away + 1)) / 2
            model = model + peak * np.where(np.abs(away) < 2, lobe**2, 0.0)
        found.append(
            {
                "frequency_hz": frequency.tolist(),
                "density": listed(shown / factor**2),
                "model": listed(model / factor**2),
                "line_hz": line,
            }
        )
    return found


def _at_full_resolution(
    state: Investigation, frequency: Float[np.ndarray, " frequencies"]
) -> Float[np.ndarray, " frequencies"]:
    """What the model expects of single ordinates [u^2], at frequencies in cycles per sample.

    What is smooth is known from the bins, which a line or a resonance may be narrower than.
    """
    narrow = narrow_noises(state.model, float(state.data.samples))
    smooth = beside(state, narrow, frequency)
    return smooth + density_of(state, narrow, frequency) if narrow else smooth
