"""Whether the noise of a channel lasts: loud times and knocks, and outliers beside them."""

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import dct, idct

from .._intervals import runs
from .._refit import rebin, refit
from .._state import Finding, Investigation, whitened_piece, whitened_pieces
from ..lines._lines import scan
from ..spectrum import _model
from ..spectrum._narrow import narrow_noises
from ..spectrum._ordinates import bin_edges, binned
from ..spectrum._whiten import HEARD, level, without_bands, without_ends
from ..values import _discrete
from ..values._alone import Others
from ..values._held_out import Gain, of_loud_times
from ..values._losses import beside_losses
from ..values._spikes import (
    height_of,
    name_clear_spikes,
    name_errors,
    name_spikes,
    put_back,
    take_out_spikes,
)
from ._bursts import bursts
from ._knocks import BRIEF_SHARE, as_modulation, knock, steps_instead, wrong_ends
from ._modulation import (
    PULLED_IN,
    Modulation,
    modulation,
    of_samples,
    two_levels,
)
from ._paths import KNOCK_RATIO, KNOCK_SHARE
from ._vibration import away_from_edges, take_out, vibration

# Sums of up to 2^(this - 1) samples, or weighted frequencies, where they tell so many times as much
# of N as all samples do. Frequencies above those that tell such a part are left.
_MOST_DOUBLINGS, _CLEARER, _TOLD = 8, 1.5, 0.99
# Short spectra of held or rounded values stand out by up to so many times as much by chance, by
# records of white noise held up to seven samples long, or rounded to five times its deviation. Held
# for less long on average, or rounded less coarsely, hardly, or not at all.
_LONGER_TAIL, _HARDLY_LONGER, _BRIEFLY, _FINE = 3.0, 1.25, 1.5, 1.5
# Standard deviations of its frequency within which a line that wanders stays.
_REACH = 5.0
# A quiet time must be as long for its own fit.
_SHORTEST_QUIET = 1024
# Of N at least such a part is there in quiet times.
_LEFT = 0.05
# A part of the variance that is left however quiet it is.
_WEAKEST = 1e-3


def about_spread(state: Investigation, seed: int, *, may_cut: bool = True) -> bool:
    """Outliers, loud times and knocks. Says whether the record has to be cut, if it may be."""
    at_the_ends = None if state.knocks else _at_the_ends(state)
    if at_the_ends is not None:
        knock(state, at_the_ends, whitened_pieces(state))
        return True
    _name_tall_spikes(state, seed)
    rough = whitened_piece(state, state.longest)
    notches = tuple(peak.frequency for peak in scan(rough, 1e-4))
    white = _white(state, notches)
    mean = level(state.left, state.variance)
    if state.format.normal:
        changing, heard = _modulation_of_n(state, white, seed)
    else:
        changing, heard = _discrete.change(state, white, height_of(mean), seed)
    state.witness(
        "variance in time",
        changing.ratio,
        changing.p_value,
        "Windowed variances of the whitened record, compared"
        + ("." if state.format.normal else "; coarse codes and held samples change by themselves."),
    )
    loud = changing.p_value < state.alarm and changing.loud.any() and not changing.loud.all()
    loud = loud and state.vibration is None and not _cut_while_quiet(state, changing)
    if loud and may_cut:
        share = changing.loud.mean()
        if share < KNOCK_SHARE and steps_instead(state, changing):
            return about_spread(state, seed, may_cut=may_cut)
        if share < KNOCK_SHARE and changing.ratio > KNOCK_RATIO:
            knock(state, changing, white)
            return True
    vibrating = vibration(state, white, mean, changing) if loud and state.format.normal else None
    if vibrating is not None:
        take_out(state, *vibrating)
        _name_loud_times(state, vibrating[0].times, of_loud_times(heard, seed))
        mean = level(state.left, state.variance)
        even = _white(state, notches)
    else:
        even = _evened(white, changing) if loud else white
    knocked = _knocked(state, white, even)
    if knocked is not None and may_cut:
        if steps_instead(state, knocked):
            return about_spread(state, seed, may_cut=may_cut)
        knock(state, knocked, white)
        if state.vibration is not None:
            # The knock passed for quiet noise: vibration is found again without it.
            state.values, state.vibration = state.vibration.recorded, None
        return True
    if loud and vibrating is None:
        changing = changing.sharp()
        count_out(state, changing)
        _name_loud_times(state, changing, of_loud_times(heard, seed))
    if state.format.normal:
        quiet = ~changing.loud if loud else None
        name_spikes(state, even, mean, height_of(mean), seed, quiet)
    else:
        name_clear_spikes(state, even, height_of(mean), seed)
    if loud or state.contamination is not None:
        refit(state)
    return False


