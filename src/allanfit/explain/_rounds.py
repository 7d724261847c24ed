"""One more effect at a time: lines, smooth effects and courses compete, and one is taken."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import poisson

from ._chance import course_score, log_chance, score
from ._refit import add_course, drop_courses, evidence, finer_edges, go_back, remembered
from ._state import Finding, Investigation, Searched, whitened_piece
from .courses import _course
from .courses._course import Course
from .courses._scan import propose
from .courses._shapes import at_its_edges, refined, together
from .lines._lines import Peak, Sine, evenly, line_log_chance, refine, scan
from .spectrum import _search
from .spectrum._leakage import leave_leakage
from .spectrum._model import rarity
from .spectrum._search import Candidate
from .spectrum._structure import NARROW
from .spectrum._whiten import level

_MOST_LINES = 12
# Lines are looked for in as many places as there are ordinates: so many times the alarm is theirs.
LINE_ALARM = 3.0
# A peak of as few ordinates is a line until shown to be broad.
_LINE_WIDTH = 4
# Options of the scan at full resolution: peaks of few ordinates and of more.
_NARROWEST = _LINE, _BAND = "line", "band"
# Broad noises, of which one is as good a witness as another that something is left out; with so
# many times the chance that an alarm has.
_STAND_INS = ("gauss_markov", "power_law")
LEEWAY = 3.0
# Courses that hide together with broad noise behind one random walk, if their chance is so small.
_SLOW, _HINT = ("warm_up", "temperature"), float(np.log(0.1))
#: Of steps of which one alone might be chance, and two are not.
TWO = "two"
# And another shape of a filter that is known.
_DROOP = "droop"
# In twice the log-likelihood.
_STRONG = 2e4
# Ordinates to either side that no sinusoid fills.
_SPREAD = 32
# That the course of a measured cause fits by coincidence is 20 times less likely than that it is
# the cause, as twice a logarithm.
_MEASURED = 6.0
# Ordinates about a line within which nothing else may be.
_CLOSE = 8


class Option(NamedTuple):
    """Something that a round may choose."""

    name: str
    log_p: float
    gain: float
    score: float
    #: Takes it, given the scores of its rivals by name.
    take: Callable[[dict[str, float]], None]


def take_one(state: Investigation, drivers: dict[str, Any]) -> bool:
    """One more effect, if any is needed; says whether one was."""
    lines, courses = line_options(state), course_options(state, drivers)
    if lines and lines[0].name == _LINE and _is_first(state, lines, courses):
        lines[0].take({})
        return True
    found = _finite(lines + smooth_options(state) + courses)
    state.nearest = min([state.nearest, *(option.log_p for option in found)])
    alarms = _alarms(state, found)
    if not alarms:
        return _take_together(state, found) or _take_two_steps(state, found)
    # Lines first: nothing smooth explains one, and one distorts what is smooth.
    chosen, among = _choice(state, alarms)
    if among is None and chosen.name in _STAND_INS:
        # That something is left out is told by one, and what it is by the likeliest.
        close = np.log(LEEWAY * state.alarm)
        near = [each for each in found if each.log_p < close and each.name in _STAND_INS]
        chosen = max(near, key=lambda option: option.score)
    rivals: dict[str, float] = {}
    for option in found:
        # What a line explains nothing smooth does, and has its own turn: it is no rival.
        if option.name not in (*_NARROWEST, _DROOP) and (among is None or option.name in among):
            rivals[option.name] = max(option.score, rivals.get(option.name, -np.inf))
    chosen.take(rivals)
    return True


def _take_together(state: Investigation, found: list[Option]) -> bool:
    """A slow course and correlated noise, if both together are no chance; says whether they were.

    Each alone leaves a random walk that stands for the other, beside which it gains little.
    """
    slow = [each for each in found if each.name in _SLOW and each.log_p < _HINT]
    if not slow:
        return False
    course = min(slow, key=lambda option: option.log_p)
    kept = remembered(state)
    course.take({})
    noise = min(
        (each for each in smooth_options(state) if each.name in _STAND_INS),
        key=lambda option: option.log_p,
        default=None,
    )
    if noise is not None:
        product = course.log_p + noise.log_p + np.log(len(_SLOW))
        # Of the product of two probabilities that chance makes uniform.
        together = product + np.log1p(-product)
        state.nearest = min(state.nearest, together)
        if together < np.log(state.alarm):
            state.findings[-1].log_p = together
            noise.take({})
            return True
    go_back(state, kept)
    return False


def _take_two_steps(state: Investigation, found: list[Option]) -> bool:
    """Two steps of which either may be chance, but hardly both; says whether they were taken.

    A bias that goes elsewhere for a while and comes back has two.
    """
    first = _strongest_step(found)
    if first is None:
        return False
    kept = remembered(state)
    first.take({})
    second = _strongest_step(course_options(state, {}))
    if second is not None:
        # As many places are as unlikely by a Poisson law, and one alone had its turn.
        weaker = max(first.log_p, second.log_p)
        both = float(poisson.logsf(1, np.exp(weaker)) + np.log(2))
        state.nearest = min(state.nearest, both)
        if both < np.log(state.alarm):
            second.take({})
            for finding in state.findings[-2:]:
                finding.log_p, finding.detail = both, TWO
            return True
    go_back(state, kept)
    return False


def _strongest_step(found: list[Option]) -> Option | None:
    steps = [option for option in found if option.name == "step" and option.log_p < _HINT]
    return min(steps, key=lambda option: option.log_p, default=None)


def take_strong_lines(state: Investigation) -> None:
    """Lines so strong that what they leak hides whether the noise lasts."""
    for _ in range(_MOST_LINES):
        found = line_options(state)
        if not found or found[0].gain < _STRONG or found[0].log_p > np.log(state.alarm):
            return
        found[0].take({})


def _is_first(state: Investigation, lines: list[Option], courses: list[Option]) -> bool:
    """Whether a line is the first to take, known without a search for smooth effects.

    That takes most of a round, and of a record with many lines as many. A line that was taken left
    the rest as it was, so that what each effect gains is near the place where it was found before.
    """
    found = state.searched
    if found is None or found.of != (state.model.kinds, len(state.peaks)):
        return False
    near = [_search.again(each, state.model, state.data) for each in found.candidates]
    every = _finite(lines + [_smooth_option(state, each) for each in near] + courses)
    alarms = _alarms(state, every)
    return lines[0] in alarms and _choice(state, alarms)[0] is lines[0]


def _alarms(state: Investigation, found: list[Option]) -> list[Option]:
    return [option for option in found if option.log_p < np.log(state.alarm)]


def _finite(found: list[Option]) -> list[Option]:
    return [option for option in found if np.isfinite(option.log_p)]


def _choice(state: Investigation, alarms: list[Option]) -> tuple[Option, tuple[str, ...] | None]:
    """What to take first, and among which rivals; None for all.

    A line comes first, since nothing smooth explains one; but not while the level on which it
    stands is grossly wrong. Then a filter, which bends that level; then what is narrow.
    """
    lines = [option for option in alarms if option.name in _NARROWEST]
    others = [option for option in alarms if option not in lines]
    best = max(others, key=lambda option: option.score, default=None)
    narrow = [option for option in lines if option.name == _LINE]
    if narrow and (best is None or narrow[0].log_p < best.log_p):
        return narrow[0], ()
    if best is not None and best.name == "low_pass":
        return best, None
    if lines and (best is None or best.name in NARROW):
        return lines[0], ()
    kinds = state.model.kinds.added
    if len(state.peaks) > sum(kinds.count(name) for name in NARROW):
        sharp = [option for option in others if option.name in NARROW]
        if sharp:
            return max(sharp, key=lambda option: option.score), NARROW
    if best is None:
        return lines[0], ()
    return best, None


def line_options(state: Investigation) -> list[Option]:
    """The narrow band that stands out most in the spectrum at full resolution, if any does."""
    piece = state.longest
    held = len(state.lines)
    white = whitened_piece(state, piece, ())
    if state.modulation is not None and state.modulation.strength is not None:
        # Ordinates that are near are alike where strength varies, and chance makes bands of them.
        white = white / state.deviation[slice(*piece)]
        white /= np.std(white)
    even = evenly(white, _time(state, piece))
    peaks = [
        peak
        for peak in scan(even, LINE_ALARM * state.alarm)
        if not any(
            abs(peak.frequency - old.frequency) < 3 * (old.half_width + peak.half_width)
            for old in state.peaks
        )
    ]
    state.witness(
        "lines",
        float(len(peaks) + held + len(state.peaks)),
        float(np.exp(peaks[0].log_p)) if peaks else 1.0,
        "The spectrum at full resolution, scanned for narrow bands.",
    )
    if not peaks or held >= _MOST_LINES:
        return []
    peak = peaks[0]
    mean = level(state.left, state.variance)
    density = float(np.interp(peak.frequency, state.left.frequency, mean))
    sine = refine(even, peak, density)

    def take(rivals: dict[str, float]) -> None:
        _take_line(state, peaks, sine, white)

    name = _LINE if _sharp(peak, even.size) else _BAND
    # On the scale of the other options' chances, which have an alarm of their own.
    log_p = peak.log_p - np.log(LINE_ALARM)
    return [Option(name, log_p, sine.gain, sine.gain, take)]


def _take_line(state: Investigation, peaks: list[Peak], sine: Sine, white: np.ndarray) -> None:
    """A peak that one sinusoid empties is one; another is broad, and left to the spectrum."""
    peak, time = peaks[0], _time(state, state.longest)
    samples = int(time[-1]) + 1
    angle = 2 * np.pi * sine.frequency * time
    basis = np.column_stack([np.cos(angle), np.sin(angle)])
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
    if again and _nearer(state, same[0], white):
        return
    if alone and not beside and not same:
        course = _line(state, sine.frequency)
        course.shape["deviation"] = sine.frequency_deviation
        add_course(state, course, Finding("sinusoid", peak.log_p, sine.gain))
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


def _nearer(state: Investigation, old: Course, white: np.ndarray) -> bool:
    """The frequency of a line again, from what is left of it; whether it is near.

    While it was there, the level on which it stood was not well known. A sinusoid whose frequency
    is wrong by d leaves 2 pi d t times its derivative in phase.
    """
    frequency = old.shape["frequency"]
    time = _time(state, state.longest)
    angle = 2 * np.pi * frequency * time
    basis = np.column_stack([np.cos(angle), np.sin(angle)])
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


def smooth_options(state: Investigation) -> list[Option]:
    """Each effect of the spectrum, where it gains most beside what the model holds."""
    pairs = tuple((peak.frequency, peak.half_width) for peak in state.peaks)
    candidates = _search.candidates(state.model, state.data, pairs)
    state.searched = Searched((state.model.kinds, len(state.peaks)), candidates)
    return [_smooth_option(state, candidate) for candidate in candidates]


def _smooth_option(state: Investigation, candidate: Candidate) -> Option:
    chance = log_chance(candidate.name, candidate.gain)

    def take(rivals: dict[str, float]) -> None:
        state.model = candidate.model
        if state.model.kinds.angle_filtered:
            leave_leakage(state)
        # Another shape of a filter is no effect of its own, but of what is found already.
        if candidate.name != _DROOP:
            finding = Finding(candidate.name, chance, candidate.gain, rivals)
            state.findings.append(finding)

    worth = score(candidate.name, candidate.gain)
    if candidate.name in (*NARROW, "gauss_markov"):
        worth += rarity(candidate.model, state.data)
    return Option(candidate.name, chance, candidate.gain, worth, take)


def course_options(state: Investigation, drivers: dict[str, Any]) -> list[Option]:
    """The courses in time that look most promising."""
    proposals = propose(
        state.values.size, state.pieces, state.calm, state.left, state.model, state.data, drivers
    )
    options: list[Option] = []
    for course in proposals:
        if any(course.name == old.name and course.shape == old.shape for old in state.courses):
            continue
        if state.switching and course.name == "step":
            continue
        gain, log_p = evidence(state, course)
        if course.name == "vibration_rectification" and log_p < np.log(state.alarm):
            # Steps compete that are at their places already.
            course, _ = at_its_edges(state, course)
            gain = max(gain, evidence(state, course)[0])

        def take(
            rivals: dict[str, float],
            course: Course = course,
            log_p: float = log_p,
            gain: float = gain,
        ) -> None:
            best = refined(state, course, drivers)
            add_course(state, best, Finding(course.name, log_p, gain, rivals))
            together(state)

        worth = course_score(gain, course.sizes, course.places, course.length)
        if course.name in drivers:
            worth += _MEASURED
        options.append(Option(course.name, log_p, gain, worth, take))
    return options
