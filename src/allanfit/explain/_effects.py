"""From what an investigation found to named effects with parameters, in SI units and seconds."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from ..physics import LowPass
from ._effect import Effect
from ._state import Investigation, Unknown
from .courses._effects import ROOM_PERIOD_S, corner_band, of_courses, slow_swing
from .courses._switches import levels_of
from .lines._moments import in_the_long_run
from .lines._parts import merged
from .spectrum._posterior import Draws
from .spectrum._structure import (
    DROOPS,
    EACH,
    ECHO,
    FLAT,
    HIGH_PASS,
    NARROW,
    NOTCH,
    RIPPLED,
    SHAPE,
    TWO_POLES,
    UNNAMED,
    bounds,
    left_of,
    part_of,
    shape_of,
    sieve,
)
from .values._clipped import rails
from .values._effects import LINE, MAKERS, SURE, probabilities, seconds
from .values._spikes import USUAL

# So many times of a line are told.
_MOST_TIMES = 3
_BAND = "a band of noise {:.3g} times as strong, from {:.3g} to {:.3g} Hz, with steep flanks"
_NOTCH = "a notch at {:.4g} Hz with a quality factor of {:.3g}, down {} of the power"
_REPEATED = (
    "an echo, as if each sample held {:+.2g} % of the one {:.4g} s before it as well, so that the "
    "spectrum ripples every {:.4g} Hz"
)
# What is as little is not told from nothing.
_NOTHING, _FAINT = "to less than a hundredth", 0.01
_CUT = (
    "noise is missing below {:.3g} Hz, as behind a high-pass filter of order {:.2g}: alternating-"
    "current coupling, or a mean that is estimated and taken off all the time"
)
# So many wandering biases switch between two levels, before any look at the levels.
_TELEGRAPH = 0.15
# From this droop on the second of two poles takes less than a fiftieth of the power anywhere.
_ONE_POLE = 0.97
# Lower at its best, white noise behind a filter is none [dB].
_NO_FLOOR = -80.0
# Ripple that nobody designs, and attenuation that no spectrum shows [dB].
_FLAT_DB, _FALLING_DB = 0.005, 90.0
# Cycles per sample.
_NYQUIST = 0.5
# Levels are held for different times if their shares differ by so many standard deviations.
_UNEVEN = 3.0
_MOST_TELEGRAPH = 0.96
# In e-folds: what is narrower has one frequency.
_NARROW = 0.1


def effects_of(state: Investigation, draws: Draws | None, dt: float, seed: int) -> list[Effect]:
    """All effects of an investigation, those of one kind put together where they are one."""
    found: list[Effect] = []
    rng = np.random.default_rng(seed)
    for finding in state.findings:
        if finding.name in state.model.kinds.names:
            continue
        maker = MAKERS.get(finding.name)
        if maker is not None:
            found += maker(state, finding, dt, rng)
    found += of_courses(state, dt, rng)
    if draws is not None:
        found += _structural(state, draws, dt, seed)
    if any(effect.name == "random_telegraph" for effect in found):
        # Fast switches between levels that are far apart are long tails too.
        found = [each for each in found if each.name != "outliers" or not _usual(each)]
    named = [effect for effect in found if not _disowned(state, effect, dt)]
    return merged(named) + [_unknown(state, unknown, dt) for unknown in state.unknown]


def _usual(effect: Effect) -> bool:
    """Whether spikes are what the noise is like."""
    return effect.value("fraction") > USUAL


def _disowned(state: Investigation, effect: Effect, dt: float) -> bool:
    if effect.name == "sinusoid":
        lines = np.array(state.disowned_lines) / dt
        return bool(
            np.any(np.abs(lines - effect.value("frequency")) < 0.1 / state.values.size / dt)
        )
    return effect.name in state.disowned


def _unknown(state: Investigation, unknown: Unknown, dt: float) -> Effect:
    middle, width = unknown.frequency / dt, unknown.width
    values = {"height": 0.0, "frequency": middle, "width": width}
    band = (middle * np.exp(-width), min(middle * np.exp(width), 0.5 / dt))
    draws = {name: np.full(2, value) for name, value in values.items()}
    note = unknown.why
    if unknown.ends is not None:
        note += ", from {:.4g} to {:.4g} Hz".format(*(end / dt for end in unknown.ends))
    elif unknown.period:
        note += f", every {unknown.period * dt:.4g} s"
    elif unknown.in_time and not unknown.bandless:
        note += ", from {:.3g} to {:.3g} Hz".format(*band)
    if unknown.ends is None and not unknown.in_time and width < _NARROW:
        note += f", at {middle:.4g} Hz"
    note += _mostly(state, unknown.times, dt) + (f"; {unknown.like}" if unknown.like else "")
    return Effect("bump", LINE, {}, draws, {}, band, note, unknown.in_time)


def _structural(state: Investigation, draws: Draws, dt: float, seed: int) -> list[Effect]:
    kinds, samples = state.model.kinds, state.data.samples
    findings, cut = state.findings_of(kinds.names), rails(state)
    found = []
    if draws.filtering is not None:
        cutoff, order, droop, ripple, attenuation, floor = draws.filtering.T
        kind = sieve(kinds.shaping or "", state.model.theta[SHAPE], samples)
        if kinds.shaping in TWO_POLES:
            # Of two poles so far apart one is not seen, and with it no droop is.
            order = np.where((order == 2) & (droop > _ONE_POLE), 1.0, order)
        values = {"cutoff_frequency": cutoff / dt, "order": order}
        if kinds.shaping in DROOPS:
            values["droop"] = droop
        if kinds.shaping in RIPPLED:
            values |= {"ripple": ripple, "attenuation": attenuation}
        if kinds.floored and kind.floor is not None and float(kind.floor) > _NO_FLOOR:
            values["floor"] = floor
        # What is told together must belong together: the numbers of one kind of filter.
        told = {name: float(np.median(each[draws.of_likeliest])) for name, each in values.items()}
        if kinds.shaping in TWO_POLES and told["order"] == 1:
            values.pop("droop")
        values["cutoff_frequency"] = _of_any_converter(cutoff, seed) / dt
        flags = ("digital", "averaged", "recursive", "running_mean", "oversampled", "windowed")
        flag = {name: np.ones(2) for name in flags if getattr(kind, name)}
        if kinds.last and any(name != "drifting_line" for name in kinds.added):
            flag["last"] = np.ones(2)
        own, others = probabilities(state.finding("low_pass"), "low_pass")
        found.append(
            Effect(
                "low_pass",
                own,
                others,
                {**values, **flag},
                {},
                (told["cutoff_frequency"] / 4, 0.5 / dt),
                note=_described(kind, told),
                told=told,
            )
        )
    unnamed = []
    if kinds.shaping in UNNAMED:
        unnamed.append(_unnamed(kinds.shaping, draws.theta[:, SHAPE].T, samples, dt))
    for begin in range(kinds.first_notch, kinds.first_slot, EACH):
        unnamed.append(_notch(draws.theta[:, begin : begin + EACH].T, samples, dt))
    compared = next((f for f in state.findings if f.name == "bump" and f.rivals), None)
    own, others = probabilities(compared, "bump")
    found += [replace(each, probability=own, alternatives=others) for each in unnamed]
    for place, name in enumerate(kinds.added):
        if place in state.disowned_noises:
            continue
        begin = kinds.first_slot + EACH * place
        three = draws.theta[:, begin : begin + EACH].T
        first, second = (np.asarray(each) for each in shape_of(name, three, samples))
        # Of noise that is clipped all noises pass in part.
        size = np.exp(three[0] / 2) / (1.0 if cut is None else cut.gain)
        own, others = probabilities(findings[place - len(kinds.added)], name)
        disguised = name == "resonance" and place in state.wandering
        if name == "gauss_markov":
            found += _gauss_markov(state, begin, size, first, own, others, dt, seed)
        elif name in NARROW and not disguised and float(np.median(first)) / dt * ROOM_PERIOD_S < 1:
            found.append(slow_swing(name, own, others, first / dt))
        elif name == "resonance" and not disguised:
            middle, half = float(np.median(first)) / dt, float(np.median(first / second)) / 2 / dt
            values = {"sigma": size, "frequency": first / dt, "quality_factor": second}
            band = (max(middle - 2 * half, 0.0), middle + 2 * half)
            found.append(Effect(name, own, others, values, {}, band, _when(state, dt)))
        elif name == "power_law":
            density = size**2 * dt ** (1 - first)
            found.append(
                Effect(name, own, others, {"exponent": first, "density": density}, {}, None)
            )
        else:
            if disguised:
                # As wide as the resonance, and of its power among the samples.
                left = np.sinc(first) ** 2 if state.data.averaging else 1.0
                size, second = np.sqrt(2 * left) * size, 1 / (2 * second)
                others.pop("drifting_line", None)
            drawn = size, first, first * second
            if place in state.followed:
                drawn = in_the_long_run(*drawn, state.followed[place], seed)
            size, first, spread = drawn
            middle, width = float(np.median(first)) / dt, float(np.median(spread)) / dt
            values = {"amplitude": size, "frequency": first / dt, "width": spread / dt}
            band = (middle - 2 * width, middle + 2 * width)
            found.append(Effect("drifting_line", own, others, values, {}, band, _when(state, dt)))
    return found


def _of_any_converter(
    cutoff: Float[np.ndarray, " draws"], seed: int
) -> Float[np.ndarray, " draws"]:
    """Cut-off frequencies [cycles per sample]; what lies beyond Nyquist may lie anywhere there.

    Of these only aliases are seen, and what folds depends on how a converter comes to its samples:
    with a few values in between, averaged or not, or with steps of a digital filter, one spectrum
    is that of corners far apart. Such draws are uniform in the logarithm, up to the highest that is
    looked for.
    """
    highest = bounds("low_pass", 1.0)[0][1]
    up = np.random.default_rng(seed).random(cutoff.size)
    return np.where(cutoff > _NYQUIST, _NYQUIST * (highest / _NYQUIST) ** up, cutoff)


def _when(state: Investigation, dt: float) -> str:
    """When the only line was stronger than at other times, if it was."""
    if not state.line_times or len(set(state.model.kinds.added) & set(NARROW)) != 1:
        return ""
    return _mostly(state, state.line_times, dt)


def _mostly(state: Investigation, pairs: Sequence[tuple[int, int]], dt: float) -> str:
    """The first few of some times."""
    if not pairs:
        return ""
    told = seconds(state, pairs[:_MOST_TIMES], dt)
    times = [f"from {a:.5g} to {b:.5g} s" for a, b in told]
    more = len(pairs) - len(times)
    return ", mostly " + ", ".join(times) + (f" and {more} times more" if more else "")


def _unnamed(shaping: str, three, samples, dt: float) -> Effect:
    """A bump, or what a high-pass filter leaves."""
    frequency, width = (np.asarray(each) for each in shape_of(shaping, three, samples))
    middle, breadth = float(np.median(frequency)) / dt, float(np.median(width))
    values = {"frequency": frequency / dt, "width": width}
    if shaping == ECHO:
        part = np.asarray(part_of(three))
        values = {"height": part, **values, "width": np.ones(2), "echo": np.ones(2)}
        note = _REPEATED.format(100 * np.median(part), 1 / middle, middle)
        return Effect("bump", SURE, {}, values, {}, (0.0, 0.5 / dt), note)
    if shaping == HIGH_PASS:
        values = {"height": np.zeros(2), **values, "high_pass": np.ones(2)}
        band, note = (0.0, 2 * middle), _CUT.format(middle, 1 / (2 * breadth))
    else:
        height = np.tanh(three[0] / 6) * 6
        values = {"height": height, **values}
        band, note = (middle * np.exp(-breadth), min(middle * np.exp(breadth), 0.5 / dt)), ""
        if shaping == FLAT:
            values["flat"] = np.ones(2)
            note = _BAND.format(np.exp(np.median(height)), *band)
    return Effect("bump", SURE, {}, values, {}, band, note)


def _notch(three, samples, dt: float) -> Effect:
    """What is taken out about one frequency."""
    frequency, width = (np.asarray(each) for each in shape_of(NOTCH, three, samples))
    middle, breadth = float(np.median(frequency)) / dt, float(np.median(width))
    height, left = np.log(left_of(three)), float(np.median(left_of(three)))
    values = {"height": np.asarray(height), "frequency": frequency / dt, "width": width}
    note = _NOTCH.format(middle, 1 / breadth, _NOTHING if left < _FAINT else f"to {left:.2g}")
    band = (middle * np.exp(-breadth), min(middle * np.exp(breadth), 0.5 / dt))
    return Effect("bump", SURE, {}, {**values, "notch": np.ones(2)}, {}, band, note)


def _described(kind: LowPass, told: dict[str, float]) -> str:
    """What is said of a filter that is not of Butterworth's kind, or floored; "" of any other."""
    shape = _shape(kind)
    if "floor" not in told:
        return shape
    shape = shape or f"of order {told['order']:.3g}"
    return f"{shape}, and behind it white noise at {told['floor']:.0f} dB, as a converter adds"