def _name_tall_spikes(state: Investigation, seed: int) -> None:
    """Name spikes that hide the rest, by what is made white without them."""
    recorded = state.values
    tall, errors = take_out_spikes(state)
    if not tall.any():
        return
    mean = level(state.left, state.variance)
    even, others = _white(state, ()), Others(state)
    if others.silent:
        even[tall] = errors * height_of(mean)
        name_spikes(state, even, mean, height_of(mean), seed)
    else:
        even[tall] = errors * others.height
        name_errors(state, even, mean, others, errors, seed)
    if state.contamination is None:
        put_back(state, recorded)
    refit(state)


def _knocked(
    state: Investigation,
    white: Float[np.ndarray, " looked_at"],
    even: Float[np.ndarray, " looked_at"],
) -> Modulation | None:
    """Times in which short spectra of `even` noise stand out, if they do and are brief."""
    brief = bursts(np.clip(even, -PULLED_IN, PULLED_IN), _tail(state))
    state.witness(
        "bursts",
        brief.ratio,
        float(np.exp(brief.log_p)),
        "Short spectra of the whitened record, scanned for tiles that stand out.",
    )
    apart = away_from_edges(state, brief.loud)
    unlikely = brief.log_p < np.log(state.alarm) and apart.any()
    hidden = not state.format.normal and _discrete.codes_over_noise(state) > _discrete.BRIEF
    if not unlikely or hidden or brief.loud.mean() >= BRIEF_SHARE:
        return None
    return as_modulation(white, brief._replace(loud=apart))


def seen_beside_lines(state: Investigation) -> Bool[np.ndarray, " samples"] | None:
    """Which samples are brief disturbances beside the bands of lines that wander, if there are any.

    Such a line is at one frequency at a time. Where it seldom is its mean spectrum is low, and it
    stands out of that when it comes there.
    """
    lines = narrow_noises(state.model, float(state.data.samples))
    bands = [(each.middle, _REACH * each.width) for each in lines if each.name == "drifting_line"]
    if not bands or _at_the_ends(state) is not None:
        return None
    beside = []
    for piece in state.long_pieces:
        white = whitened_piece(state, piece, model_only=True)
        beside.append(without_bands(white, bands))
    brief = bursts(np.clip(np.concatenate(beside), -PULLED_IN, PULLED_IN), _tail(state))
    return state.flags(brief.loud & bool(brief.log_p < np.log(state.alarm)))


def _tail(state: Investigation) -> float:
    """How many times as strong as those of normal noise short spectra are by chance."""
    repeat = state.format.repeat
    if state.format.normal:
        return 1.0
    if _discrete.codes_over_noise(state) > _FINE or (repeat and repeat.samples > _BRIEFLY):
        return _LONGER_TAIL
    return 1.0 if repeat is None else _HARDLY_LONGER


def _evened(
    white: Float[np.ndarray, " samples"], changing: Modulation
) -> Float[np.ndarray, " samples"]:
    """As strong at loud times as at quiet ones, but for spikes."""
    loud = changing.loud
    if changing.strength is not None:
        even = white / changing.strength
    else:
        even = np.where(loud, white / white[loud].std(), white / white[~loud].std())
        # Where they begin and end is known to a window: what is strong there is no spike.
        for edge in np.flatnonzero(np.diff(loud)) + 1:
            near = even[max(edge - changing.window, 0) : edge + changing.window]
            near /= max(1.0, 1.4826 * float(np.median(np.abs(near))))
    return even / np.std(np.clip(even, -PULLED_IN, PULLED_IN))


def _at_the_ends(state: Investigation) -> Modulation | None:
    """Samples at the ends of stretches that are wrong."""
    found = [(piece, wrong_ends(state.values[slice(*piece)])) for piece in state.long_pieces]
    wrong = [(piece, ends) for piece, ends in found if ends is not None]
    if not wrong:
        return None
    loud = np.zeros(state.values.size, bool)
    for piece, ends in wrong:
        loud[slice(*piece)] = ends.loud
    worst = max((ends for _, ends in wrong), key=lambda ends: ends.ratio)
    return worst._replace(loud=loud[state.looked_at])


