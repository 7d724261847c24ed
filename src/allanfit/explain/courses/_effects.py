"""From courses in time to named effects with parameters, in SI units and seconds."""

import numpy as np
from jaxtyping import Float

from .._effect import Effect
from .._state import Investigation
from ..values._clipped import rails
from ..values._effects import LINE, SURE, probabilities
from ._course import Course
from ._dwells import dwells
from ._jumps import jumps
from ._shapes import draw_courses

#: A slow oscillation of such a period is more likely a room's temperature than anything else.
ROOM_PERIOD_S = 240.0
_LIKELY_ROOM = 0.75
_FOLDED = ", half the rate, where a sinusoid shows only in part: its amplitude is as large at least"
# A sensitivity changes with temperature if its square's is so many standard deviations from zero.
_BENT = 3.0


def of_courses(state: Investigation, dt: float, rng) -> list[Effect]:
    """All courses of an investigation, and jumps across knocks."""
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
        own, others = probabilities(finding, course.name)
        if course.name == "step":
            steps.append((state.moment(course.shape["time"]) * dt, sizes[:, 0], own, others))
        elif course.name == "warm_up":
            constant = course.shape["time_constant"] * np.exp(log)
            values = {"amplitude": sizes[:, 0], "time_constant": constant * dt}
            found.append(Effect("warm_up", own, others, values))
        elif course.name == "sinusoid":
            found.append(_sinusoid(course, _unclipped(state, sizes), own, others, dt, rng))
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
        own, others = probabilities(state.finding("temperature"), "temperature")
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
    # Up and down there is no one direction.
    sign = -1.0 if np.all(heights < 0) else 1.0
    mean = sign * np.mean([np.abs(size) for _, size, _, _ in steps], axis=0)
    in_time = sorted((time, float(np.median(size))) for time, size, *_ in steps)
    lists: dict[str, list] = {"times": [time for time, _ in in_time]}
    if len(steps) > 1:
        lists["heights"] = [height for _, height in in_time]
    own = float(max(each[2] for each in steps))
    return [Effect("step", own, steps[0][3], {"amplitude": mean}, lists)]


def _unclipped(state: Investigation, sizes: Float[np.ndarray, "draws waves"]):
    """A line as it was before rails cut its peaks."""
    cut = rails(state)
    if cut is None:
        return sizes
    logged = float(np.median(np.linalg.norm(sizes, axis=1)))
    return sizes * cut.line(logged) / logged


def _sinusoid(course, sizes, own, others, dt, rng) -> Effect:
    amplitude = np.sqrt(np.sum(sizes**2, axis=1))
    spread = course.shape.get("deviation", 0.0)
    drawn = course.shape["frequency"] + spread * rng.standard_normal(2000)
    frequency = np.minimum(drawn, 0.5) / dt
    note = _FOLDED if sizes.shape[1] == 1 else ""
    middle = float(np.median(frequency))
    band = (0.97 * middle, 1.03 * middle)
    if middle * ROOM_PERIOD_S < 1 and not any(key == "temperature" for key in others):
        return slow_swing("sinusoid", own, others, frequency)
    values = {"amplitude": amplitude, "frequency": frequency}
    return Effect("sinusoid", min(own, LINE), others, values, {}, band, note)


def slow_swing(name: str, own: float, others: dict[str, float], frequency) -> Effect:
    """What swings more slowly than anything but a room does, whatever its shape."""
    middle = float(np.median(frequency))
    values = {"time_scale": 1 / np.abs(frequency)}
    rest = {**others, name: own * (1 - _LIKELY_ROOM)}
    band = (0.97 * middle, 1.03 * middle)
    return Effect("temperature", own * _LIKELY_ROOM, rest, values, {}, band)


def _telegraph(course: Course, height, dt: float, rng) -> Effect:
    """A telegraph whose switches were seen one by one."""
    dwell, share, uneven = dwells(course, rng, height.size)
    values = {"amplitude": np.abs(height), "dwell_time": dwell * dt}
    if uneven:
        values["upper_share"] = share
    spread = course.shape["upper"] * (1 - course.shape["upper"])
    band = corner_band(2 * spread * float(np.median(dwell)) * dt, dt)
    return Effect(course.name, SURE, {}, values, {}, band)


def corner_band(constant: float, dt: float) -> tuple[float, float]:
    """About the corner of a process with such a time constant [s], in Hz."""
    corner = 1 / (2 * np.pi * constant)
    return 0.15 * corner, min(3 * corner, 0.5 / dt)
