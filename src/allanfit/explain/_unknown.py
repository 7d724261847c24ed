"""What is there but is no effect of the catalogue, though one may describe it best.

Each cause outside the catalogue that engineers meet has a name nearest to it: a sweep looks like a
drifting line, a line in bursts like many lines, a filter that changes like noise that changes. The
name is right only if what else it says is so too.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import chi2, gamma

from . import _search
from ._chance import score
from ._held_out_values import of_swing
from ._moving import Band, moving
from ._search import Candidate, Model
from ._spread import PULLED_IN
from ._state import Finding, Investigation, whitened_piece
from ._structure import EACH, NARROW, added_density, shape_of

# Twice the log of the prior odds that a cause is in the catalogue: nineteen of twenty are.
_INSIDE = 2 * float(np.log(19))
# A band's share of the power is told at so many frequencies.
_SHARES = 512
# A pulse is looked for from so many periods on, and must be as unlikely.
_TEETH_SOUGHT, _PULSED, _DEPTH = 8, 1e-5, 0.7
# Lines of one comb lie as close, and there are as many.
_CLOSE = 0.05
_FEWEST_TEETH = 3
_FINE = 0.1
# A swing to and fro turns at sqrt(2) times its rms.
_TURN = 1.6
# A swing of the noise is looked for between so many periods and so few samples a period.
_FEWEST_SWINGS, _FEWEST_SAMPLES = 100, 8
_TILE = 256
_BANDS = 12
# A spectrum is watched in so many parts of the record.
_PARTS = 24
# A changing spectrum must be as unlikely under a change of white noise.
_RESHAPED = 1e-6
# And as large beside the quiet spectrum: of no sensor does the noise keep its shape exactly.
_PLAIN = 0.1
_FULL = 0.5


class Unknown(NamedTuple):
    """Something without a name: where, how large, and why what describes it best is not it."""

    #: The middle [cycles per sample] and the width in e-folds.
    frequency: float
    width: float
    why: str
    #: Its period [samples], if it has one.
    period: float = 0.0
    #: Whether it shows in time alone.
    in_time: bool = False


def look_again(state: Investigation) -> None:
    """Take back the names of what is something else, and say so; the model keeps its shape."""
    white = whitened_piece(state, state.longest, model_only=True)
    broad = _broad(state, white)
    _swing(state, broad)
    _combs(state)
    _sweeps(state, white)
    _turns(state)
    _other_spectrum(state, broad)
    _bump_instead(state)


def _combs(state: Investigation) -> None:
    """Lines at equal distances within a narrow band: one line that comes and goes."""
    lines = sorted(course.shape["frequency"] for course in state.lines)
    group: list[float] = []
    for line in [*lines, np.inf]:
        if group and line > group[0] * (1 + _CLOSE):
            if len(group) >= _FEWEST_TEETH and _even(group, state.spectrum.longest):
                _comb(state, group)
            group = []
        group.append(line)


def _even(lines: list[float], samples: int) -> bool:
    gaps = np.diff(lines)
    multiples = gaps / gaps.min()
    # Each line is known to a fraction of 1/T, and so is their distance; closer ones fit any comb.
    slack = 0.7 / samples / gaps.min() * multiples
    return bool(np.all(np.abs(multiples - np.round(multiples)) < slack) and slack.min() < _FINE)


def _comb(state: Investigation, lines: list[float]) -> None:
    middle, gap = float(np.mean(lines)), float(np.diff(lines).min())
    width = float(np.log(lines[-1] / lines[0])) / 2
    state.disowned_lines += lines
    why = f"{len(lines)} lines at equal distances are one line that comes and goes"
    state.unknown.append(Unknown(middle, max(width, 1e-6), why, 1 / gap))


class _Narrow(NamedTuple):
    """One line or resonance of the model, with its free parameters."""

    name: str
    #: Which of the model's added noises it is.
    place: int
    three: Float[np.ndarray, " three"]
    middle: float
    width: float


def _narrow(state: Investigation) -> list[list[_Narrow]]:
    """Lines and resonances in groups whose bands meet: several may describe one cause."""
    kinds, samples = state.model.kinds, float(state.data.samples)
    found = []
    for place, name in enumerate(kinds.added):
        if name in NARROW:
            begin = kinds.first_slot + EACH * place
            three = state.model.theta[begin : begin + EACH]
            first, second = (float(each) for each in shape_of(name, three, samples))
            width = first * second if name == "drifting_line" else first / second
            found.append(_Narrow(name, place, three, first, width))
    groups: list[list[_Narrow]] = []
    for one in sorted(found, key=lambda each: each.middle):
        last = groups[-1][-1] if groups else None
        if last is not None and one.middle - last.middle < 2 * (one.width + last.width):
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def _sweeps(state: Investigation, white: Float[np.ndarray, " samples"]) -> None:
    """Lines that move through their band, or come and go."""
    for group in _narrow(state):
        main = max(group, key=lambda each: each.width)
        band = _band_of(state, group)
        path = moving(white, band)
        if path is not None and path.log_p > np.log(state.alarm):
            path = None
        why, period = "", 0.0
        if path is not None and path.even:
            why = "a line that sweeps through the band in the course of the recording"
        elif period := _pulse(white, band):
            why = "a line that comes and goes"
        elif path is not None:
            # Whatever its shape, a resonance it is not.
            state.wandering |= {each.place for each in group}
        if why:
            state.disowned |= {each.name for each in group}
            width = max(main.width / main.middle, 1e-6)
            state.unknown.append(Unknown(main.middle, width, why, period))


def _band_of(state: Investigation, group: list[_Narrow]) -> Band:
    """Three widths to either side of a group, and its share of the power there."""
    low = max(min(each.middle - 3 * each.width for each in group), 1 / float(state.data.samples))
    high = min(max(each.middle + 3 * each.width for each in group), 0.5)
    at, samples = np.linspace(low, high, _SHARES), float(state.data.samples)
    nodes = np.stack([at] * 3, axis=1)
    own = [np.asarray(added_density(each.name, each.three, nodes, samples)) for each in group]
    total = np.interp(at, state.left.frequency, state.variance)
    return Band(low, high, at, np.minimum(np.sum(own, axis=0) / total, 1.0))


def _turns(state: Investigation) -> None:
    """A line that wanders to and fro dwells where it turns, and looks like a sinusoid there."""
    if "drifting_line" in state.disowned:
        return
    wandering = [one for group in _narrow(state) for one in group if one.name == "drifting_line"]
    lines = [course.shape["frequency"] for course in state.lines]
    state.disowned_lines += [
        line
        for line in lines
        if any(abs(line - one.middle) < _TURN * one.width for one in wandering)
    ]


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
        tried = tried[tried * count < high - 1]
        if not tried.size:
            continue
        order = np.round(np.arange(1, count + 1)[:, None] * tried).astype(int)
        together = ratio[order].sum(axis=0)
        at = int(np.argmax(together))
        chance = gamma.logsf(together[at], count) + np.log(3 * tried.size)
        if chance < log_p:
            log_p, beat, size = float(chance), tried[at], float(np.mean(beats[order[:, at]]))
    # How deep: bursts leave nothing between them, and other swings of a line are no bursts.
    at_ordinates = np.arange(first, last) / white.size
    share = float(np.mean(np.interp(at_ordinates, band.frequency, band.share)))
    depth = 2 * np.sqrt(size) / max(np.sum(power) * share, 1e-300)
    if log_p > np.log(_PULSED) or depth < _DEPTH:
        return 0.0
    return white.size / beat


def _other_spectrum(state: Investigation, white: Float[np.ndarray, " samples"]) -> None:
    """Noise that changes in time, but not by white noise that comes and goes."""
    if state.format.coarse or state.format.repeat is not None:
        # What rounding makes of noise depends on where the mean is.
        return
    tiles = white.size // _TILE
    powers = np.abs(np.fft.rfft(white[: tiles * _TILE].reshape(tiles, _TILE))) ** 2 / _TILE
    parts = min(_PARTS, tiles // _BANDS)
    part = np.arange(tiles) * parts // max(tiles, 1)
    made_white = state.left.frequency, state.variance
    found = _reshaped([powers[part == each] for each in range(parts)], *made_white)
    if state.modulation is not None:
        share = state.modulation.loud[: tiles * _TILE].reshape(tiles, _TILE).mean(axis=1)
        found = _reshaped([powers[share > 0.99], powers[share < 0.01]], *made_white) or found
    if found is None:
        return
    frequency, log_p = found
    state.disowned |= {"variance_modulation", "low_pass"}
    if not any(finding.name in state.disowned for finding in state.findings):
        state.findings.append(Finding("bump", log_p, 0.0))
    why = "the shape of the spectrum changes in time, and not only its level"
    state.unknown.append(Unknown(frequency, 0.5, why, in_time=True))


def _reshaped(
    groups: list[Float[np.ndarray, "_ frequencies"]],
    frequency: Float[np.ndarray, " ordinates"],
    variance_there: Float[np.ndarray, " ordinates"],
) -> tuple[float, float] | None:
    """Where spectra of parts of a record differ most in shape, and the log of its chance.

    `groups` are powers of tiles of the white record, and the others what it was made white with.
    """
    if len(groups) < 2 or min(len(group) for group in groups) < _BANDS:
        return None
    edges = np.unique(np.geomspace(1, _TILE // 2, _BANDS + 1).round().astype(int))
    count, low = np.diff(edges), edges[:-1]
    banded = [np.add.reduceat(group, edges, axis=1)[:, :-1] / count for group in groups]
    mean = np.stack([each.mean(axis=0) for each in banded])
    variance = np.stack([each.var(axis=0, ddof=1) / len(each) for each in banded])
    # Bands that lines were cut out of are no measure.
    kept = np.min(mean, axis=0) > _FULL
    if kept.sum() < 4:
        return None
    mean, variance, count, low = mean[:, kept], variance[:, kept], count[kept], low[kept]
    middle = np.sqrt(low * (low + count - 1)) / _TILE
    usual = np.average(mean, axis=0, weights=[len(group) for group in groups])
    # Whitened by their mean, white noise that is added weighs as one over the density there.
    weight = 1 / np.interp(middle, frequency, variance_there)
    difference = mean - usual
    variance = np.maximum(variance, mean**2 / count / np.array([[len(g)] for g in groups]))
    added = np.sum(difference * weight / variance, axis=1) / np.sum(weight**2 / variance, axis=1)
    rest = difference - added[:, None] * weight
    misfit = float(np.sum(rest**2 / variance))
    freedom = (len(groups) - 1) * (count.size - 1)
    size = np.sqrt(max(np.mean((rest / mean) ** 2) - np.mean(variance / mean**2), 0.0))
    log_p = float(chi2.logsf(misfit, freedom))
    if log_p > np.log(_RESHAPED) or size < _PLAIN:
        return None
    return float(middle[int(np.argmax(np.sum(rest**2 / variance, axis=0)))]), log_p


def _bump_instead(state: Investigation) -> None:
    """Whether a smooth bump describes the spectrum better than all that was named in it."""
    kinds = state.model.kinds
    if not kinds.names or kinds.shaping == "bump":
        return
    if state.disowned & set(kinds.names):
        return
    bare = Model(kinds._replace(shaping=None, added=()), state.model.theta[:4], np.inf)
    bare = _search.best([(bare.kinds, bare.theta)], state.data)[0]
    found = _search.bumps(bare, state.data)
    if not found:
        return
    bump = found[0]
    named = sum(score(name, 0.0) for name in kinds.names) + bare.deviance - state.model.deviance
    named += sum(
        _search.rarity(state.model, state.data, place)
        for place in range(len(kinds.added))
        if place not in state.wandering
    )
    rival = score("bump", bump.gain) - _INSIDE
    for finding in state.findings:
        if finding.name in kinds.names and finding.rivals:
            own = finding.rivals.get(finding.name, 0.0)
            finding.rivals["bump"] = own + rival - named
    if rival > named:
        state.findings = [f for f in state.findings if f.name not in kinds.names]
        state.unexplained = Candidate("bump", bump.model, bump.gain)
        state.model = bump.model


def swinging(white: Float[np.ndarray, " samples"]) -> tuple[float, float] | None:
    """Period [samples] and log chance of noise whose strength swings, too fast for `_spread`.

    The squares of a white record are white; a periodic strength is a line among them.
    """
    squares = white**2 - np.mean(white**2)
    power = np.abs(np.fft.rfft(squares)) ** 2 / np.sum(squares**2)
    usable = np.zeros(power.size, bool)
    usable[_FEWEST_SWINGS : power.size * 2 // _FEWEST_SAMPLES] = True
    if usable.sum() < _TILE:
        return None
    # A strong resonance makes the squares uneven: each stretch of them by its own median.
    block = _TILE
    starts = np.arange(0, power.size, block)
    own = np.array([np.median(power[a : a + block]) for a in starts]) / np.log(2)
    power = power / np.maximum(np.repeat(own, block)[: power.size], 1.0)
    at = int(np.argmax(np.where(usable, power, 0.0)))
    log_p = float(min(0.0, np.log(usable.sum()) - power[at]))
    return white.size / at, log_p


def _swing(state: Investigation, white: Float[np.ndarray, " samples"]) -> None:
    """Name noise whose strength swings as something that is not in the catalogue."""
    if state.format.coarse or state.format.repeat is not None:
        # Codes and held samples make squares of their own.
        return
    if not white.any():
        return
    if state.modulation is not None:
        white = white / np.where(state.modulation.loud, state.modulation.ratio, 1.0)
    white = np.clip(white / white.std(), -PULLED_IN, PULLED_IN)
    found = swinging(white)
    if found is None:
        return
    period, log_p = found
    state.witnesses.append(
        {
            "name": "swing of the noise",
            "statistic": period,
            "p_value": float(np.exp(log_p)),
            "sentence": "The squares of the whitened record, scanned for a period.",
        }
    )
    if log_p < np.log(state.alarm):
        state.findings.append(Finding("bump", log_p, 0.0))
        state.gains["bump"] = of_swing(white, period)
        why = "the strength of the noise swings"
        state.unknown.append(Unknown(1 / period, 1e-3, why, period, in_time=True))


def _broad(
    state: Investigation, white: Float[np.ndarray, " samples"]
) -> Float[np.ndarray, " samples"]:
    """The white record without the bands of lines and resonances."""
    spectrum = np.fft.rfft(white)
    frequency = np.fft.rfftfreq(white.size)
    for one in (each for group in _narrow(state) for each in group):
        # What is broad for its frequency has no band of its own.
        if one.width < one.middle / 8:
            spectrum[np.abs(frequency - one.middle) < 4 * one.width] = 0.0
    for peak in state.peaks:
        spectrum[np.abs(frequency - peak.frequency) < 4 * peak.half_width] = 0.0
    return np.fft.irfft(spectrum, white.size)