def _cut_while_quiet(state: Investigation, changing: Modulation) -> bool:
    """Whether more samples stand at the rails in quiet times: these are quiet since they are cut.

    Noise that is stronger at times reaches its rails more often then.
    """
    cut = np.isin(state.values[state.looked_at], state.format.rails)
    return bool(np.mean(cut[~changing.loud]) > np.mean(cut[changing.loud]))


def _name_loud_times(state: Investigation, changing: Modulation, gain: Gain) -> None:
    log_p = float(np.log(max(changing.p_value, 1e-300)))
    state.modulation = changing
    state.findings.append(Finding("variance_modulation", log_p, 0.0, detail=changing))
    state.gains["variance_modulation"] = gain


def move_loud_times(state: Investigation, changing: Modulation) -> None:
    """Loud times that are known better now."""
    state.modulation = changing
    named = state.finding("variance_modulation")
    if named is not None:
        named.detail = changing


def count_out(state: Investigation, changing: Modulation) -> None:
    """Count white variance out of N that only loud times have, in place of what was before."""
    white = float(np.exp(state.model.theta[1]))
    added = min(_loud_variance(state, changing), (1 - _LEFT) * white)
    # As loud as it gets, in all of the spectrum or in the white part of it.
    share = float(changing.loud.mean())
    quiet = max(white - added, 1e-300)
    louder = max(changing.ratio**2 - 1, _WEAKEST)
    part = max(1.0, added / share / quiet / louder)
    strength = np.maximum(1 + part * (changing.deviation() ** 2 - 1), _WEAKEST)
    dilution = float(np.mean(strength**2) / np.mean(strength) ** 2)
    state.spectrum = state.spectrum._replace(dilution=dilution)
    state.foreign += added - state.loud_variance
    state.loud_variance = added
    rebin(state)


def count_out_filtered(state: Investigation) -> None:
    """The same behind a filter, which was not known before.

    What passes it as N does is taken off N in the end, and stays in the spectrum until then.
    """
    if state.modulation is None or state.vibration is not None or state.loud_variance > 0:
        return
    if state.model.kinds.filtering:
        part = _loud_variance(state, state.modulation) / float(np.exp(state.model.theta[1]))
        state.loud_part = min(part, 1 - _LEFT)


