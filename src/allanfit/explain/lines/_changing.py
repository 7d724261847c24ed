"""Lines and bands that move or come and go, which the names of steady ones describe best.

A sweep looks like a line that wanders or a resonance, a line in bursts like many lines, and one
that is switched on like a band about it.
"""

import numpy as np
from jaxtyping import Float
from scipy.stats import gamma

from .._chance import INSIDE
from .._state import Investigation, Unknown
from ..courses._course import Course
from ..spectrum._narrow import Narrow, band_of, narrow_groups, narrow_noises
from ._line_or_resonance import Told, in_one_phase
from ._moving import Band, moving
from ._one_phase import OnePhase
from ._sidebands import are_sidebands

# Widths to either side of a line within which it moves, and within which bursts may show: whoever
# takes in much noise hears no weak ones, and who takes in too little loses their edges.
_REACH, _REACHES = 3.0, (1.0, 2.0, 3.0)
# A pulse is looked for from so many periods on, and must be as unlikely.
_TEETH_SOUGHT, _PULSED, _DEPTH = 8, 1e-5, 0.7
# Half of its frequency is a pulse's own if so many times the power beside it is there.
_SUBHARMONIC = 9.0
# Lines of one comb lie as close.
_CLOSE = 0.05
# A swing to and fro turns at sqrt(2) times its rms.
_TURN = 1.6


def look_at_lines(
    state: Investigation, white: Float[np.ndarray, " samples"], told: dict[int, Told]
) -> None:
    """Take back the names of lines and bands that are not steady; `told` is of `tell_apart`."""
    _combs(state)
    _sweeps(state, white, told)
    _turns(state)


def _combs(state: Investigation) -> None:
    """Lines at equal distances within a narrow band: one line that comes and goes."""
    samples = state.spectrum.longest
    lines = sorted(state.lines, key=lambda line: line.shape["frequency"])
    group: list[Course] = []
    for line in [*lines, None]:
        if group and (
            line is None or line.shape["frequency"] > group[0].shape["frequency"] * (1 + _CLOSE)
        ):
            places = [each.shape["frequency"] for each in group]
            strengths = [_strength(each, samples) for each in group]
            if are_sidebands(places, strengths, samples):
                _comb(state, places)
            group = []
        if line is not None:
            group.append(line)


def _strength(line: Course, samples: int) -> float:
    """The amplitude of a line over its standard error, by the bound on its frequency."""
    return float(np.sqrt(12) / (2 * np.pi * samples * line.shape["deviation"]))


def _comb(state: Investigation, lines: list[float]) -> None:
    middle, gap = float(np.mean(lines)), float(np.diff(lines).min())
    width = float(np.log(lines[-1] / lines[0])) / 2
    state.disowned_lines += lines
    why = f"{len(lines)} lines at equal distances are one line that comes and goes"
    state.unknown.append(Unknown(middle, max(width, 1e-6), why, 1 / gap))


def _sweeps(
    state: Investigation, white: Float[np.ndarray, " samples"], told: dict[int, Told]
) -> None:
    """Lines that move through their band, or come and go; `told` is of `tell_apart`."""
    for group in narrow_groups(state):
        main = max(group, key=lambda each: each.width)
        band = band_of(state, group, _REACH)
        path = moving(white, band)
        if path is not None and path.log_p > np.log(state.alarm):
            path = None
        why, like, ends, period, switched = "", "", None, 0.0, None
        if path is not None and path.even:
            why = "a line that sweeps through the band in the course of the recording"
            like, ends = "a motor or a pump that gains or loses speed does so", path.ends
        elif period := _pulse_of(state, white, group):
            why = "a line that comes and goes"
        elif switched := _one_phase(state, white, group, told):
            why = "a line of one frequency and phase whose strength changes"
        elif switched := _on_and_off(group, told):
            why = "a line that is on at some times and off at others"
            like = "a motor or a pump that is switched does so"
        elif path is not None:
            # Whatever its shape, a resonance it is not.
            state.wandering |= {each.place for each in group}
        if why:
            state.disowned_noises |= {each.place for each in group}
            width = max(main.width / main.middle, 1e-6)
            times = _times_on(state, switched)
            state.unknown.append(
                Unknown(main.middle, width, why, period, like=like, times=times, ends=ends)
            )


