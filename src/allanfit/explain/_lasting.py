"""Whether the noise of a channel is normal and lasts: outliers, loud times, knocks."""

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import irfft

from . import _means, _search
from ._bursts import Burst, bursts
from ._held_out_values import of_loud_times, of_spikes, of_times
from ._intervals import runs, widened
from ._lines import scan
from ._ordinates import amplitudes, bin_edges, binned, ordinates
from ._spread import PULLED_IN, Contamination, Modulation, contamination, modulation
from ._state import (
    Finding,
    Investigation,
    add_course,
    evidence,
    rebin,
    refit,
    whitened_piece,
    with_course,
)
from ._whiten import level

# Loud for less of the record, and by more, is a knock and no change of the noise.
_KNOCK_SHARE, _KNOCK_RATIO = 0.15, 2.0
_MARGIN = 2
# Sums of up to 2^(this - 1) samples, where they tell so many times as much of N as all samples do.
_MOST_DOUBLINGS, _CLEARER = 8, 1.5
# Brief disturbances that fill more than this are no brief ones, but noise that changes.
_BRIEF_SHARE = 0.02
_MOST_STEPS = 8
# Spikes more frequent than this are what the noise is like: cut out, they would take its spectrum
# with them.
_RARE = 0.05
# And where so many samples have them, they are the noise itself, which has long tails.
USUAL = 0.08
# Such noise is told from a strong effect that is not normal by this gain over a normal one.
_LONG_TAILED = 60.0
# As far as a scan for a step in white noise goes.
_STEP_PATH = 100.0
# Samples of the whitening kernel, and nearly the half-width of a uniform distribution.
_KERNEL = 4096
_WIDEST = 1.65
# Samples at the ends of a record in which what leaks there is told.
_END = 32
# A sample at either end is compared with so many neighbours, as are others at so many places; up to
# so many samples are wrong if they are several times as far from them as nearly all others are.
_NEIGHBOURS, _END_PLACES, _MOST_WRONG = 32, 2000, 4
_NEARLY_ALL, _FAR_OUT = 0.99, 5.0
# A quiet time must be as long for its own fit.
_SHORTEST_QUIET = 1024