def _modulation_of_n(
    state: Investigation, white: Float[np.ndarray, " samples"], seed: int
) -> tuple[Modulation, Float[np.ndarray, " values"]]:
    """When the noise is loud, and the white values that tell.

    Where N has but a part of the spectrum it changes unheard among all samples. It is heard best
    with each frequency weighted by that part. How much louder it gets is told by sums of so many
    samples that N rules below their Nyquist frequency, which are independent as well.
    """
    found = modulation(white, seed)
    weighted = weighted_by_n(state, white)
    if weighted is None:
        return found, white
    best = modulation(weighted, seed)
    p_value = min(2 * found.p_value, 2 * best.p_value, 1.0)
    size = samples_of_n(state)
    sums = summed(white, size)
    slow = modulation(sums, seed)
    if slow.strength is None and best.loud.any():
        places = np.arange(sums.size) * best.loud.size // sums.size
        window = -(-best.window * sums.size // best.loud.size)
        slow = two_levels(sums, best.loud[places], window, seed)
    # The less likely one says when it is loud, unless it cannot.
    if (found.loud.any(), -found.p_value) >= (slow.loud.any(), -best.p_value):
        return found._replace(p_value=p_value), white
    found = slow.of(of_samples(np.arange(sums.size), size, white.size))
    odds = None if found.odds is None else found.odds / size
    found = found._replace(window=slow.window * size, p_value=p_value, odds=odds, summed=size)
    return found, sums


def _share_of_n(state: Investigation) -> Float[np.ndarray, " frequencies"]:
    """The part of the noise that is N, at the frequencies of what is left."""
    return np.minimum(2 * np.exp(state.model.theta[1]) / state.variance, 1.0)


def weighted_by_n(
    state: Investigation, white: Float[np.ndarray, " samples"]
) -> Float[np.ndarray, " values"] | None:
    """Noise of which each frequency has a power that is the part of N, where that tells more of N.

    The log-likelihood of a slightly larger N is, but for a constant, that of these squares times
    half of how much larger it is. Above the frequencies that tell there is nothing, and as many
    samples fewer.
    """
    share = _share_of_n(state)
    if not white.any() or np.mean(share**2) <= _CLEARER * np.mean(share) ** 2:
        return None
    cosines = np.asarray(dct(np.clip(white, -PULLED_IN, PULLED_IN), norm="ortho"))
    at = np.arange(white.size) / (2 * white.size)
    share = np.interp(at, state.left.frequency, share)
    told = np.cumsum(share**2)
    kept = int(np.searchsorted(told, _TOLD * told[-1])) + 1
    values = np.asarray(idct((cosines * np.sqrt(share))[:kept], norm="ortho"))
    return values / max(float(values.std()), 1e-300)


def samples_of_n(state: Investigation) -> int:
    """As many samples together tell most of N: the square of its share in them, for each sample."""
    share = _share_of_n(state)
    sizes = 2 ** np.arange(_MOST_DOUBLINGS)
    sizes = sizes[0.5 / sizes >= state.left.frequency[0]]
    told = [np.mean(share[state.left.frequency <= 0.5 / size]) ** 2 / size for size in sizes]
    return int(sizes[np.argmax(told)]) if max(told) > _CLEARER * told[0] else 1


def summed(white: Float[np.ndarray, " samples"], size: int) -> Float[np.ndarray, " sums"]:
    """Sums of `size` samples each, as strong as these."""
    return white[: white.size // size * size].reshape(-1, size).sum(axis=1) / np.sqrt(size)


def forget_loud_times(state: Investigation) -> None:
    """Take them back: what was stronger then is not the noise."""
    state.modulation = None
    state.foreign -= state.loud_variance
    state.loud_variance = state.loud_part = 0.0
    state.spectrum = state.spectrum._replace(dilution=1.0)
    state.findings = [each for each in state.findings if each.name != "variance_modulation"]
    state.gains.pop("variance_modulation", None)
    rebin(state)
    refit(state)


def _white(state: Investigation, notches: tuple[float, ...]) -> Float[np.ndarray, " looked_at"]:
    """What is asked whether it lasts."""
    # What comes in place of wrong samples behind a filter may be off by more than the little that
    # it leaves.
    mended = state.contamination is not None and not Others(state).silent
    share = HEARD if mended else 1.0
    white = [
        without_ends(whitened_piece(state, piece, notches, share=share))
        for piece in state.long_pieces
    ]
    return np.concatenate(white) / beside_losses(state)


def _loud_variance(state: Investigation, changing: Modulation) -> float:
    """White variance that loud times add to the mean of all [u^2].

    The quiet times alone, as stretches of a record of their own, have an N of their own.
    """
    calm = ~state.flags(changing.loud)
    quiet = tuple(
        state.values[start + a : start + b]
        for start, stop in state.long_pieces
        for a, b in runs(calm[start:stop])
        if b - a >= _SHORTEST_QUIET
    )
    if not quiet:
        return 0.0
    spectrum = state.ordinates_of(*quiet)
    bins = binned(spectrum, bin_edges(spectrum.longest))
    data = state.data._replace(bins=bins, samples=float(spectrum.longest))
    kinds, theta = state.model.kinds, state.model.theta
    if kinds.filtering:
        # The same filter is before them.
        alone = _model.best([(kinds, theta)], data)[0]
    else:
        alone = _model.five_terms(np.exp(theta[:4]), data)
    # Behind a filter that is not known yet five terms know no N, and loud times add nothing to it.
    return max(float(np.exp(state.model.theta[1]) - np.exp(alone.theta[1])), 0.0)


def loudness(state: Investigation, changing: Modulation) -> Float[np.ndarray, "samples columns"]:
    """Local variance of the fast noise [u^2], centred: what may rectify."""
    if state.vibration is not None:
        course = state.vibration.course if changing.strength is not None else changing.loud
        added = state.vibration.variance * course
    else:
        power = changing.deviation() ** 2
        added = (power - 1) / power.mean()
        # Whitened, white noise of one u^2 is as strong as this on average over the frequencies, as
        # far as sums hear them (Fejer's kernel).
        turn, size = np.pi * state.left.frequency, changing.summed
        heard = np.sin(size * turn) ** 2 / (size * np.sin(turn) ** 2)
        added /= float(np.mean(heard * 2 / state.variance))
    column = np.zeros(state.values.size)
    column[state.looked_at] = added
    return (column - column[state.looked_at].mean())[:, None]