def _shape(kind: LowPass) -> str:
    order = round(float(kind.order))
    if kind.ripple is not None and kind.attenuation is not None:
        return _rippled(order, float(kind.ripple), float(kind.attenuation))
    if kind.windowed:
        return f"with a steep edge, as {order + 1} taps under a Hamming window have"
    if not kind.running_mean:
        return ""
    often = f", {order} times over" if order > 1 else ""
    if kind.oversampled:
        taps = float(kind.taps(1.0))
        return f"means over {taps:.2g} sampling intervals{often}, as sigma-delta converters take"
    return f"a running mean of {float(kind.taps(1.0)):.0f} samples{often}"


def _rippled(order: int, ripple: float, attenuation: float) -> str:
    """What is said of elliptic filters, and of those without ripple on one side."""
    flat, falling = ripple < _FLAT_DB, attenuation > _FALLING_DB
    if flat and falling:
        return f"of order {order}"
    before = "" if flat else f" with a ripple of {ripple:.2g} dB"
    beyond = "" if falling else f" with {attenuation:.0f} dB of attenuation beyond it"
    family = "an inverse Chebyshev" if flat else "a Chebyshev" if falling else "an elliptic"
    both = " and" if before and beyond else ""
    return f"of order {order}{before}{both}{beyond}, as {family} filter has"


