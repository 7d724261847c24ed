"""One channel under investigation: what is amiss, found one thing at a time, strongest first.

Order of questions: how samples were made (held, rounded, clipped); whether their noise lasts and
is normal; then lines, courses in time and smooth effects of the spectrum, in rounds, each of which
takes one (`_rounds` says which), until nothing is left that is no chance.
"""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np
from jaxtyping import Float

from ..curves import unit_scale
from ..physics import Sampling
from ..recording._checks import usable
from ._bumps import bump_beside
from ._chance import log_chance
from ._intervals import cut_out, joined
from ._refit import (
    drop_courses,
    evidence,
    finer_edges,
    go_back,
    refit,
    remembered,
    resize,
)
from ._rounds import LEEWAY, take_one
from ._state import Finding, Investigation, begin
from ._unknown import look_again
from .courses._course import Course
from .courses._one_by_one import likely_one_by_one
from .courses._pulses import may_be_pulses, pulses
from .courses._rectified import steps_while_loud
from .courses._switches import of_switches, without_switches
from .courses._taken_switches import (
    steps_are_switches,
    take_process,
    take_switches,
    without_spikes,
)
from .lines._lines import line_log_chance
from .lines._lost import lost_on_the_way
from .lines._rang_once import rang_once
from .lines._taken import LINE_ALARM, take_strong_lines
from .spectrum import _model
from .spectrum._narrow import is_about, narrow_noises
from .strength._knocks import moved_while_loud
from .strength._lasting import about_spread, loudness, seen_beside_lines
from .values._clock import fresh_values
from .values._format import stuck
from .values._held_out import of_events
from .values._losses import Lost, count_losses_out
from .values._rounded import about_angle, about_format, name_fine_codes

# Chance of a false alarm in each of the families of tests, for a recording of one channel.
ALARM = 0.0008
# Rounds that take no line.
_MOST_ROUNDS = 10
# Knocks are cut out so many times, since strong ones hide what is weaker.
_MOST_CUTS = 3
# So many knocks, steps and outliers are asked whether they are switches of a process not found yet.
_FEWEST_SWITCHES = 2
# What stays found when times are cut out.
_KEPT = ("disturbance", "sample_hold", "saturation", "dropped_samples", "outliers")
# Of a record that stands at its rails for long, the least part beside that is looked into.
_FREE = 0.5


def investigate(
    values: Float[np.ndarray, " samples"],
    pieces: tuple[tuple[int, int], ...],
    sampling: Sampling,
    power: Float[np.ndarray, " terms"],
    *,
    alarm: float = ALARM,
    drivers: dict[str, Float[np.ndarray, "samples columns"]] | None = None,
    lost: float = 0.0,
    losses: Sequence[tuple[int, int]] = (),
    lost_deviation: float = 0.0,
    seed: int = 0,
) -> Investigation:
    """Find what the five terms leave out of one channel.

    `power` are the squared coefficients of the five-term fit for a sampling interval of one, and
    `drivers` what may move the channel, by the name of the effect, centred; `lost` is the share of
    samples that time stamps say were lost on the way, and `losses` the first sample after each of
    these losses with how many were lost; `lost_deviation` is that of the logarithm of `lost`, and
    zero where all were lost one by one. Without stamps a line may tell of them.

    Of a sensor with a clock of its own the fresh values are investigated, a `stride` apart.
    """
    known = Lost(lost, tuple(losses), deviation=lost_deviation)
    ask = partial(_investigated, values, pieces, sampling, power, alarm, dict(drivers or {}), seed)
    state = ask(known)
    found = None if lost > 0 or state.stride > 1 else lost_on_the_way(state)
    return state if found is None else ask(found)


