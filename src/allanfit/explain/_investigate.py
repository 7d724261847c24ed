"""One channel under investigation: what is amiss, found one thing at a time, strongest first.

Order of questions: how samples were made (held, rounded, clipped); whether their noise lasts and
is normal; then lines, courses in time and smooth effects of the spectrum, in rounds, each round
taking what is least likely to be chance, until nothing is left that is.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

from ..physics import Sampling
from . import _means, _search
from ._format import Format, sample_format
from ._lines import Peak, Sine, refine, scan
from ._means import Course, Sized
from ._ordinates import Ordinates, bin_edges, binned, ordinates
from ._search import Candidate, Model
from ._spread import Contamination, Modulation, contamination, modulation, runs
from ._structure import Data
from ._whiten import level, whitened

# Chance of a false alarm in each of the families of tests, for a recording of one channel.
ALARM = 0.0008
_MOST_ROUNDS = 10
_MOST_LINES = 12
# Lines are looked for in as many places as there are ordinates, at a chance of their own.
_LINE_ALARM = 4.0
_LINE_FIRST = 1.0
# A peak of as few ordinates is a line until shown to be broad.
_LINE_WIDTH = 4
_NARROW = ("resonance", "drifting_line")
# Loud for less of the record, and by more, is a knock and no change of the noise.
_KNOCK_SHARE, _KNOCK_RATIO = 0.15, 2.0
_MARGIN = 2
_MOST_STEPS = 8
# A quiet time must be as long for its own fit.
_SHORTEST_QUIET = 1024


@dataclass
class Finding:
    """One effect that was named."""

    name: str
    #: Log of the chance of the evidence without the effect, and twice the log-likelihood gained.
    log_p: float
    gain: float
    #: Rivals by name: what each would have gained less what it costs, the effect itself included.
    rivals: dict[str, float] = field(default_factory=dict)
    #: What the document needs of effects that no structure or course holds.
    detail: Any = None


@dataclass
class Investigation:
    """The state of knowledge of one channel."""

    values: Float[np.ndarray, " samples"]
    pieces: tuple[tuple[int, int], ...]
    sampling: Sampling
    #: Chance of a false alarm for each family of tests on this channel.
    alarm: float
    format: Format
    spectrum: Ordinates
    edges: Float[np.ndarray, " edges"]
    data: Data
    #: The five terms alone, and all that is known now.
    first: Model
    model: Model
    first_data: Data
    courses: list[Course] = field(default_factory=list)
    #: The amplitudes of the ordinates of each course.
    moved: list[Float[np.ndarray, "ordinates columns"]] = field(default_factory=list)
    sized: Sized | None = None
    findings: list[Finding] = field(default_factory=list)
    peaks: list[Peak] = field(default_factory=list)
    contamination: Contamination | None = None
    modulation: Modulation | None = None
    knocks: list[tuple[int, int]] = field(default_factory=list)
    #: Variance of white noise that does not belong to N: rounding, spikes, loud times [u^2].
    foreign: float = 0.0
    witnesses: list[dict[str, Any]] = field(default_factory=list)
    #: Log of the chance of the strongest evidence within its family of tests.
    nearest: float = 0.0
    unexplained: Candidate | None = None

    @property
    def left(self) -> Ordinates:
        """The ordinates less the courses."""
        return self.spectrum if self.sized is None else self.sized.left

    @property
    def cost(self) -> float:
        """Minus twice the log-likelihood of what is known now."""
        return _means.cost(self.model, self.data)


def investigate(
    values: Float[np.ndarray, " samples"],
    pieces: tuple[tuple[int, int], ...],
    sampling: Sampling,
    power: Float[np.ndarray, " terms"],
    *,
    alarm: float = ALARM,
    drivers: dict[str, Float[np.ndarray, "samples columns"]] | None = None,
    lost: float = 0.0,
    seed: int = 0,
) -> Investigation:
    """Find what the five terms leave out of one channel.

    `power` are the squared coefficients of the five-term fit for a sampling interval of one, and
    `drivers` what may move the channel, by the name of the effect, centred; `lost` is the share of
    samples that time stamps say were lost on the way.
    """
    state = _begin(values, pieces, sampling, power, alarm)
    drivers = dict(drivers or {})
    _about_format(state)
    knocked = _about_spread(state, seed)
    if knocked:
        cut = _without(pieces, state.knocks)
        later = _begin(values, cut, sampling, power, alarm)
        later.findings, later.knocks = state.findings, state.knocks
        later.witnesses = state.witnesses
        state = later
        _about_format(state)
        _about_spread(state, seed)
    if lost > 0:
        state.findings.append(Finding("dropped_samples", -1e3, 0.0, {}, lost))
    if state.modulation is not None and state.contamination is None:
        drivers["vibration_rectification"] = _loudness(state)
    for _ in range(_MOST_ROUNDS):
        if not _round(state, drivers):
            break
    _reconsider(state)
    _leftover(state)
    state.nearest = min([state.nearest, *(finding.log_p for finding in state.findings)])
    return state


def _begin(values, pieces, sampling, power, alarm) -> Investigation:
    found = sample_format(values, pieces)
    parts = tuple(values[start:stop] for start, stop in pieces)
    spectrum = ordinates(parts, sampling)
    edges = bin_edges(spectrum.longest)
    bins = binned(spectrum, edges)
    data = Data(bins, float(spectrum.longest), 0.0, 1.0, np.ones(4, bool))
    first = _search.five_terms(power, data)
    return Investigation(
        values, pieces, sampling, alarm, found, spectrum, edges, data, first, first, data
    )


def _about_format(state: Investigation) -> None:
    """Samples that were held, rounded or clipped: known for sure, modelled as they were made."""
    made = state.format
    if made.repeat is not None:
        state.findings = [f for f in state.findings if f.name != "sample_hold"]
        state.findings.append(Finding("sample_hold", max(made.repeat.log_p, -1e4), 0.0))
        if made.repeat.regular:
            # Up to the Nyquist frequency of the fresh values; beyond are their images.
            state.spectrum = state.spectrum._replace(top=0.5 / made.repeat.samples)
        state.data = state.data._replace(repeat=made.repeat.samples)
        _rebin(state)
    if made.coarse:
        state.findings = [f for f in state.findings if f.name != "output_rounding"]
        state.findings.append(Finding("output_rounding", -1e3, 0.0))
    if made.rails:
        state.findings = [f for f in state.findings if f.name != "saturation"]
        state.findings.append(Finding("saturation", -1e3, 0.0))
    # Rounding is white noise behind any filter, however little.
    state.foreign += made.width**2 / 12
    _refit(state)


def _refit(state: Investigation) -> None:
    """The present structure again, with what is known of white noise that is not N."""
    # Of all white noise something has to be left for N: coarse codes may hide the noise.
    white = 2 * float(np.exp(state.first.theta[1]))
    state.data = state.data._replace(foreign=min(2 * state.foreign, 0.999 * white))
    theta = np.array(state.model.theta)
    starts = [(state.model.kinds, theta), (state.model.kinds, theta - np.eye(theta.size)[1])]
    state.model = min(_search.best(starts, state.data), key=lambda model: model.deviance)


def _white(state: Investigation, piece: tuple[int, int], notches=()) -> np.ndarray:
    mean = _means.ordinate_variance(state.spectrum, state.model, state.data)
    expected = level(state.left, mean)
    values = state.values[piece[0] : piece[1]]
    if state.sized is not None:
        drawn = np.column_stack([c.template for c in state.courses])[piece[0] : piece[1]]
        values = values - drawn @ state.sized.sizes
    return whitened(values, state.left, expected, notches)


def _longest(state: Investigation) -> tuple[int, int]:
    return max(state.pieces, key=lambda piece: piece[1] - piece[0])


def _about_spread(state: Investigation, seed: int) -> bool:
    """Outliers, loud times and knocks. Says whether the record has to be cut."""
    if state.format.coarse or state.format.repeat is not None:
        # Coarse or held samples are not normal, and their whitened record is not either.
        return False
    piece = _longest(state)
    rough = _white(state, piece)
    notches = tuple(peak.frequency for peak in scan(rough, 1e-4))
    white = _white(state, piece, notches)
    changing = modulation(white, seed)
    state.witnesses.append(
        {
            "name": "variance in time",
            "statistic": changing.ratio,
            "p_value": changing.p_value,
            "sentence": "Windowed variances of the whitened record, compared.",
        }
    )
    loud = changing.p_value < state.alarm and changing.loud.any() and not changing.loud.all()
    if loud and not state.knocks:
        share = changing.loud.mean()
        if share < _KNOCK_SHARE and _steps_instead(state, piece, changing):
            return _about_spread(state, seed)
        if share < _KNOCK_SHARE and changing.ratio > _KNOCK_RATIO:
            pulled = changing.window * _MARGIN
            state.knocks = [
                (piece[0] + max(a - pulled, 0), piece[0] + min(b + pulled, changing.loud.size))
                for a, b in runs(changing.loud)
            ]
            detail = changing
            state.findings.append(
                Finding("disturbance", np.log(max(changing.p_value, 1e-300)), 0.0, {}, detail)
            )
            return True
    if loud:
        state.modulation = changing
        even = white / np.where(changing.loud, changing.ratio, 1.0)
        even = even / np.std(np.clip(even, -4, 4))
    else:
        even = white
    spiky = contamination(even, seed)
    state.witnesses.append(
        {
            "name": "outliers",
            "statistic": spiky.gain,
            "p_value": spiky.p_value,
            "sentence": "Two normal distributions against one, on the whitened record.",
        }
    )
    # How tall a spike of one unit is in the whitened record.
    mean = level(state.left, _means.ordinate_variance(state.spectrum, state.model, state.data))
    height = float(np.mean(1 / np.sqrt(mean / 2)))
    if loud:
        added = _loud_variance(state, piece, changing)
        # As loud as it gets, in all of the spectrum or in the white part of it.
        share = float(changing.loud.mean())
        quiet = max(float(np.exp(state.model.theta[1])) - added, 1e-300)
        ratio = max(changing.ratio**2, 1 + added / share / quiet)
        strength = np.where(changing.loud, ratio, 1.0)
        dilution = float(np.mean(strength**2) / np.mean(strength) ** 2)
        state.spectrum = state.spectrum._replace(dilution=dilution)
        state.foreign += added
        state.findings.append(
            Finding("variance_modulation", np.log(max(changing.p_value, 1e-300)), 0.0, {}, changing)
        )
        _rebin(state)
    if spiky.p_value < state.alarm and spiky.amplitude > 1.5 * spiky.sigma:
        state.contamination = in_units(spiky, height)
        state.findings.append(
            Finding(
                "outliers",
                np.log(max(spiky.p_value, 1e-300)),
                spiky.gain,
                {},
                state.contamination,
            )
        )
        state.foreign += _excise(state, piece, even, spiky) / height**2
    if loud or state.contamination is not None:
        _refit(state)
    return False


def _steps_instead(state: Investigation, piece: tuple[int, int], changing: Modulation) -> bool:
    """Whether the mean jumps where it is loud: whitening makes a pulse of a step.

    Takes the steps if so; else leaves everything as it was.
    """
    found = runs(changing.loud)
    if len(found) > _MOST_STEPS or any(course.name == "step" for course in state.courses):
        return False
    before = (list(state.courses), list(state.moved), state.sized, state.model, state.data)
    taken: list[Finding] = []
    for a, b in found:
        middle, half = piece[0] + (a + b) / 2, max((b - a) / 2, changing.window)
        cost = state.cost
        course = _means.polish(
            _means.step(round(middle), state.values.size),
            lambda at: _means.step(round(at), state.values.size),
            middle,
            half / 2,
            lambda tried: -_with(state, tried).cost,
        )
        gain = cost - _with(state, course).cost
        if _means.log_chance("step", gain) > 2 * np.log(state.alarm):
            break
        finding = Finding("step", _means.log_chance("step", gain), gain)
        _add_course(state, course, finding)
        taken.append(finding)
    else:
        return True
    state.courses, state.moved, state.sized, state.model, state.data = before
    state.findings = [each for each in state.findings if each not in taken]
    return False


def _loud_variance(state: Investigation, piece: tuple[int, int], changing: Modulation) -> float:
    """White variance that loud times add to the mean of all [u^2].

    The quiet times alone, as stretches of a record of their own, have an N of their own.
    """
    quiet = tuple(
        state.values[piece[0] + a : piece[0] + b]
        for a, b in runs(~changing.loud)
        if b - a >= _SHORTEST_QUIET
    )
    if not quiet:
        return 0.0
    spectrum = ordinates(quiet, state.sampling)
    bins = binned(spectrum, bin_edges(spectrum.longest))
    data = state.data._replace(bins=bins, samples=float(spectrum.longest), foreign=0.0, repeat=1.0)
    alone = _search.five_terms(np.exp(state.model.theta[:4]), data)
    return float(np.exp(state.model.theta[1]) - np.exp(alone.theta[1]))


def in_units(found: Contamination, height: float) -> Contamination:
    """In the unit of the record, where a spike of one unit stands `height` tall when whitened."""
    scale = np.array([1.0, 1 / height, 1 / height])
    return found._replace(
        amplitude=found.amplitude / height, sigma=found.sigma / height, draws=found.draws * scale
    )


def _excise(
    state: Investigation,
    piece: tuple[int, int],
    white: Float[np.ndarray, " samples"],
    spiky: Contamination,
) -> float:
    """Put neighbours' means in place of clear spikes, for the analysis alone.

    Returns the variance, in the whitened record, of white noise that this leaves wrong: faint
    spikes that stay, less the noise of the samples replaced.
    """
    clear = np.abs(white) > spiky.threshold
    values = state.values.copy()
    inside = values[piece[0] : piece[1]]
    good = np.flatnonzero(~clear)
    for at in np.flatnonzero(clear):
        place = int(np.searchsorted(good, at))
        near = good[max(place - 4, 0) : place + 4]
        inside[at] = inside[near].mean()
    state.values = values
    parts = tuple(values[start:stop] for start, stop in state.pieces)
    state.spectrum = ordinates(parts, state.sampling)
    _rebin(state)
    share = float(clear.mean())
    faint = float(np.mean(white[~clear] ** 2)) - spiky.sigma**2
    return (1 - share) * faint - share * spiky.sigma**2


def _without(
    pieces: tuple[tuple[int, int], ...], knocks: list[tuple[int, int]]
) -> tuple[tuple[int, int], ...]:
    """The stretches less some intervals; what is left must be long enough to use."""
    left = []
    for start, stop in pieces:
        at = start
        for a, b in sorted(knocks):
            if a < stop and b > start:
                if a - at >= 64:
                    left.append((at, a))
                at = max(at, b)
        if stop - at >= 64:
            left.append((at, stop))
    return tuple(left)


def _loudness(state: Investigation) -> Float[np.ndarray, "samples columns"]:
    """Local variance of the fast noise [u^2], smooth, centred: what may rectify."""
    changing = state.modulation
    assert changing is not None
    start, stop = _longest(state)
    mean = _means.ordinate_variance(state.spectrum, state.model, state.data)
    quiet = float(np.mean(mean[mean.size // 2 :]) / 2)
    column = np.zeros(state.values.size)
    column[start:stop] = np.where(changing.loud, (changing.ratio**2 - 1) * quiet, 0.0)
    return (column - column[start:stop].mean())[:, None]


class _Option:
    """Something that a round may choose."""

    def __init__(self, name, log_p, gain, score, take):
        self.name, self.log_p, self.gain, self.score, self.take = name, log_p, gain, score, take


def _round(state: Investigation, drivers: dict[str, Any]) -> bool:
    """One more effect, if any is needed; says whether one was."""
    options = _line_options(state) + _smooth_options(state) + _course_options(state, drivers)
    options = [option for option in options if np.isfinite(option.log_p)]
    state.nearest = min([state.nearest, *(option.log_p for option in options)])
    alarms = [option for option in options if option.log_p < np.log(state.alarm)]
    if not alarms:
        return False
    # Lines first: nothing smooth explains one, and one distorts what is smooth.
    chosen, among = _choice(state, alarms)
    rivals: dict[str, float] = {}
    for option in options:
        if among is None or option.name in among:
            rivals[option.name] = max(option.score, rivals.get(option.name, -np.inf))
    chosen.take(rivals)
    return True


def _choice(
    state: Investigation, alarms: list["_Option"]
) -> tuple["_Option", tuple[str, ...] | None]:
    """What to take first, and among which rivals; None for all.

    A line comes first, since nothing smooth explains one; but not while the level on which it
    stands is grossly wrong. Then a filter, which bends that level; then what is narrow.
    """
    lines = [option for option in alarms if option.name in ("line", "band")]
    others = [option for option in alarms if option not in lines]
    best = max(others, key=lambda option: option.score, default=None)
    narrow = [option for option in lines if option.name == "line"]
    if narrow and (best is None or narrow[0].log_p < _LINE_FIRST * best.log_p):
        return narrow[0], ()
    if best is not None and best.name == "low_pass":
        return best, None
    if lines and (best is None or best.name in _NARROW):
        return lines[0], ()
    kinds = state.model.kinds.added
    if len(state.peaks) > sum(kinds.count(name) for name in _NARROW):
        sharp = [option for option in others if option.name in _NARROW]
        if sharp:
            return max(sharp, key=lambda option: option.score), _NARROW
    if best is None:
        return lines[0], ()
    return best, None


def _line_options(state: Investigation) -> list[_Option]:
    piece = _longest(state)
    held = sum(course.name == "sinusoid" for course in state.courses)
    known = tuple(peak.frequency for peak in state.peaks)
    white = _white(state, piece, ())
    peaks = [
        peak
        for peak in scan(white, _LINE_ALARM * state.alarm)
        if not any(
            abs(peak.frequency - old.frequency) < 3 * (old.half_width + peak.half_width)
            for old in state.peaks
        )
    ]
    state.witnesses = [w for w in state.witnesses if w["name"] != "lines"]
    state.witnesses.append(
        {
            "name": "lines",
            "statistic": len(peaks) + held + len(known),
            "p_value": float(np.exp(peaks[0].log_p)) if peaks else 1.0,
            "sentence": "The spectrum at full resolution, scanned for narrow bands.",
        }
    )
    if not peaks or held >= _MOST_LINES:
        return []
    peak = peaks[0]
    mean = level(state.left, _means.ordinate_variance(state.spectrum, state.model, state.data))
    density = float(np.interp(peak.frequency, state.left.frequency, mean))
    sine = refine(white, peak.frequency, density)

    def take(rivals: dict[str, float]) -> None:
        _take_line(state, peak, sine, white)

    name = "line" if peak.half_width * white.size <= _LINE_WIDTH / 2 else "band"
    # On the scale of the other options' chances, which have an alarm of their own.
    log_p = peak.log_p - np.log(_LINE_ALARM)
    return [_Option(name, log_p, sine.gain, sine.gain, take)]


def _take_line(state: Investigation, peak: Peak, sine: Sine, white: np.ndarray) -> None:
    """A peak that one sinusoid empties is one; another is broad, and left to the spectrum."""
    samples = white.size
    time = np.arange(samples)
    angle = 2 * np.pi * sine.frequency * time
    basis = np.column_stack([np.cos(angle), np.sin(angle)])
    rest = white - basis @ np.linalg.lstsq(basis, white, rcond=None)[0]
    near = [
        other
        for other in scan(rest, 1e-3)
        if abs(other.frequency - sine.frequency) < max(8 / samples, 2 * peak.half_width)
    ]
    if not near:
        course = _means.oscillation(sine.frequency, _longest(state)[0], state.values.size)
        course.shape["deviation"] = sine.frequency_deviation
        log_p = peak.log_p
        _add_course(state, course, Finding("sinusoid", log_p, sine.gain))
        return
    # As wide as what is left beside the middle.
    spread = [abs(other.frequency - peak.frequency) + other.half_width for other in near]
    state.peaks.append(peak._replace(half_width=max(peak.half_width, *spread)))
    pairs = tuple((p.frequency, p.half_width) for p in state.peaks)
    state.edges = bin_edges(state.spectrum.longest, pairs)
    _rebin(state)


def _rebin(state: Investigation) -> None:
    bins = binned(state.left, state.edges)
    state.data = state.data._replace(bins=bins)
    state.model = _search.best([(state.model.kinds, state.model.theta)], state.data)[0]


def _smooth_options(state: Investigation) -> list[_Option]:
    pairs = tuple((peak.frequency, peak.half_width) for peak in state.peaks)
    options = []
    for candidate in _search.candidates(state.model, state.data, pairs):

        def take(rivals: dict[str, float], candidate: Candidate = candidate) -> None:
            state.model = candidate.model
            state.findings.append(
                Finding(
                    candidate.name,
                    _search.log_chance(candidate.name, candidate.gain),
                    candidate.gain,
                    rivals,
                )
            )

        options.append(
            _Option(
                candidate.name,
                _search.log_chance(candidate.name, candidate.gain),
                candidate.gain,
                _search.score(candidate.name, candidate.gain),
                take,
            )
        )
    return options


def _course_options(state: Investigation, drivers: dict[str, Any]) -> list[_Option]:
    values = state.values
    if state.sized is not None:
        values = values - np.column_stack([c.template for c in state.courses]) @ state.sized.sizes
    proposals = _means.propose(
        values.size, state.pieces, values, state.left, state.model, state.data, drivers
    )
    before = state.cost
    options: list[_Option] = []
    for course in proposals:
        if any(course.name == old.name and course.shape == old.shape for old in state.courses):
            continue
        sized = _with(state, course)
        gain = max(before - sized.cost, 0.0)

        def take(rivals: dict[str, float], course: Course = course, gain: float = gain) -> None:
            log_p = _means.log_chance(course.name, gain)
            _add_course(state, _refined(state, course), Finding(course.name, log_p, gain, rivals))

        options.append(
            _Option(
                course.name,
                _means.log_chance(course.name, gain),
                gain,
                _means.score(course.name, gain),
                take,
            )
        )
    return options


def _moved(state: Investigation) -> Float[np.ndarray, "ordinates columns"]:
    nothing = np.zeros((state.spectrum.frequency.size, 0))
    return np.concatenate([nothing, *state.moved], axis=1)


def _with(state: Investigation, course: Course, *, shapes_too: bool = False) -> Sized:
    moved = np.concatenate([_moved(state), _means.moved_by(course, state.pieces)], axis=1)
    return _means.size_up(
        state.spectrum, moved, state.model, state.data, state.edges, shapes_too=shapes_too
    )


def _refined(state: Investigation, course: Course) -> Course:
    """The course at its best place in time."""
    start, stop = _longest(state)
    length, samples = stop - start, state.values.size

    def gain(tried: Course) -> float:
        return -_with(state, tried).cost

    if course.name == "step":
        return _means.polish(
            course,
            lambda at: _means.step(round(at), samples),
            course.shape["time"],
            length / 2000,
            gain,
        )
    if course.name == "warm_up":
        constant = course.shape["time_constant"]
        best = _means.polish(
            course, lambda c: _means.warm_up(c, start, samples), constant, constant / 5, gain
        )
        constant = best.shape["time_constant"]
        # Its standard deviation from how fast the likelihood falls beside the best.
        beside = [gain(_means.warm_up(part * constant, start, samples)) for part in (0.9, 1.1)]
        fall = max(gain(best) - np.mean(beside), 1e-3)
        best.shape["deviation"] = 0.1 * constant / np.sqrt(fall)
        return best
    if course.name == "sinusoid":
        sized = _with(state, course)
        amplitude = float(np.hypot(*sized.sizes[-2:]))
        variance = _means.ordinate_variance(sized.left, sized.model, sized.data)
        density = np.interp(course.shape["frequency"], sized.left.frequency, variance)
        spread = np.sqrt(12 * density / (amplitude**2 * float(length) ** 3)) / (2 * np.pi)
        course.shape["deviation"] = float(spread)
    return course


def _add_course(state: Investigation, course: Course, finding: Finding) -> None:
    state.sized = _with(state, course, shapes_too=True)
    state.courses.append(course)
    state.moved.append(_means.moved_by(course, state.pieces))
    state.findings.append(finding)
    state.model, state.data = state.sized.model, state.sized.data


def _reconsider(state: Investigation) -> None:
    """Take back what later effects have made superfluous."""
    for name in state.model.kinds.names:
        start = _search.without(state.model, name)
        less = _search.best([(start.kinds, start.theta)], state.data)[0]
        gain = less.deviance - state.model.deviance
        if _search.log_chance(name, gain) > np.log(state.alarm):
            state.model = less
            state.findings = [f for f in state.findings if f.name != name]
    if state.sized is not None:
        state.sized = replace_model(state)


def replace_model(state: Investigation) -> Sized:
    """The courses beside the structure as it is now."""
    sized = _means.size_up(
        state.spectrum, _moved(state), state.model, state.data, state.edges, shapes_too=True
    )
    state.model, state.data = sized.model, sized.data
    return sized


def _leftover(state: Investigation) -> None:
    """What nothing of the catalogue explains, as a smooth bump."""
    found = _search.bumps(state.model, state.data)
    if found and _search.log_chance("bump", found[0].gain) < np.log(state.alarm):
        state.unexplained = found[0]
        state.model = found[0].model