def _gauss_markov(state, begin, size, time, own, others, dt, seed) -> list[Effect]:
    """A Gauss-Markov process, or a telegraph that looks like one."""
    constant = float(np.median(time))
    band = corner_band(constant * dt, dt)
    plain = Effect(
        "gauss_markov", own, dict(others), {"sigma": size, "correlation_time": time * dt}, {}, band
    )
    levels = levels_of(state, begin, constant, seed)
    chance = levels.chance
    state.witness(
        "two levels",
        levels.gain,
        chance,
        "Two levels against one normal distribution, on the process filtered out of other noise.",
    )
    # A chance p is worth at most 1/(-e p ln p) in odds (Sellke et al. 2001, Am. Stat. 55:62).
    worth = 1 / (-np.e * chance * np.log(chance)) if chance < 1 / np.e else 1.0
    odds = _TELEGRAPH / (1 - _TELEGRAPH) * worth
    telegraph = min(odds / (1 + odds), _MOST_TELEGRAPH) * own
    if telegraph > own / 2:
        rest = {**others, "gauss_markov": own - telegraph}
        # The share of a record that is spent at one level scatters about that in the long run.
        variance = levels.upper * (1 - levels.upper) * 2 * constant / state.values.size
        share = levels.upper + np.sqrt(variance) * np.random.default_rng(seed).normal(size=2000)
        share = np.resize(np.clip(share, 0.01, 0.99), size.size)
        uneven = abs(levels.upper - 0.5) > _UNEVEN * np.sqrt(variance)
        spread = share * (1 - share) if uneven else 0.25
        values = {"amplitude": size / np.sqrt(spread), "dwell_time": time * dt / (2 * spread)}
        if uneven:
            values["upper_share"] = share
        return [Effect("random_telegraph", telegraph, rest, values, {}, band)]
    rest = {**others, "random_telegraph": telegraph}
    return [replace(plain, probability=own - telegraph, alternatives=rest)]