def _investigated(
    values: Float[np.ndarray, " samples"],
    pieces: tuple[tuple[int, int], ...],
    sampling: Sampling,
    power: Float[np.ndarray, " terms"],
    alarm: float,
    drivers: dict[str, Float[np.ndarray, "samples columns"]],
    seed: int,
    lost: Lost,
) -> Investigation:
    """The same, where it is known what was lost."""
    stride = 1.0
    fresh = fresh_values(values, pieces)
    if fresh is not None:
        alike = np.diff(usable(values, pieces)) == 0
        values, pieces, stride = fresh.values, fresh.pieces, fresh.repeat.samples
        drivers = {name: column[fresh.at] for name, column in drivers.items()}
        power = power / np.asarray(unit_scale(stride))[: power.size] ** 2
        # Rounding alone makes as many neighbours alike as it does among fresh values.
        held = of_events(alike, float(np.mean(np.diff(usable(values, pieces)) == 0)))
    state = begin(values, pieces, sampling, power, alarm)
    if fresh is not None:
        state.stride, state.at = stride, fresh.at
        state.findings.append(Finding("sample_hold", fresh.repeat.log_p, 0.0, detail=fresh.repeat))
        state.gains["sample_hold"] = held
    elif lost.losses:
        after, counts = np.array(lost.losses).T
        state.place += np.cumsum(np.bincount(after, counts, minlength=values.size))
    if lost.fraction > 0:
        state.findings.append(Finding("dropped_samples", -lost.gain, 0.0, {}, lost))
    about_format(state)
    if lost.fraction > 0:
        times = len(lost.losses) or max(round(lost.fraction * values.size), 1)
        count_losses_out(state, times, seed)
    times = stuck(values, pieces, state.format)
    free = cut_out(pieces, times) if times else pieces
    if sum(b - a for a, b in free) < _FREE * sum(b - a for a, b in pieces):
        # Between so much that shows nothing, what is left is not the noise either.
        state.nearest = min(finding.log_p for finding in state.findings)
        return state
    if times:
        state = _begin_again(state, free, power)
    made = copy(state)
    take_strong_lines(state)
    if about_spread(state, seed):
        state = _without_knocks(state, power, seed)
    if _moves(state) and state.vibration is None:
        # What rounds would take one by one, if it is clear by now.
        whole = _joined_again(state, power)
        state = whole if take_switches(whole, made, state.knocks, seed) else state
    _take_all(state, drivers)
    if state.knocks:
        seen = seen_beside_lines(_joined_again(state, power))
        knocks = [each for each in state.knocks if seen is None or seen[slice(*each)].any()]
        if len(knocks) < len(state.knocks):
            state = _joined_again(state, power, knocks)
            about_spread(state, seed, may_cut=False)
            _take_all(state, drivers)
    if moved_while_loud(state) or rang_once(state):
        state = _without_knocks(state, power, seed)
        _take_all(state, drivers)
    if steps_while_loud(state):
        _take_all(state, drivers)
    whole = _with_switches(state, made, power, seed)
    if whole is not None:
        state = whole
        _take_all(state, drivers)
    whole = _with_pulses(state, made, power, seed)
    if whole is not None:
        state = whole
        _take_all(state, drivers)
    if steps_are_switches(state):
        _take_all(state, drivers)
    if about_angle(state):
        refit(state)
    _reconsider(state)
    name_fine_codes(state)
    look_again(state, seed)
    bump_beside(state)
    if state.model.kinds.notches:
        # What is beside it was named for what it does, or hidden.
        _take_all(state, drivers)
        _reconsider(state)
    _reconsider_lines(state)
    state.nearest = min([state.nearest, *(finding.log_p for finding in state.findings)])
    return state


def _without_knocks(
    state: Investigation, power: Float[np.ndarray, " terms"], seed: int
) -> Investigation:
    """The investigation begun again, without some intervals.

    What rings on behind a knock, and weaker ones, are heard only without it.
    """
    for left in reversed(range(_MOST_CUTS)):
        state = _begin_again(state, cut_out(state.pieces, state.knocks), power)
        take_strong_lines(state)
        if not about_spread(state, seed, may_cut=left > 0):
            break
    return state


def _with_switches(
    state: Investigation, made: Investigation, power: Float[np.ndarray, " terms"], seed: int
) -> Investigation | None:
    """The investigation with all switches of a telegraph left in, or taken as what they are.

    They may have been cut or taken out one by one. `made` is as it was before the noise was asked
    anything.
    """
    named = "gauss_markov" in state.model.kinds.added
    if state.vibration is not None or state.finding("random_telegraph"):
        return None
    # Between them the steps of a telegraph, or a walk, may leave nothing of the process.
    if not named and _moves(state) < _FEWEST_SWITCHES and likely_one_by_one(state) is None:
        return None
    whole = _joined_again(state, power)
    if take_switches(whole, made, state.knocks, seed):
        return whole
    if _moves(state) == 0 or not (named or take_process(whole)):
        return None
    white = without_switches(state, whole, seed)
    if white is None:
        return None
    if state.contamination is not None:
        if of_switches(state.contamination, white, seed):
            without_spikes(whole, made)
        elif _moves(state) == 1:
            return None
    whole.switching = True
    return whole


def _with_pulses(
    state: Investigation, made: Investigation, power: Float[np.ndarray, " terms"], seed: int
) -> Investigation | None:
    """The investigation with all pulses left in, if some were cut or taken out one by one.

    What is left has to say so too, or to switch too seldom. `made` is as of `_with_switches`.
    """
    if _moves(state) == 0 or state.vibration is not None or not may_be_pulses(state, seed):
        return None
    whole = _joined_again(state, power)
    without_spikes(whole, made)
    if not pulses(whole, seed):
        return None
    whole.switching = True
    return whole


def _moves(state: Investigation) -> int:
    """What may be a switch: how many steps and cut times, and whether there are spikes."""
    steps = [course.name for course in state.courses].count("step")
    return steps + len(state.knocks) + (state.contamination is not None)


