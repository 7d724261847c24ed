"""What is there but is no effect of the catalogue, though one may describe it best.

Each cause outside the catalogue that engineers meet has a name nearest to it: a sweep looks like a
drifting line, a line in bursts like many lines, a filter that changes like noise that changes. The
name is right only if what else it says is so too.
"""

from functools import partial

import numpy as np
from jaxtyping import Bool, Float

from ._bumps import bump_for_filter, bump_instead
from ._intervals import runs
from ._state import Finding, Investigation, Unknown, whitened_piece
from .courses._pulses import tell_pulses
from .lines._changing import look_at_lines
from .lines._comb import strongest_comb
from .lines._harmonics import Line, families
from .lines._line_or_resonance import tell_apart
from .lines._waveform import waveform
from .spectrum import _model
from .spectrum._density import filter_slopes
from .spectrum._narrow import narrow_groups, narrow_noises
from .spectrum._ordinates import points
from .spectrum._structure import SHAPE
from .spectrum._whiten import within, without_bands
from .strength._changing import (
    TILE,
    moved_along,
    parts,
    reshaped,
    reshaped_at_times,
    shares,
    swinging,
    tiles,
)
from .strength._lasting import count_out_filtered, forget_loud_times, weighted_by_n
from .strength._modulation import PULLED_IN, uneven
from .values._held_out import of_swing
from .values._spikes import USUAL

# A filter's corner moves if chance says so as rarely, and it gains such a part of the filter.
_CORNER, _CORNER_SHARE = 1e-4, 0.05
# What changes below such a part of it is no filter's doing.
_WITHIN = 0.25
# A waveform is looked for where so many of its harmonics are lines, whose places are known to such
# a part of 1/T, by the Cramér-Rao bound of the weakest that is found.
_HARMONICS, _LINE_ERROR = 4, 0.1
# What is slower than so many periods in the record is no waveform, of which each phase is averaged.
_OFTEN = 100
# A line takes noise to the rails with its own period, and that of its lowest harmonics.
_MULTIPLES = 3
# What a filter leaves of white noise where its spectrum is seen.
_FAINT = 1e-3
# Where most of what is white is [cycles per sample].
_WHITE = 0.25


def look_again(state: Investigation, seed: int) -> None:
    """Take back the names of what is something else, and say so; the model keeps its shape."""
    _only_courses_were_loud(state)
    if state.in_codes:
        return
    told = tell_apart(state)
    white = whitened_piece(state, state.longest, model_only=True)
    look_at_lines(state, white, told)
    pulsing = tell_pulses(state, seed)
    broad = _broad(state, white)
    _swing(state, _repeated(state, white, broad))
    _dead_band(state)
    _skewed(state)
    # Pulses have a spectrum of their own while they last.
    if not pulsing:
        _other_spectrum(state, broad)
    if "variance_modulation" not in state.disowned:
        count_out_filtered(state)
    bump_instead(state)


def _only_courses_were_loud(state: Investigation) -> None:
    """Take back louder times if the noise beside lines, resonances and steps lasts.

    Less of it would be left if what lines add were counted out twice; and loud times are found
    before the steps, of which a whitened record shows each as a jolt.
    """
    courses = {course.name for course in state.courses}
    narrow = any(narrow_groups(state)) or state.peaks
    if state.modulation is None or "vibration_rectification" in courses or state.vibration:
        return
    if not narrow and "step" not in courses:
        return
    pieces = [whitened_piece(state, each, model_only=True) for each in state.long_pieces]
    if uneven(np.concatenate([_broad(state, white) for white in pieces]))[0] < state.alarm:
        return
    if narrow:
        state.line_times = runs(state.flags(state.modulation.loud))
    forget_loud_times(state)


def _other_spectrum(state: Investigation, white: Float[np.ndarray, " samples"]) -> None:
    """Noise that changes in time, but not by white noise that comes and goes."""
    if not state.format.normal:
        # What rounding makes of noise depends on where the mean is.
        return
    if state.vibration is not None:
        _vibration(state)
        return
    powers = tiles(white)
    at = np.arange(powers.shape[1]) / TILE
    density = np.interp(at, state.left.frequency, state.variance)
    usable = ~within(at, _bands(state), 1 / TILE)
    passed = _passed(state, powers.shape[1])
    if passed is not None:
        # Of less a short spectrum shows what leaks there.
        usable &= passed > _FAINT
    found = reshaped(parts(powers), density, usable, passed)
    if state.modulation is not None:
        loud = shares(state.flags(state.modulation.loud)[slice(*state.longest)])
        found = reshaped_at_times(powers, loud, density, usable, passed) or found
    found = found or _corner_moves(state, powers)
    if found is None:
        return
    frequency, log_p = found
    state.disowned.add("variance_modulation")
    if not _far_below_corner(state, frequency):
        state.disowned.add("low_pass")
    if not any(finding.name in state.disowned for finding in state.findings):
        state.findings.append(Finding("bump", log_p, 0.0))
    why = "the shape of the spectrum changes in time, and not only its level"
    state.unknown.append(Unknown(frequency, 0.5, why, in_time=True))
    bump_for_filter(state)


