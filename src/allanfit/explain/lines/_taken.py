"""Narrow bands of the spectrum at full resolution, each taken as a sinusoid or as what is broad."""

from functools import partial

import numpy as np
from jaxtyping import Float

from .._options import Option
from .._refit import add_course, drop_courses, finer_edges
from .._state import Finding, Investigation, whitened_piece
from ..courses import _course
from ..courses._course import Course
from ..spectrum._structure import NARROW
from ..spectrum._whiten import level
from ._lines import Peak, Sine, evenly, line_log_chance, refine, scan
from ._several import several

#: Options of the scan at full resolution: peaks of few ordinates and of more.
LINE, BAND = "line", "band"
#: Lines are looked for in as many places as there are ordinates: so many times the alarm is theirs.
LINE_ALARM = 3.0
_MOST_LINES = 12
# A peak of as few ordinates is a line until shown to be broad.
_LINE_WIDTH = 4
# In twice the log-likelihood.
_STRONG = 2e3
# Ordinates to either side that no sinusoid fills.
_SPREAD = 32
# Ordinates about a line within which nothing else may be.
_CLOSE = 8


def take_strong_lines(state: Investigation) -> None:
    """Lines so strong that what they leak hides whether the noise lasts."""
    for _ in range(_MOST_LINES):
        found = line_options(state)
        if not found or found[0].gain < _STRONG or found[0].log_p > np.log(state.alarm):
            return
        found[0].take({})


def line_options(state: Investigation) -> list[Option]:
    """The narrow band that stands out most in the spectrum at full resolution, if any does."""
    piece = state.longest
    held = len(state.lines)
    white = whitened_piece(state, piece, ())
    weight = np.ones(white.size)
    if state.modulation is not None and state.modulation.strength is not None:
        # Ordinates that are near are alike where strength varies, and chance makes bands of them.
        weight = 1 / state.deviation[slice(*piece)]
        weight /= np.std(white * weight)
    white = white * weight
    even = evenly(white, _time(state, piece))
    peaks = [
        peak
        for peak in scan(even, LINE_ALARM * state.alarm)
        if not any(
            abs(peak.frequency - old.frequency) < 3 * (old.half_width + peak.half_width)
            for old in state.peaks
        )
    ]
    # They are taken out before: without a word a reader takes the chance for theirs.
    known = held or state.peaks or set(state.model.kinds.added) & set(NARROW)
    beside = " beside those that are known already" if known else ""
    state.witness(
        "lines",
        float(len(peaks) + held + len(state.peaks)),
        float(np.exp(peaks[0].log_p)) if peaks else 1.0,
        f"The spectrum at full resolution, scanned for narrow bands{beside}.",
    )
    if not peaks or held >= _MOST_LINES:
        return []
    peak = peaks[0]
    mean = level(state.left, state.variance)
    density = float(np.interp(peak.frequency, state.left.frequency, mean))
    sine = refine(even, peak, density)

    def take(rivals: dict[str, float]) -> None:
        _take_line(state, peaks, sine, white, weight)

    name = LINE if _sharp(peak, even.size) else BAND
    # On the scale of the other options' chances, which have an alarm of their own.
    log_p = peak.log_p - np.log(LINE_ALARM)
    return [Option(name, log_p, sine.gain, sine.gain, take)]