def _joined_again(
    state: Investigation,
    power: Float[np.ndarray, " terms"],
    knocks: Sequence[tuple[int, int]] = (),
) -> Investigation:
    """The investigation with its noises, but nothing taken, and only `knocks` cut out in time."""
    knocks = list(knocks)
    pieces = cut_out(joined(state.pieces, state.knocks, state.breaks), knocks)
    whole = _begin_again(state, pieces, power)
    whole.knocks = knocks
    if not knocks:
        whole.findings = [each for each in whole.findings if each.name != "disturbance"]
        whole.gains.pop("disturbance", None)
    names = state.model.kinds.names
    whole.findings += [each for each in state.findings if each.name in names]
    whole.peaks = state.peaks
    whole.model = _model.of_samples(state.model, state.data, whole.data)
    finer_edges(whole)
    return whole


def _begin_again(
    state: Investigation, pieces: tuple[tuple[int, int], ...], power: Float[np.ndarray, " terms"]
) -> Investigation:
    """Only the stretches `pieces` of the values, with what is known of how they were made."""
    later = begin(state.values, pieces, state.sampling, power, state.alarm)
    # All else is found again, or was made by what is cut out now.
    later.findings = [each for each in state.findings if each.name in _KEPT]
    later.gains = {name: gain for name, gain in state.gains.items() if name in _KEPT}
    later.knocks, later.witnesses = state.knocks, state.witnesses
    if state.vibration is not None and state.modulation is not None:
        # So it is with vibration; what comes back is as what follows it.
        of = np.searchsorted(state.looked_at, later.looked_at).clip(max=state.looked_at.size - 1)
        later.modulation = state.modulation.of(of)
        later.vibration = state.vibration._replace(
            times=later.modulation, course=state.vibration.course[of]
        )
        found = state.finding("variance_modulation")
        if found is not None:
            later.findings.append(replace(found, detail=later.modulation))
            later.gains[found.name] = state.gains[found.name]
    later.stride, later.at = state.stride, state.at
    later.breaks, later.place, later.bridged = state.breaks, state.place, state.bridged
    # Spikes are no longer among the values.
    later.contamination, later.unseen = state.contamination, state.unseen
    later.foreign = state.foreign - state.loud_variance
    # Where the output keeps clear of its rails they are no less there.
    rails = state.format.rails
    clipped = float(np.mean(np.isin(usable(state.values, pieces), rails)))
    # What stands at them when something was taken off it looks held.
    held = later.format.repeat if state.format.repeat is not None or not rails else None
    later.format = replace(later.format, rails=rails, clipped=clipped, repeat=held)
    about_format(later)
    return later


def _take_all(state: Investigation, drivers: dict[str, Float[np.ndarray, "samples columns"]]):
    """Rounds, until nothing is left that is needed."""
    spiky = state.contamination is not None and state.vibration is None
    if state.modulation is not None and not spiky:
        drivers = {**drivers, "vibration_rectification": loudness(state, state.modulation)}
    rounds = 0
    while rounds < _MOST_ROUNDS + len(state.lines) and take_one(state, drivers):
        rounds += 1


def _reconsider(state: Investigation) -> None:
    """Take back what later effects have made superfluous."""
    place = 0
    while place < len(state.model.kinds.names):
        names = state.model.kinds.names
        start = _model.without(state.model, place)
        less = _model.best([(start.kinds, start.theta)], state.data)[0]
        gain = less.deviance - state.model.deviance
        if log_chance(names[place], gain) > np.log(LEEWAY * state.alarm):
            gone = state.findings_of(names)[place]
            state.findings = [each for each in state.findings if each is not gone]
            state.model = less
            if names[place] == "bump":
                state.unexplained = None
        else:
            place += 1
    if state.sized is not None:
        resize(state)
        _reconsider_courses(state)


def _reconsider_courses(state: Investigation) -> None:
    """Take back courses that others explain better: a warm-up looks like temperature at first."""
    found_by = state.findings_of([course.name for course in state.courses])
    for course, found in list(zip(state.courses, found_by, strict=True)):
        if course.name == "sinusoid":
            continue
        if len(state.courses) == 1:
            return
        # Of steps that are no chance together, each may be one as seldom as this.
        together = found.detail if found is not None and course.name == "step" else None
        most = np.log(state.alarm) / (together or 1)
        _drop_unless(state, course, lambda gain, log_p, most=most: log_p <= most)


def _reconsider_lines(state: Investigation) -> None:
    """Take back sinusoids that stood out of what the spectrum turned out not to be."""
    peaks = narrow_noises(state.model, float(state.data.samples))
    for line in state.lines:
        frequency = line.shape["frequency"]
        inside = is_about(frequency, peaks)
        if state.unexplained is None and not inside:
            continue
        _drop_unless(
            state,
            line,
            lambda gain, _, frequency=frequency: (
                line_log_chance(gain / 2, frequency, state.spectrum.longest)
                <= np.log(LINE_ALARM * state.alarm)
            ),
        )


def _drop_unless(
    state: Investigation, course: Course, stands: Callable[[float, float], bool]
) -> None:
    """Take a course back, unless what it gains and the log of the chance of that stand."""
    kept = remembered(state)
    drop_courses(state, [course])
    if stands(*evidence(state, course)):
        go_back(state, kept)