def _vibration(state: Investigation) -> None:
    """Loud times whose noise has a spectrum of its own are no more of the sensor's noise."""
    if any(course.name == "vibration_rectification" for course in state.courses):
        return
    state.disowned.add("variance_modulation")
    why = "at times there is noise of a spectrum of its own beside the sensor's"
    times = tuple(runs(state.flags(state.vibration.times.loud)))
    middle, width, like = state.vibration.middle, state.vibration.width, "vibration does so"
    state.unknown.append(Unknown(middle, width, why, in_time=True, like=like, times=times))


def _passed(state: Investigation, frequencies: int) -> Float[np.ndarray, " frequencies"] | None:
    """What the filter of the model lets pass of white noise, from zero to half the rate, if any."""
    shaping = state.model.kinds.shaping
    if shaping is None or not state.model.kinds.filtering:
        return None
    gain, _ = _gain_and_slopes(state, shaping, _inside(frequencies))
    return np.pad(gain, 1, mode="edge")


def _seen(
    state: Investigation, frequency: Float[np.ndarray, " frequencies"]
) -> Bool[np.ndarray, " frequencies"]:
    """Whether noise is seen there [cycles per sample], behind a filter."""
    kept, passed = state.spectrum.clean(frequency), _passed(state, TILE // 2 + 1)
    if passed is not None:
        kept &= np.interp(frequency, np.arange(passed.size) / TILE, passed) > _FAINT
    return kept


def _inside(frequencies: int) -> Float[np.ndarray, " inside"]:
    """Those of a tile but zero and half the rate, which have no spectrum of their own."""
    return np.arange(1, frequencies - 1) / (2 * (frequencies - 1))


def _gain_and_slopes(
    state: Investigation, shaping: str, frequency: Float[np.ndarray, " inside"]
) -> tuple[Float[np.ndarray, " inside"], Float[np.ndarray, "inside three"]]:
    """Of the filter in the model, on white noise."""
    four, samples = state.model.theta[SHAPE], state.data.samples
    return filter_slopes(shaping, four, points(frequency), samples)


def _far_below_corner(state: Investigation, frequency: float) -> bool:
    """Whether what changes is well within the pass band, where a filter does nothing."""
    return state.model.kinds.filtering and frequency < _WITHIN * _corner(state)


def _corner(state: Investigation) -> float:
    """Of the filter in the model [cycles per sample]."""
    return _model.shaping_shape(state.model, state.data)[0]


def _corner_moves(
    state: Investigation, powers: Float[np.ndarray, "tiles frequencies"]
) -> tuple[float, float] | None:
    """Where a filter has its corner, if that moves; and the log of the chance that it seems so."""
    named, shaping = state.finding("low_pass"), state.model.kinds.shaping
    if named is None or shaping is None or named.gain <= 0:
        return None
    frequency = _inside(powers.shape[1])
    folded, slopes = _gain_and_slopes(state, shaping, frequency)
    # Louder noise may be the sensor's, which is filtered, or come in behind the filter.
    behind = None
    if state.modulation is not None:
        behind = 1 / np.interp(frequency, state.left.frequency, state.variance)
    gain, log_p = moved_along(powers[:, 1:-1], slopes / folded[:, None], behind)
    if log_p > np.log(_CORNER) or gain < _CORNER_SHARE * named.gain:
        return None
    return min(_corner(state), 0.5), log_p


def _repeated(
    state: Investigation,
    white: Float[np.ndarray, " samples"],
    broad: Float[np.ndarray, " samples"],
) -> Float[np.ndarray, " samples"]:
    """Name a waveform that repeats, of which more is left than its strongest harmonics.

    Returns what is broad without it: its pulses would look like noise that swings.
    """
    if not white.any() or not broad.any():
        return broad
    samples = white.size
    lines = [Line(course.shape["frequency"], _LINE_ERROR / samples) for course in state.lines]
    sought = [
        family.fundamental for family in families(lines, 0.5) if len(family.lines) >= _HARMONICS
    ]
    swing = swinging(np.clip(broad / broad.std(), -PULLED_IN, PULLED_IN))
    if swing is not None and swing[0] < samples / _OFTEN and swing[1] < np.log(state.alarm):
        sought.append(1 / swing[0])
    # Codes and held samples have patterns of their own.
    comb = strongest_comb(white, partial(_seen, state)) if state.format.normal else None
    if comb is not None and comb.log_p < np.log(state.alarm):
        sought.append(comb.frequency)
    for frequency in sought:
        found = waveform(white, frequency)
        if found.log_p < np.log(state.alarm):
            state.findings.append(Finding("bump", found.log_p, 0.0))
            state.gains["bump"] = found.held_out(white)
            why, like = (
                "a waveform repeats",
                "a clock's pulse, a radio or a logger's writing does so",
            )
            place = 1 / found.period
            state.unknown.append(Unknown(place, 1e-3, why, found.period, in_time=True, like=like))
            return found.taken_from(broad)
    return broad


def _swing(state: Investigation, white: Float[np.ndarray, " samples"]) -> None:
    """Name noise whose strength swings as something that is not in the catalogue."""
    if not state.format.normal:
        # Codes and held samples make squares of their own.
        return
    if not white.any():
        return
    if state.modulation is not None:
        white = white / state.deviation[slice(*state.longest)]
    # What loud times tell of already comes again at the harmonics of how often there are any.
    longest = np.inf if state.modulation is None else 2.0 * state.modulation.window
    # Where N has but a part of the spectrum, frequencies weighted by it tell how N swings.
    found = []
    for values in (white, weighted_by_n(state, white)):
        if values is None:
            continue
        size = white.size / values.size
        values = np.clip(values / values.std(), -PULLED_IN, PULLED_IN)
        each = swinging(values, longest / size)
        if each is not None:
            found.append((each[1], each[0] * size, size, values))
    if not found:
        return
    log_p, period, size, white = min(found, key=lambda one: one[0])
    if _cut_by_line(state, period):
        return
    log_p = min(log_p + np.log(len(found)), 0.0)
    state.witness(
        "swing of the noise",
        period,
        float(np.exp(log_p)),
        "The squares of the whitened record, scanned for a period.",
    )
    if log_p < np.log(state.alarm):
        if state.contamination is not None and state.contamination.fraction > USUAL:
            # Of normal noise whose strength swings, all samples together have long tails.
            state.disowned.add("outliers")
        state.findings.append(Finding("bump", log_p, 0.0))
        state.gains["bump"] = of_swing(white, period / size)
        why = "the strength of the noise swings"
        by_turns = "two converters that take turns do so"
        like = by_turns if period == 2 else "interpolation to another rate does so"
        state.unknown.append(Unknown(1 / period, 1e-3, why, period, in_time=True, like=like))


def _cut_by_line(state: Investigation, period: float) -> bool:
    """Whether noise is cut at a rail in each period of a line, which takes it there."""
    if not state.format.rails:
        return False
    multiples = np.arange(1, _MULTIPLES + 1)
    cycles = [multiples * course.shape["frequency"] for course in state.lines]
    apart = [np.abs(np.abs(each - np.round(each)) - 1 / period).min() for each in cycles]
    return bool(min(apart, default=np.inf) < 2 / state.spectrum.longest)


def _dead_band(state: Investigation) -> None:
    """Values near one of them that come out as it: beside the many alike others are long tails."""
    if state.format.dead < np.log(state.alarm):
        why = "values within a dead band come out as one, and take noise with them"
        like = "a threshold below which a rate counts as rest does so, and is to be switched off"
        _no_spikes(state, state.format.dead, why, like)


def _skewed(state: Investigation) -> None:
    """Noise that leans to one side has long tails there, and no spikes of their own."""
    if state.leans < np.log(state.alarm) and "outliers" not in state.disowned:
        why = "the noise leans to one side"
        like = "rectified noise or a curved characteristic does so"
        _no_spikes(state, state.leans, why, like)


def _no_spikes(state: Investigation, log_p: float, why: str, like: str) -> None:
    """Name what gives values long tails in place of outliers."""
    state.disowned.add("outliers")
    state.findings.append(Finding("bump", log_p, 0.0))
    if "outliers" in state.gains:
        state.gains["bump"] = state.gains["outliers"]
    state.unknown.append(Unknown(_WHITE, 0.5, why, in_time=True, bandless=True, like=like))


def _broad(
    state: Investigation, white: Float[np.ndarray, " samples"]
) -> Float[np.ndarray, " samples"]:
    """The white record without the bands of lines and resonances."""
    return without_bands(white, _bands(state))


def _bands(state: Investigation) -> list[tuple[float, float]]:
    """Middles and half-widths of lines and resonances [cycles per sample]."""
    # What is broad for its frequency has no band of its own, unless it moves through one.
    narrow = [
        (one.middle, 4 * one.width)
        for one in narrow_noises(state.model, float(state.data.samples))
        if one.width < one.middle / 8 or one.place in state.disowned_noises
    ]
    return narrow + [(peak.frequency, 4 * peak.half_width) for peak in state.peaks]