def _take_line(
    state: Investigation,
    peaks: list[Peak],
    sine: Sine,
    white: Float[np.ndarray, " samples"],
    weight: Float[np.ndarray, " samples"],
) -> None:
    """A peak that one sinusoid empties is one; another is broad, and left to the spectrum.

    The `white` record has everything times `weight`, sinusoids too.
    """
    peak, time = peaks[0], _time(state, state.longest)
    samples = int(time[-1]) + 1
    angle = 2 * np.pi * sine.frequency * time
    basis = weight[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    rest = white - basis @ np.linalg.lstsq(basis, white, rcond=None)[0]
    close = max(_CLOSE / samples, 2 * peak.half_width)
    # As loosely as the peak was found: what is left of a broad one may be weaker than it.
    loose = max(1e-3, LINE_ALARM * state.alarm)
    beside = [
        other
        for other in scan(evenly(rest, time), loose)
        if abs(other.frequency - sine.frequency) < close
    ]
    alone = line_log_chance(sine.gain / 2, sine.frequency, samples) < np.log(loose)
    # A line that wanders shows one peak after another within its width.
    same = [
        course for course in state.lines if abs(course.shape["frequency"] - sine.frequency) < close
    ]
    again = len(same) == 1 and same[0].sizes == 2 and "nearer" not in same[0].shape
    if again and _nearer(state, same[0], white, weight):
        return
    if alone and not beside and not same:
        _add_line(state, sine, peak.log_p)
        return
    near = [] if same else several(white, weight, time, peak, loose)
    for each in near:
        _add_line(state, each, line_log_chance(each.gain / 2, each.frequency, samples))
    if near:
        return
    # As wide as what is left beside the middle.
    spread = [abs(other.frequency - peak.frequency) + other.half_width for other in beside]
    spread += [abs(course.shape["frequency"] - peak.frequency) for course in same]
    if same:
        drop_courses(state, same)
    state.peaks.append(peak._replace(half_width=max(peak.half_width, *spread, 0.0)))
    # Broad ones at once: they only say where bins must be fine. A strong sinusoid between two
    # ordinates is as broad as some dozen of them, and has its turn.
    state.peaks += [other for other in peaks[1:] if other.half_width * samples > _SPREAD]
    finer_edges(state)


def _add_line(state: Investigation, sine: Sine, log_p: float) -> None:
    course = _line(state, sine.frequency)
    course.shape["deviation"] = sine.frequency_deviation
    add_course(state, course, Finding("sinusoid", log_p, sine.gain))


def _time(state: Investigation, piece: tuple[int, int]) -> Float[np.ndarray, " samples"]:
    """Of the samples of a stretch, those included that were lost between them."""
    start, stop = piece
    return state.place[start:stop] - state.place[start]


def _line(state: Investigation, frequency: float) -> Course:
    """A sinusoid, whose phase is free after each time of which nothing tells how long it was."""
    start = state.longest[0]
    time = state.place - state.place[start]
    if not state.breaks:
        return _course.oscillation(frequency, time)
    after = partial(np.searchsorted, state.breaks, side="right")
    sums = np.zeros(len(state.breaks) + 1, complex)
    for piece in state.pieces:
        turning = np.exp(-2j * np.pi * frequency * time[slice(*piece)])
        sums[after(piece[0])] += whitened_piece(state, piece, ()) @ turning
    ahead = np.angle(sums * np.conj(sums[after(start)]))
    return _course.oscillation(frequency, time, ahead[after(np.arange(time.size))])


def _nearer(
    state: Investigation,
    old: Course,
    white: Float[np.ndarray, " samples"],
    weight: Float[np.ndarray, " samples"],
) -> bool:
    """The frequency of a line again, from what is left of it; whether it is near.

    While it was there, the level on which it stood was not well known. A sinusoid whose frequency
    is wrong by d leaves 2 pi d t times its derivative in phase.
    """
    frequency = old.shape["frequency"]
    time = _time(state, state.longest)
    angle = 2 * np.pi * frequency * time
    basis = weight[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    late = time[:, None] - time.mean()
    cosine, sine = np.linalg.lstsq(np.hstack([basis, late * basis]), white, rcond=None)[0][2:]
    # What whitening makes of its amplitude, which is zero at no frequency near by.
    place = next(i for i, each in enumerate(state.courses) if each is old)
    begin = sum(each.sizes for each in state.courses[:place])
    density = np.interp(frequency, state.left.frequency, level(state.left, state.variance))
    assert state.sized is not None
    a, b = state.sized.sizes[begin : begin + 2] / np.sqrt(density / 2)
    moved = (cosine * b - sine * a) / (2 * np.pi * (a**2 + b**2))
    if abs(moved) > 0.5 / (time[-1] + 1):
        return False
    before = list(state.findings)
    drop_courses(state, [old])
    (finding,) = [each for each in before if not any(each is other for other in state.findings)]
    course = _line(state, frequency + moved)
    course.shape.update(deviation=old.shape["deviation"], nearer=True)
    add_course(state, course, finding)
    return True


def _sharp(peak: Peak, samples: int) -> bool:
    return peak.half_width * samples <= _LINE_WIDTH / 2
