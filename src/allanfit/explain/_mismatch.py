"""Where the five terms differ from the recording: bands and times, strongest first."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ._chance import log_chance
from ._effect import Effect
from ._state import Investigation
from .courses import _course
from .spectrum import _model
from .values._clock import logged_density

# Part of the evidence that a reported band holds.
_INSIDE = 0.8
#: A p-value of zero cannot be told.
CHANCE_FLOOR = 1e-300
# What no spectrum shows, but the values or their times.
_IN_VALUES = {
    "saturation": "Values pile up at the end of the range",
    "output_rounding": "The values fall on few codes",
    "outliers": "Some values are larger than normal noise has them",
    "dropped_samples": "The time stamps leave out samples",
}
# Other names under which an effect may have been found.
_FOUND_AS = {
    "random_telegraph": ("gauss_markov",),
    "temperature": ("sinusoid", "resonance", "drifting_line"),
    "drifting_line": ("resonance",),
    "resonance": ("drifting_line",),
    "bump": ("sinusoid", "resonance", "drifting_line", "low_pass", "variance_modulation"),
}
# So many intervals are told each.
_MOST_TIMES = 3
# Of what is more in one part of a band so much is less in another, for its mean to say nothing; nor
# does a mean that is so near one.
_MIXED, _NEAR_ONE = 0.25, 0.02
_IN_TIME = ("step", "warm_up", "disturbance", "variance_modulation")


Mismatch = dict[str, Any]


class Located(NamedTuple):
    """Where an effect shows, and the effect."""

    entry: Mismatch
    effect: Effect


def located(state: Investigation, effects: Sequence[Effect], dt: float) -> list[Located]:
    """One entry an effect, with its name, in Hz or s."""
    found = []
    own = state.findings_of([effect.name for effect in effects])
    for effect, finding in zip(effects, own, strict=True):
        log_p = _log_chance(state, effect.name) if finding is None else finding.log_p
        chance = math.exp(max(log_p, math.log(CHANCE_FLOOR)))
        if effect.name == "sample_hold" and state.stride > 1:
            entry = _images(state, chance, dt)
        elif effect.name in _IN_VALUES:
            seen = _IN_VALUES[effect.name]
            if effect.name == "dropped_samples" and effect.note:
                seen = f"The phase of the line at {effect.note} jumps ahead"
            said = f"{seen}, at any time of the recording."
            entry = _of_time(0.0, state.moment(state.values.size) * dt, 1.0, chance, said)
        elif effect.name in _IN_TIME or effect.in_time:
            entry = _in_time(state, effect, chance, dt)
        else:
            entry = _in_frequency(state, effect, chance, dt)
        found.append(Located({**entry, "effect": effect.name}, effect))
    return sorted(found, key=lambda each: each.entry["p_value"])


def once(entries: Sequence[Mismatch]) -> list[Mismatch]:
    """Places without those that say of another effect what was said before, but for the chance."""
    told: list[Mismatch] = []
    said: list[Mismatch] = []
    for entry in entries:
        what = {name: each for name, each in entry.items() if name != "p_value"}
        if what not in said:
            said.append(what)
            told.append(entry)
    return told


def meet(one: Mismatch, other: Mismatch) -> bool:
    """Whether two places have one in common."""
    return (
        one["domain"] == other["domain"]
        and one["low"] <= other["high"]
        and other["low"] <= one["high"]
    )


def _log_chance(state: Investigation, name: str) -> float:
    """Log of the chance of what an effect was named for, found by another name."""
    if name == "bump" and state.unexplained is not None:
        return log_chance("bump", state.unexplained.gain)
    names = (name, *_FOUND_AS.get(name, ()))
    return min((each.log_p for each in state.findings if each.name in names), default=state.nearest)


def _in_time(state: Investigation, effect: Effect, chance: float, dt: float) -> dict[str, Any]:
    end = state.moment(state.values.size) * dt
    if effect.in_time:
        seen = effect.note.partition(";")[0]
        return _of_time(0.0, end, 1.0, chance, f"{seen[0].upper()}{seen[1:]}.")
    if effect.name == "warm_up":
        low, high = 0.0, min(3 * effect.value("time_constant"), end)
        ratio = 1.0
    elif effect.name == "step":
        low, high = min(effect.lists["times"]), max(effect.lists["times"])
        ratio = 1.0
    else:
        times = effect.lists["intervals"]
        low, high = min(pair[0] for pair in times), max(pair[1] for pair in times)
        ratio = effect.value("ratio") if "ratio" in effect.parameters else 1.0
        if 1 < len(times) <= _MOST_TIMES:
            each = " and ".join(f"from {start:.5g} to {stop:.5g} s" for start, stop in times)
            said = f"The recording is not the same throughout: it differs {each}."
            return _of_time(low, high, ratio, chance, said)
    where = f"at {low:.5g} s" if high - low < 1e-3 * end else f"from {low:.5g} to {high:.5g} s"
    said = f"The recording is not the same throughout: it differs {where}."
    return _of_time(low, high, ratio, chance, said)


def _of_time(low: float, high: float, ratio: float, chance: float, said: str) -> dict[str, Any]:
    """The entry of a time [s]."""
    return {
        "domain": "time",
        "low": low,
        "high": high,
        "unit": "s",
        "ratio": ratio,
        "p_value": chance,
        "sentence": said,
    }


def _images(state: Investigation, chance: float, dt: float) -> dict[str, Any]:
    """Where a log that is faster than the sensor's clock has images of what is below."""
    low, high = 0.5 / dt, 0.5 * state.stride / dt
    ratio = float(
        logged_density(np.linspace(0.5 / state.stride, 0.5), state.stride, np.ones_like).mean()
    )
    what = f"images of what is below, {ratio:.2g} times the power that white noise has there"
    return _of_band(low, high, ratio, chance, what)