def _one_phase(
    state: Investigation,
    white: Float[np.ndarray, " samples"],
    group: list[Narrow],
    told: dict[int, Told],
) -> OnePhase | None:
    """A line whose strength changes, if that says more than the name that the group has."""
    found = in_one_phase(state, white, group)
    known = max(told.get(each.place, Told()).wanders for each in group)
    return found if found is not None and 2 * (found.gain - known) > INSIDE else None


def _on_and_off(group: list[Narrow], told: dict[int, Told]) -> Told | None:
    """A line that comes back, whatever its phases; one that begins or ends is one that wanders."""
    likeliest = max((told.get(each.place, Told()) for each in group), key=lambda one: one.switched)
    return likeliest if 2 * likeliest.switched > INSIDE and len(likeliest.on) > 1 else None


def _times_on(state: Investigation, line: OnePhase | Told | None) -> tuple[tuple[int, int], ...]:
    """When a line is on, in values, as far as that is known."""
    start, stop = state.longest
    edges = np.array((line and line.on) or ()).reshape(-1, 2)
    times = np.round(start + edges * (stop - start)).astype(int)
    return tuple((int(a), int(b)) for a, b in times)


def _turns(state: Investigation) -> None:
    """A line that wanders to and fro dwells where it turns, and looks like a sinusoid there."""
    wandering = [
        one
        for one in narrow_noises(state.model, float(state.data.samples))
        if one.name == "drifting_line" and one.place not in state.disowned_noises
    ]
    lines = [course.shape["frequency"] for course in state.lines]
    state.disowned_lines += [
        line
        for line in lines
        if any(abs(line - one.middle) < _TURN * one.width for one in wandering)
    ]


def _pulse_of(
    state: Investigation, white: Float[np.ndarray, " samples"], group: list[Narrow]
) -> float:
    """The period [samples] with which a group's power comes and goes, or zero."""
    periods = (_pulse(white, band_of(state, group, reach)) for reach in _REACHES)
    return next((period for period in periods if period), 0.0)


def _pulse(white: Float[np.ndarray, " samples"], band: Band) -> float:
    """The period [samples] with which a band's power comes and goes, or zero."""
    spectrum = np.fft.rfft(white)
    first, last = (
        int(np.clip(end * white.size, 1, spectrum.size - 1)) for end in (band.low, band.high)
    )
    if last - first < 4 * _TEETH_SOUGHT:
        return 0.0
    # The band alone, moved to zero and taken as often as it has ordinates.
    power = np.abs(np.fft.ifft(spectrum[first:last])) ** 2
    beats = np.abs(np.fft.rfft(power - power.mean())) ** 2
    high = beats.size * 3 // 4
    own = np.array([np.median(beats[max(k - 32, 1) : k + 33]) for k in range(high)])
    ratio = beats[:high] / own * np.log(2)
    log_p, beat, size = 0.0, 0.0, 0.0
    # Short bursts have harmonics, and their fundamental shows to a fraction of an ordinate.
    for count in (1, 2, 4):
        tried = np.arange(_TEETH_SOUGHT * count, high - 1) / count
        if not tried.size:
            continue
        order = np.round(np.arange(1, count + 1)[:, None] * tried).astype(int)
        together = ratio[order].sum(axis=0)
        at = int(np.argmax(together))
        chance = gamma.logsf(together[at], count) + np.log(3 * len(_REACHES) * tried.size)
        if chance < log_p:
            log_p, beat, size = float(chance), tried[at], float(np.mean(beats[order[:, at]]))
    # How deep: bursts leave nothing between them, and other swings of a line are no bursts.
    at_ordinates = np.arange(first, last) / white.size
    share = float(np.mean(np.interp(at_ordinates, band.frequency, band.share)))
    depth = 2 * np.sqrt(size) / max(np.sum(power) * share, 1e-300)
    if log_p > np.log(_PULSED) or depth < _DEPTH:
        return 0.0
    # Fewer bursts than are looked for show by their harmonics.
    while beat >= 4 and ratio[round(beat / 2)] > _SUBHARMONIC:
        beat /= 2
    return white.size / beat
