"""From what an investigation found to named effects with parameters, in SI units and seconds."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from ..physics import LowPass
from ._effect import Effect
from ._state import Finding, Investigation, Unknown
from .courses._course import Course
from .courses._dwells import dwells
from .courses._jumps import jumps
from .courses._shapes import draw_courses
from .courses._switches import levels_of
from .lines._parts import merged
from .lines._tracked import Followed
from .spectrum._posterior import Draws
from .spectrum._structure import (
    DROOPING,
    EACH,
    FLAT,
    HIGH_PASS,
    NARROW,
    TERMS,
    UNNAMED,
    left_of,
    shape_of,
    sieve,
)
from .values._effects import LINE, MAKERS, SURE, seconds
from .values._spikes import USUAL

# A slow oscillation of such a period is more likely a room's temperature than anything else.
_ROOM_PERIOD_S = 240.0
# So many times of a line are told.
_MOST_TIMES = 3
_LIKELY_ROOM = 0.75
_BAND = "a band of noise {:.3g} times as strong, from {:.3g} to {:.3g} Hz, with steep flanks"
_CUT = (
    "noise is missing below {:.3g} Hz, as behind a high-pass filter of order {:.2g}: alternating-"
    "current coupling, or a mean that is estimated and taken off all the time"
)
_FOLDED = ", half the rate, where a sinusoid shows only in part: its amplitude is as large at least"
# So many wandering biases switch between two levels, before any look at the levels.
_TELEGRAPH = 0.15
# Levels are held for different times if their shares differ by so many standard deviations.
_UNEVEN = 3.0
_MOST_TELEGRAPH = 0.96
# A sensitivity changes with temperature if its square's is so many standard deviations from zero.
_BENT = 3.0


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
    found += _courses(state, dt, rng)
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
    if unknown.period:
        note += f", every {unknown.period * dt:.4g} s"
    elif unknown.in_time and not unknown.bandless:
        note += ", from {:.3g} to {:.3g} Hz".format(*band)
    note += _mostly(state, unknown.times, dt) + (f"; {unknown.like}" if unknown.like else "")
    return Effect("bump", LINE, {}, draws, {}, band, note, unknown.in_time)


def _probabilities(finding: Finding | None, name: str) -> tuple[float, dict[str, float]]:
    """Of the effect and of its rivals, from their scores (twice the log of the odds)."""
    rivals = {} if finding is None else dict(finding.rivals)
    if name not in rivals:
        return SURE, {}
    top = max(rivals.values())
    weights = {rival: np.exp((score - top) / 2) for rival, score in rivals.items()}
    total = sum(weights.values())
    shares = {rival: float(weight / total) for rival, weight in weights.items()}
    own = min(shares.pop(name), SURE)
    # What has no name takes its share, but is no rival that a measurement could tell apart.
    shares.pop("bump", None)
    return own, {rival: share for rival, share in shares.items() if share > 0.005}


def _structural(state: Investigation, draws: Draws, dt: float, seed: int) -> list[Effect]:
    kinds, samples = state.model.kinds, state.data.samples
    findings = state.findings_of(kinds.names)
    found = []
    if draws.filtering is not None:
        cutoff, order, droop = draws.filtering.T
        values = {"cutoff_frequency": cutoff / dt, "order": order}
        if kinds.shaping in DROOPING:
            values["droop"] = droop
        # What is told together must belong together: the numbers of one kind of filter.
        told = {name: float(np.median(each[draws.of_likeliest])) for name, each in values.items()}
        kind = sieve(kinds.shaping or "", state.model.theta[TERMS : TERMS + EACH], samples)
        flags = ("digital", "averaged", "running_mean", "windowed")
        flag = {name: np.ones(2) for name in flags if getattr(kind, name)}
        if kinds.last and any(name != "drifting_line" for name in kinds.added):
            flag["last"] = np.ones(2)
        own, others = _probabilities(state.finding("low_pass"), "low_pass")
        found.append(
            Effect(
                "low_pass",
                own,
                others,
                {**values, **flag},
                {},
                (told["cutoff_frequency"] / 4, 0.5 / dt),
                note=_finite(kind),
                told=told,
            )
        )
    if kinds.shaping in UNNAMED:
        bump = _unnamed(kinds.shaping, draws.theta[:, TERMS : TERMS + EACH].T, samples, dt)
        compared = next((f for f in state.findings if f.name == "bump" and f.rivals), None)
        own, others = _probabilities(compared, "bump")
        found.append(replace(bump, probability=own, alternatives=others))
    for place, name in enumerate(kinds.added):
        if place in state.disowned_noises:
            continue
        begin = kinds.first_slot + EACH * place
        three = draws.theta[:, begin : begin + EACH].T
        first, second = (np.asarray(each) for each in shape_of(name, three, samples))
        size = np.exp(three[0] / 2)
        own, others = _probabilities(findings[place - len(kinds.added)], name)
        disguised = name == "resonance" and place in state.wandering
        if name == "gauss_markov":
            found += _gauss_markov(state, begin, size, first, own, others, dt, seed)
        elif name in NARROW and not disguised and float(np.median(first)) / dt * _ROOM_PERIOD_S < 1:
            found.append(_slow_swing(name, own, others, first / dt))
        elif name == "resonance" and not disguised:
            middle, half = float(np.median(first)) / dt, float(np.median(first / second)) / 2 / dt
            values = {"sigma": size, "frequency": first / dt, "quality_factor": second}
            band = (max(middle - 2 * half, 0.0), middle + 2 * half)
            found.append(Effect(name, own, others, values, {}, band, _when(state, dt)))
        elif name == "power_law":
            density = np.exp(three[0]) * dt ** (1 - first)
            found.append(
                Effect(name, own, others, {"exponent": first, "density": density}, {}, None)
            )
        else:
            if disguised:
                # As wide as the resonance, and of its power among the samples.
                left = left_of(name, first, state.data.averaging)
                size, second = np.sqrt(2 * left) * size, 1 / (2 * second)
                others.pop("drifting_line", None)
            drawn = size, first, first * second
            if place in state.followed:
                drawn = _as_followed(*drawn, state.followed[place], seed)
            size, first, spread = drawn
            middle, width = float(np.median(first)) / dt, float(np.median(spread)) / dt
            values = {"amplitude": size, "frequency": first / dt, "width": spread / dt}
            band = (middle - 2 * width, middle + 2 * width)
            found.append(Effect("drifting_line", own, others, values, {}, band, _when(state, dt)))
    return found


def _as_followed(
    size: Float[np.ndarray, " draws"],
    mean: Float[np.ndarray, " draws"],
    width: Float[np.ndarray, " draws"],
    followed: Followed,
    seed: int,
) -> tuple[Float[np.ndarray, " draws"], ...]:
    """Draws of a line's amplitude, mean frequency and width, as it wanders in the long run.

    By its moments, where these know better than a fit of its peak. A record in which the frequency
    seldom changes tells as much of where it will be as so many independent values do: of a process
    that forgets as exp(-t/T) the mean over a time L has the variance 2 T/L of one value, and the
    mean square that of L/T values.
    """
    rng = np.random.default_rng(seed)
    noise, lasts = rng.standard_normal((5, mean.size)), followed.lasts
    if followed.moments is not None:
        square, middle, spread = followed.moments
        # A fit is led by the shape: moments are better even where noise moves them as far as the
        # few turns do.
        of_mean, of_width = np.array([np.sqrt(2 * lasts), np.sqrt(lasts / 2)]) * np.median(width)
        if square[1] < 2 * np.std(np.log(size)) * square[0]:
            size = np.sqrt(np.maximum(square[0] + square[1] * noise[0], 0.0))
        if middle[1] < max(np.std(mean), of_mean):
            mean = middle[0] + middle[1] * noise[1]
        if spread[1] < max(np.std(width), of_width):
            width = np.maximum(spread[0] + spread[1] * noise[2], 0.0)
    wider = width * np.exp(np.sqrt(lasts / 2) * noise[3])
    return size, mean + width * np.sqrt(2 * lasts) * noise[4], wider


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


def _finite(kind: LowPass) -> str:
    """What is said of a filter of finite response, in samples."""
    order = round(float(kind.order))
    if kind.windowed:
        return f"with a steep edge, as {order + 1} taps under a Hamming window have"
    if not kind.running_mean:
        return ""
    often = f", {order} times over" if order > 1 else ""
    return f"a running mean of {float(kind.taps(1.0)):.0f} samples{often}"


def _gauss_markov(state, begin, size, time, own, others, dt, seed) -> list[Effect]:
    """A Gauss-Markov process, or a telegraph that looks like one."""
    constant = float(np.median(time))
    band = _corner_band(constant * dt, dt)
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


def _telegraph(course: Course, height, dt: float, rng) -> Effect:
    """A telegraph whose switches were seen one by one."""
    dwell, share, uneven = dwells(course, rng, height.size)
    values = {"amplitude": np.abs(height), "dwell_time": dwell * dt}
    if uneven:
        values["upper_share"] = share
    spread = course.shape["upper"] * (1 - course.shape["upper"])
    band = _corner_band(2 * spread * float(np.median(dwell)) * dt, dt)
    return Effect(course.name, SURE, {}, values, {}, band)


def _corner_band(constant: float, dt: float) -> tuple[float, float]:
    """About the corner of a process with such a time constant [s], in Hz."""
    corner = 1 / (2 * np.pi * constant)
    return 0.15 * corner, min(3 * corner, 0.5 / dt)


def _courses(state: Investigation, dt: float, rng) -> list[Effect]:
    # A jump is known by what is beside a knock.
    steps = [
        (state.moment(jump.after) * dt, rng.normal(jump.height, jump.deviation, 2000), SURE, {})
        for jump in jumps(state)
    ]
    if state.sized is None:
        return _steps(steps)
    found, felt, warm = [], [], []
    columns, logs = draw_courses(state, rng, 2000)
    findings = state.findings_of([course.name for course in state.courses])
    for course, sizes, log, finding in zip(state.courses, columns, logs, findings, strict=True):
        own, others = _probabilities(finding, course.name)
        if course.name == "step":
            steps.append((state.moment(course.shape["time"]) * dt, sizes[:, 0], own, others))
        elif course.name == "warm_up":
            constant = course.shape["time_constant"] * np.exp(log)
            values = {"amplitude": sizes[:, 0], "time_constant": constant * dt}
            found.append(Effect("warm_up", own, others, values))
        elif course.name == "sinusoid":
            found.append(_sinusoid(course, sizes, own, others, dt, rng))
        elif course.name == "random_telegraph":
            found.append(_telegraph(course, sizes[:, 0], dt, rng))
        elif course.name == "temperature":
            felt.append(sizes)
            warm.append(course)
        else:
            # Rectified vibration, per unit of a vibration that is itself known roughly.
            assert state.modulation is not None
            added = rng.choice(state.modulation.draws, len(sizes)) ** 2 - 1
            coefficient = sizes[:, 0] * (state.modulation.ratio**2 - 1) / added
            found.append(Effect(course.name, own, others, {"coefficient": coefficient}))
    if felt:
        # Felt late by several thermal masses, slow changes by all of them.
        own, others = _probabilities(state.finding("temperature"), "temperature")
        linear, square = np.sum(felt, axis=0).T
        values = {"sensitivity": linear}
        note = "how fast temperature changes" if _of_changes(warm, felt) else ""
        if abs(np.mean(square)) > _BENT * np.std(square):
            values["quadratic"] = square
        found.append(Effect("temperature", own, others, values, note=note))
    return found + _steps(steps)


def _of_changes(warm: list[Course], felt: list[np.ndarray]) -> bool:
    """Whether what is felt at once and what is felt late cancel, so that changes are left."""
    linear = np.array(felt)[:, :, 0]
    late, at_once = np.array([course.shape["lag"] for course in warm]) @ linear, linear.sum(axis=0)
    clear = abs(np.mean(late)) > _BENT * np.std(late)
    return bool(len(warm) > 1 and clear and abs(np.mean(at_once)) < 2 * np.std(at_once))


def _steps(steps: list[tuple]) -> list[Effect]:
    """All steps as one effect, each with its time, its heights, and its probabilities."""
    if not steps:
        return []
    heights = np.array([np.median(size) for _, size, _, _ in steps])
    sign = np.sign(heights.sum()) or 1.0
    mean = sign * np.mean([np.abs(size) for _, size, _, _ in steps], axis=0)
    in_time = sorted((time, float(np.median(size))) for time, size, *_ in steps)
    lists: dict[str, list] = {"times": [time for time, _ in in_time]}
    if len(steps) > 1:
        lists["heights"] = [height for _, height in in_time]
    own = float(max(each[2] for each in steps))
    return [Effect("step", own, steps[0][3], {"amplitude": mean}, lists)]


def _sinusoid(course, sizes, own, others, dt, rng) -> Effect:
    amplitude = np.sqrt(np.sum(sizes**2, axis=1))
    spread = course.shape.get("deviation", 0.0)
    drawn = course.shape["frequency"] + spread * rng.standard_normal(2000)
    frequency = np.minimum(drawn, 0.5) / dt
    note = _FOLDED if sizes.shape[1] == 1 else ""
    middle = float(np.median(frequency))
    band = (0.97 * middle, 1.03 * middle)
    if middle * _ROOM_PERIOD_S < 1 and not any(key == "temperature" for key in others):
        return _slow_swing("sinusoid", own, others, frequency)
    values = {"amplitude": amplitude, "frequency": frequency}
    return Effect("sinusoid", min(own, LINE), others, values, {}, band, note)


def _slow_swing(name: str, own: float, others: dict[str, float], frequency) -> Effect:
    """What swings more slowly than anything but a room does, whatever its shape."""
    middle = float(np.median(frequency))
    values = {"time_scale": 1 / np.abs(frequency)}
    rest = {**others, name: own * (1 - _LIKELY_ROOM)}
    band = (0.97 * middle, 1.03 * middle)
    return Effect("temperature", own * _LIKELY_ROOM, rest, values, {}, band)