def about_spread(state: Investigation, seed: int) -> bool:
    """Outliers, loud times and knocks. Says whether the record has to be cut."""
    if not state.format.normal:
        # Discrete or held samples are not normal, and their whitened record is not either.
        return False
    piece = state.longest
    wrong_ends = None if state.knocks else _wrong_ends(state.values[piece[0] : piece[1]])
    if wrong_ends is not None:
        _knock(state, piece, wrong_ends, whitened_piece(state, piece), seed)
        return True
    rough = whitened_piece(state, piece)
    notches = tuple(peak.frequency for peak in scan(rough, 1e-4))
    white = _without_ends(whitened_piece(state, piece, notches))
    changing, heard = _modulation_of_n(state, white, seed)
    state.witness(
        "variance in time",
        changing.ratio,
        changing.p_value,
        "Windowed variances of the whitened record, compared.",
    )
    loud = changing.p_value < state.alarm and changing.loud.any() and not changing.loud.all()
    loud = loud and not _cut_while_quiet(state, piece, changing)
    if loud and not state.knocks:
        share = changing.loud.mean()
        if share < _KNOCK_SHARE and _steps_instead(state, piece, changing):
            return about_spread(state, seed)
        if share < _KNOCK_SHARE and changing.ratio > _KNOCK_RATIO:
            _knock(state, piece, changing, white, seed)
            return True
    if loud:
        state.modulation = changing
        even = white / np.where(changing.loud, white[changing.loud].std(), 1.0)
        even[~changing.loud] /= white[~changing.loud].std()
        even = even / np.std(np.clip(even, -PULLED_IN, PULLED_IN))
    else:
        even = white
    brief = bursts(np.clip(even, -PULLED_IN, PULLED_IN))
    state.witness(
        "bursts",
        brief.ratio,
        float(np.exp(brief.log_p)),
        "Short spectra of the whitened record, scanned for tiles that stand out.",
    )
    if brief.log_p < np.log(state.alarm) and not state.knocks and brief.loud.mean() < _BRIEF_SHARE:
        knocked = _as_modulation(white, brief)
        if _steps_instead(state, piece, knocked):
            return about_spread(state, seed)
        _knock(state, piece, knocked, white, seed)
        return True
    mean = level(state.left, state.variance)
    box = _uniform_part(state, mean)
    spiky = contamination(even, seed, box)
    state.witness(
        "outliers",
        spiky.gain,
        spiky.p_value,
        "Two normal distributions against one, on the whitened record.",
    )
    # How tall a spike of one unit is in the whitened record.
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
        state.loud_variance = added
        state.findings.append(
            Finding("variance_modulation", np.log(max(changing.p_value, 1e-300)), 0.0, {}, changing)
        )
        state.gains["variance_modulation"] = of_loud_times(heard, seed)
        rebin(state)
    spikes = spiky.p_value < state.alarm and spiky.amplitude > 1.5 * spiky.sigma
    # A mixture of two shapes of one width has short tails.
    tails = spiky.fraction > USUAL and spiky.amplitude > spiky.sigma / 2
    if spikes or (tails and spiky.gain > _LONG_TAILED):
        state.contamination = _in_units(spiky, height)
        state.findings.append(
            Finding(
                "outliers",
                np.log(max(spiky.p_value, 1e-300)),
                spiky.gain,
                {},
                state.contamination,
            )
        )
        state.gains["outliers"] = of_spikes(even, box, seed)
        clear = np.abs(even) > spiky.threshold
        if spiky.fraction > USUAL:
            wrong = 0.0
        elif clear.mean() < _RARE:
            _excise(state, piece, clear, mean, seed)
            wrong = float(np.mean(even[~clear] ** 2)) - spiky.sigma**2
        else:
            wrong = float(np.var(even)) - spiky.sigma**2
        state.foreign += max(wrong, 0.0) / height**2
    if loud or state.contamination is not None:
        refit(state)
    return False


def _cut_while_quiet(state: Investigation, piece: tuple[int, int], changing: Modulation) -> bool:
    """Whether more samples stand at the rails in quiet times: these are quiet since they are cut.

    Noise that is stronger at times reaches its rails more often then.
    """
    cut = np.isin(state.values[piece[0] : piece[1]], state.format.rails)
    return bool(np.mean(cut[~changing.loud]) > np.mean(cut[changing.loud]))