def _in_frequency(state: Investigation, effect: Effect, chance: float, dt: float) -> dict[str, Any]:
    low, high = _band(state, effect, dt)
    # By single ordinates: a bin is wider than a line.
    frequency = state.spectrum.frequency / dt
    begin, end = np.searchsorted(frequency, [low, high])
    begin = min(begin, frequency.size - 1)
    inside = slice(begin, max(end, begin + 1))
    part = state.spectrum._replace(
        frequency=state.spectrum.frequency[inside], amplitude=state.spectrum.amplitude[inside]
    )
    expected = _course.ordinate_variance(part, state.first, state.first_data)
    ratio = float(np.mean(part.amplitude**2 / expected))
    if effect.name == "sinusoid":
        # Where samples are lost the ordinates smear what times tell.
        line = effect.value("amplitude") ** 2 * state.spectrum.longest / expected.size
        ratio = max(ratio, 1 + line / float(np.mean(expected)))
    power = _least_and_most(state, part.frequency[0], part.frequency[-1], ratio, dt)
    power = power or f"{ratio:.3g} times the power"
    return _of_band(low, high, ratio, chance, f"{power} that the five terms expect")


def _least_and_most(state: Investigation, low: float, high: float, ratio: float, dt: float) -> str:
    """How much power there is where in a band [cycles per sample] whose mean says nothing.

    There is more in one part and less in another, or hardly anything changes; "" elsewhere.
    """
    bins = state.data.bins
    inside = bins.used & (bins.frequency >= low) & (bins.frequency <= high)
    if np.count_nonzero(inside) < 2:
        return ""
    frequency = bins.frequency[inside]
    before = _course.ordinate_variance(
        state.spectrum._replace(frequency=frequency), state.first, state.first_data
    )
    modelled = _model.mean_density(state.model, state.data)[inside] / before
    change = np.asarray(bins.shape)[inside] * (modelled - 1)
    more, less = np.maximum(change, 0).sum(), np.maximum(-change, 0).sum()
    if abs(ratio - 1) > _NEAR_ONE and min(more, less) < _MIXED * max(more, less):
        return ""
    ends = sorted((np.argmin(modelled), np.argmax(modelled)))
    told = (f"{modelled[k]:.3g} times (at {frequency[k] / dt:.3g} Hz)" for k in ends)
    return f"between {' and '.join(told)} the power"


def _of_band(low: float, high: float, ratio: float, chance: float, what: str) -> dict[str, Any]:
    """The entry of a band [Hz], in which the recording has `what`."""
    return {
        "domain": "frequency",
        "low": low,
        "high": high,
        "unit": "Hz",
        "ratio": ratio,
        "p_value": chance,
        "sentence": f"{span(low, high)} the recording has {what}.",
    }


def span(low: float, high: float) -> str:
    """A band [Hz] at the beginning of a sentence, in as many digits as tell its ends apart."""
    for digits in range(4, 10):
        ends = f"{low:.{digits}g}", f"{high:.{digits}g}"
        if ends[0] != ends[1]:
            return f"From {ends[0]} to {ends[1]} Hz"
    return f"At {low:.4g} Hz"


def _band(state: Investigation, effect: Effect, dt: float) -> tuple[float, float]:
    """The shortest band with most of what the effect changes, or where its line is."""
    if effect.name == "sinusoid":
        line, width = effect.value("frequency"), 0.5 / (state.spectrum.longest * dt)
        return line - width, line + width
    if effect.unmodelled and effect.band_hz is not None:
        return effect.band_hz
    name = "gauss_markov" if effect.name == "random_telegraph" else effect.name
    # One among several of a name is not told from the others by leaving it out.
    if state.model.kinds.names.count(name) != 1:
        if effect.band_hz is not None:
            return effect.band_hz
        return 0.5 / (state.spectrum.longest * dt), 0.5 / dt
    start = _model.without(state.model, state.model.kinds.names.index(name))
    less = _model.best([(start.kinds, start.theta)], state.data)[0]
    after = _model.mean_density(state.model, state.data)
    before = _model.mean_density(less, state.data)
    bins = state.data.bins
    evidence = np.where(bins.used, np.asarray(bins.shape) * (after / before - 1) ** 2, 0.0)
    frequency, evidence = bins.frequency[bins.used], evidence[bins.used]
    total = np.concatenate([[0.0], np.cumsum(evidence)])
    # For each first bin the last that is needed; the shortest band in the logarithm.
    last = np.searchsorted(total, total[:-1] + _INSIDE * total[-1])
    possible = np.flatnonzero(last <= evidence.size)
    width = np.log(frequency[last[possible] - 1] / frequency[possible])
    first = int(possible[np.argmin(width)])
    return float(frequency[first]) / dt, float(frequency[last[first] - 1]) / dt