def _modulation_of_n(
    state: Investigation, white: Float[np.ndarray, " samples"], seed: int
) -> tuple[Modulation, Float[np.ndarray, " values"]]:
    """When the noise is loud, and the white values that tell.

    Where quantization rules high frequencies, N changes unheard among all samples. Sums of so many
    that N rules below their Nyquist frequency are independent as well, and tell of it.
    """
    found = modulation(white, seed)
    size = _samples_of_n(state)
    if size == 1:
        return found, white
    sums = white[: white.size // size * size].reshape(-1, size).sum(axis=1) / np.sqrt(size)
    slow = modulation(sums, seed)
    p_value = min(2 * found.p_value, 2 * slow.p_value, 1.0)
    # The less likely one says when it is loud, unless it cannot.
    if (found.loud.any(), -found.p_value) >= (slow.loud.any(), -slow.p_value):
        return found._replace(p_value=p_value), white
    loud = np.repeat(slow.loud, size)
    loud = np.append(loud, np.full(white.size - loud.size, loud[-1]))
    return slow._replace(loud=loud, window=slow.window * size, p_value=p_value), sums


def _samples_of_n(state: Investigation) -> int:
    """As many samples together tell most of N: the square of its share in them, for each sample."""
    share = np.minimum(2 * np.exp(state.model.theta[1]) / state.variance, 1.0)
    sizes = 2 ** np.arange(_MOST_DOUBLINGS)
    told = [np.mean(share[state.left.frequency <= 0.5 / size]) ** 2 / size for size in sizes]
    return int(sizes[np.argmax(told)]) if max(told) > _CLEARER * told[0] else 1


def forget_loud_times(state: Investigation) -> None:
    """Take them back: what was stronger then is not the noise."""
    state.modulation = None
    state.foreign -= state.loud_variance
    state.loud_variance = 0.0
    state.spectrum = state.spectrum._replace(dilution=1.0)
    state.findings = [each for each in state.findings if each.name != "variance_modulation"]
    state.gains.pop("variance_modulation", None)
    rebin(state)
    refit(state)


def _knock(
    state: Investigation,
    piece: tuple[int, int],
    changing: Modulation,
    white: Float[np.ndarray, " samples"],
    seed: int,
) -> None:
    """The loud times are a disturbance, to be cut out with a margin."""
    # With their margins some may be one.
    cut = widened(changing.loud, changing.window * _MARGIN)
    state.knocks = [(piece[0] + a, piece[0] + b) for a, b in runs(cut)]
    log_p = float(np.log(max(changing.p_value, 1e-300)))
    state.findings.append(Finding("disturbance", log_p, 0.0, {}, changing))
    state.gains["disturbance"] = of_times(white, changing.loud)


def moved_while_loud(state: Investigation, seed: int) -> bool:
    """Whether the mean is another one in the brief times that are loud.

    The sensor was moved then, however little louder it is. If so these times have to be cut out.
    """
    changing, piece = state.modulation, state.longest
    if changing is None or state.knocks or changing.loud.mean() > _BRIEF_SHARE:
        return False
    near = np.zeros(state.values.size + 1, bool)
    near[piece[0] : piece[1]] = widened(changing.loud, changing.window)
    steps = [round(course.shape["time"]) for course in state.courses if course.name == "step"]
    rectified = any(course.name == "vibration_rectification" for course in state.courses)
    if not (rectified or steps) or not near[steps].all():
        return False
    _knock(state, piece, changing, whitened_piece(state, piece), seed)
    return True


def _wrong_ends(values: Float[np.ndarray, " samples"]) -> Modulation | None:
    """The first or the last samples, if they are far from all that follows or precedes.

    Where a logger begins or stops in the middle of a message. What is made white has no such
    sample: its record is mirrored at the ends.
    """
    if values.size < 4 * _NEIGHBOURS:
        return None
    loud, heights = np.zeros(values.size, bool), []
    for x, mine in ((values, loud), (values[::-1], loud[::-1])):
        near = np.lib.stride_tricks.sliding_window_view(x, 1 + _NEIGHBOURS)
        near = near[:: max(len(near) // _END_PLACES, 1)]
        apart = np.abs(near[:, 0] - np.median(near[:, 1:], axis=1))
        usual = float(np.quantile(apart[1:], _NEARLY_ALL))
        if usual == 0:
            return None
        # A few samples at most, each of which is far from what comes after them all.
        far = np.abs(x[:_MOST_WRONG] - np.median(x[_MOST_WRONG:_NEIGHBOURS])) > _FAR_OUT * usual
        mine[: int(np.argmin(np.append(far, False)))] = True
        heights.append(apart[0] / usual)
    if not loud.any():
        return None
    ratio = float(max(heights))
    return Modulation(ratio, np.full(1, ratio), loud, 1, 1e-300)


def _without_ends(white: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    """Other samples in place of the first and the last.

    Where a filter leaves nothing, what the two ends of the record leak there becomes a knock at
    either end when it is made white.
    """
    white = white.copy()
    white[:_END], white[-_END:] = white[_END : 2 * _END], white[-2 * _END : -_END]
    return white


def _as_modulation(white: Float[np.ndarray, " samples"], brief: Burst) -> Modulation:
    """Brief loud times in the words of lasting ones."""
    loud, quiet = white[brief.loud].std(), white[~brief.loud].std()
    ratio = float(loud / quiet)
    draws = np.full(1, ratio)
    return Modulation(
        ratio, draws, brief.loud, max(brief.window // 4, 1), float(np.exp(brief.log_p))
    )


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
        course = _means.polish(
            _means.step(round(middle), state.values.size),
            lambda at: _means.step(round(at), state.values.size),
            middle,
            half / 2,
            lambda tried: -with_course(state, tried).cost,
        )
        gain, log_p = evidence(state, course._replace(length=_STEP_PATH))
        if log_p > 2 * np.log(state.alarm):
            break
        finding = Finding("step", log_p, gain)
        add_course(state, course, finding)
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
    # Behind a filter five terms know no N, and loud times add nothing to nothing.
    return max(float(np.exp(state.model.theta[1]) - np.exp(alone.theta[1])), 0.0)


def _uniform_part(state: Investigation, mean: Float[np.ndarray, " ordinates"]) -> float:
    """Half-width of what is uniform in a whitened sample, in standard deviations.

    The error of an angle that is rounded is uniform, and a whitened sample holds several of them.
    One alone stands for them, with the fourth cumulant of their sum: -2/15 of its fourth power,
    where each has -6/5 of its squared variance.
    """
    if state.model.kinds.shaping is not None:
        return 0.0
    frequency = np.arange(_KERNEL // 2 + 1) / _KERNEL
    density = np.interp(frequency, state.left.frequency, mean / 2)
    difference = 1 - np.exp(-2j * np.pi * frequency)
    kernel = np.asarray(irfft(difference / np.sqrt(density), _KERNEL))
    variance = float(np.exp(state.model.theta[0]))
    return min((9 * variance**2 * float(np.sum(kernel**4))) ** 0.25, _WIDEST)


def _in_units(found: Contamination, height: float) -> Contamination:
    """In the unit of the record, where a spike of one unit stands `height` tall when whitened."""
    scale = np.array([1.0, 1 / height, 1 / height])
    return found._replace(
        amplitude=found.amplitude / height, sigma=found.sigma / height, draws=found.draws * scale
    )


def _excise(
    state: Investigation,
    piece: tuple[int, int],
    clear: Bool[np.ndarray, " samples"],
    mean: Float[np.ndarray, " ordinates"],
    seed: int,
) -> None:
    """Put neighbours' means with noise of their own in place of spikes, for the analysis alone.

    Without that noise the spectrum would lack what was replaced. It is as strong as what all other
    samples leave open about one: the harmonic mean of the spectrum, which of white noise is all of
    it, and behind a filter nearly nothing.
    """
    noise = np.sqrt(1 / np.mean(2 / mean)) * np.random.default_rng(seed).normal(size=clear.sum())
    values = state.values.copy()
    inside = values[piece[0] : piece[1]]
    good = np.flatnonzero(~clear)
    for at, own in zip(np.flatnonzero(clear), noise, strict=True):
        place = int(np.searchsorted(good, at))
        near = good[max(place - 4, 0) : place + 4]
        inside[at] = inside[near].mean() + own
    state.values = values
    parts = tuple(values[start:stop] for start, stop in state.pieces)
    state.spectrum = state.spectrum._replace(amplitude=amplitudes(parts))
    rebin(state)


def loudness(state: Investigation) -> Float[np.ndarray, "samples columns"]:
    """Local variance of the fast noise [u^2], smooth, centred: what may rectify."""
    changing = state.modulation
    assert changing is not None
    start, stop = state.longest
    share = float(changing.loud.mean())
    added = (changing.ratio**2 - 1) / (1 + share * (changing.ratio**2 - 1))
    # Whitened, white noise of one u^2 is as strong as this on average over the frequencies.
    whitened = float(np.mean(2 / state.variance))
    column = np.zeros(state.values.size)
    column[start:stop] = np.where(changing.loud, added / whitened, 0.0)
    return (column - column[start:stop].mean())[:, None]
