"""Values that are larger than normal noise has them: outliers, and noise with long tails."""

import numpy as np
from jaxtyping import Bool, Float
from scipy.fft import irfft

from ...recording._spikes import alone
from .._refit import refit
from .._state import Finding, Investigation
from ..spectrum._whiten import END, KERNEL, kernel_density
from . import _discrete
from ._alone import Others, behind_filter, clear_of_noise, read_again
from ._contamination import Contamination, beyond, contamination, in_units, unseen, unseen_draws
from ._held_out import of_events, of_spikes
from ._skewness import leans

# Spikes more frequent than this are what the noise is like: cut out, they would take its spectrum
# with them.
_RARE = 0.05
# And where so many samples have them, they are the noise itself, which has long tails.
USUAL = 0.08
# Such noise, and spikes no larger than the noise, are told from a strong effect that is not normal
# by this gain over a normal one.
_LONG_TAILED = 60.0
# Uniform parts that are narrower are as good as normal, and so much of the variance is uniform at
# most.
_NARROWEST, _MOST_UNIFORM = 0.02, 0.9
# By chance the quiet times may seem to have spikes as often.
_IN_QUIET = 0.01
# Standard deviations of a spike that passes for a step, a knock, or a time that is loud.
_TALL = 30.0
# A white record shows a spike in one sample if all of it is no larger, squared, by this.
_SPREAD = 1.1
# Samples on either side that tell where one should be, and how many times as far a spike has to be
# from their median as one that was made white.
_BESIDE, _BEYOND = 4, 1.5


def take_out_spikes(
    state: Investigation,
) -> tuple[Bool[np.ndarray, " looked_at"], Float[np.ndarray, " spikes"]]:
    """Take out single samples beside which nothing else can be told, whether named or not.

    Neighbours' means come in their place, or behind a filter what all others expect. Second, how
    far from there they were [u].
    """
    found = np.zeros(state.looked_at.size, bool)
    if state.contamination is not None or not state.format.normal:
        return found, np.zeros(0)
    begin = 0
    for start, stop in state.long_pieces:
        found[begin + alone(state.values[start:stop], _TALL)[0]] = True
        begin += stop - start
    recorded = state.values
    behind = behind_filter(state, found)
    found = found if behind is None else behind[0]
    if not found.any():
        return found, np.zeros(0)
    if behind is None:
        _excise(state, found, 0.0, 0)
    else:
        state.values = behind[1]
        read_again(state)
    refit(state)
    at = state.looked_at[found]
    return found, recorded[at] - state.values[at]


def put_back(state: Investigation, values: Float[np.ndarray, " samples"]) -> None:
    """Values that were taken out for nothing."""
    state.values = values
    read_again(state)
    refit(state)


def name_spikes(
    state: Investigation,
    even: Float[np.ndarray, " looked_at"],
    mean: Float[np.ndarray, " ordinates"],
    height: float,
    seed: int,
    quiet: Bool[np.ndarray, " looked_at"] | None = None,
) -> None:
    """Name values that are larger than normal noise has them, and count them out of N.

    A spike of one unit stands `height` tall among what is `even`.
    Where there are loud times, the `quiet` ones have to have them too: vibration is not normal.
    """
    if state.contamination is not None:
        return
    boxes = _uniform_parts(state, mean)
    spiky = _spiky(state, even, boxes, seed)
    if spiky is None:
        return
    if quiet is not None and contamination(even[quiet], seed, boxes).p_value > _IN_QUIET:
        return
    _take_spikes(state, spiky, height)
    state.gains["outliers"] = of_spikes(even, boxes, seed)
    state.leans = leans(even, spiky.fraction)
    clear = np.abs(even) > spiky.threshold
    if spiky.fraction > USUAL or state.leans < np.log(state.alarm):
        wrong = 0.0
    elif clear.mean() < _RARE:
        clear |= _at_ends(state, _BEYOND * spiky.threshold / height)
        # What all other samples leave open about one is the harmonic mean of the spectrum: of white
        # noise all of it, and behind a filter nearly nothing.
        _excise(state, clear, spiky.sigma * float(np.sqrt(1 / np.mean(2 / mean))), seed)
        # Where a spike is more than one sample of the white record, its neighbours are wrong too.
        alone = np.mean(2 / mean) < _SPREAD * height_of(mean) ** 2
        wrong = float(np.mean(even[~clear] ** 2)) - spiky.sigma**2 if alone else 0.0
        if not alone:
            _count_unseen(state, seed)
    else:
        wrong = float(np.var(even)) - spiky.sigma**2
    state.foreign += max(wrong, 0.0) / height**2


def name_errors(
    state: Investigation,
    even: Float[np.ndarray, " looked_at"],
    mean: Float[np.ndarray, " ordinates"],
    others: Others,
    errors: Float[np.ndarray, " errors"],
    seed: int,
) -> None:
    """Name errors [u] that all `others` contradict, which the values lack already.

    Among what is `even` they stand as tall as the others see them.
    """
    boxes = _uniform_parts(state, mean)
    spiky = _spiky(state, even, boxes, seed)
    if spiky is None:
        return
    if not spiky.heavy:
        # Smaller ones are left in, which the others do not contradict and no white record shows.
        reach = clear_of_noise(state, even.size)
        sizes = np.maximum(np.abs(errors) * others.height, reach)
        spiky = beyond(sizes, reach, even.size, seed)._replace(
            gain=spiky.gain, p_value=spiky.p_value
        )
    _take_spikes(state, spiky, others.height)
    state.gains["outliers"] = of_spikes(even, boxes, seed)
    state.leans = leans(even, spiky.fraction)
    _count_unseen(state, seed)


def _spiky(
    state: Investigation, even: Float[np.ndarray, " looked_at"], boxes: tuple[float, ...], seed: int
) -> Contamination | None:
    """The spikes among what is `even`, if there are any."""
    spiky = contamination(even, seed, boxes)
    state.witness(
        "outliers",
        spiky.gain,
        spiky.p_value,
        "Two normal distributions against one, on the whitened record.",
    )
    spikes = spiky.p_value < state.alarm and spiky.amplitude > 1.5 * spiky.sigma
    # Small ones, or noise with long tails. A mixture of two shapes of one width has short tails.
    tails = spiky.gain > _LONG_TAILED and spiky.amplitude > spiky.sigma / 2
    return spiky if spikes or tails else None


def name_clear_spikes(
    state: Investigation, even: Float[np.ndarray, " looked_at"], height: float, seed: int
) -> None:
    """Spikes that no rounding makes, among values that are not normal."""
    found = _discrete.clear_spikes(state, even, height, seed)
    if found is None or state.contamination is not None or found[0].p_value >= state.alarm:
        return
    spiky, clear = found
    _take_spikes(state, spiky, height)
    state.gains["outliers"] = of_events(clear, spiky.p_value)
    if clear.mean() < _RARE:
        _count_unseen(state, seed)
        state.values = _discrete.replaced(state.values, state.looked_at[clear], seed)
        read_again(state)
    else:
        wrong = float(np.var(even)) - spiky.sigma**2
        state.foreign += max(wrong, 0.0) / height**2


def _count_unseen(state: Investigation, seed: int) -> None:
    """Count spikes [u] within reach of the noise out of N, and let N be as uncertain as these."""
    found = state.contamination
    assert found is not None
    within = unseen(found)
    state.count_unsure(within, unseen_draws(found, seed) - within)


def _take_spikes(state: Investigation, spiky: Contamination, height: float) -> None:
    state.contamination = in_units(spiky, height)
    log_p = np.log(max(spiky.p_value, 1e-300))
    state.findings.append(Finding("outliers", log_p, spiky.gain, {}, state.contamination))


def height_of(mean: Float[np.ndarray, " ordinates"]) -> float:
    """How tall a spike of one unit is in the record that is whitened to this `mean`."""
    return float(np.mean(1 / np.sqrt(mean / 2)))


def _uniform_parts(
    state: Investigation, mean: Float[np.ndarray, " ordinates"]
) -> tuple[float, ...]:
    """Half-widths of what is uniform in a whitened sample, in standard deviations.

    The error of an angle that is rounded is uniform, and a whitened sample holds several of them.
    """
    if state.model.kinds.shaping is not None:
        return ()
    density = kernel_density(state.left, mean)
    difference = 1 - np.exp(-2j * np.pi * np.arange(density.size) / KERNEL)
    kernel = np.asarray(irfft(difference / np.sqrt(density), KERNEL))
    deviation = float(np.exp(state.model.theta[0] / 2))
    half = np.sort(np.sqrt(3) * deviation * np.abs(kernel))[::-1]
    half = half[half > _NARROWEST]
    share = float(np.sum(half**2)) / 3
    half *= np.sqrt(min(1.0, _MOST_UNIFORM / share)) if share else 1.0
    return tuple(float(each) for each in half)


def _at_ends(state: Investigation, least: float) -> Bool[np.ndarray, " looked_at"]:
    """Spikes among the samples at the ends, which are not made white: far from those about them."""
    found = np.zeros(state.looked_at.size, bool)
    begin = 0
    for start, stop in state.long_pieces:
        x = state.values[start:stop]
        ends = [*range(END), *range(x.size - END, x.size)] if x.size >= 4 * END else []
        for at in ends:
            near = x[max(at - _BESIDE, 0) : at + _BESIDE + 1]
            found[begin + at] = abs(x[at] - np.median(near)) > least
        begin += x.size
    return found


def _excise(
    state: Investigation,
    clear: Bool[np.ndarray, " looked_at"],
    deviation: float,
    seed: int,
) -> None:
    """Put neighbours' means with noise of their own in place of spikes, for the analysis alone.

    Of the standard `deviation` of the noise without spikes [u]: else the spectrum would lack what
    was replaced. Behind a filter, and where quantization rules, the means would be more wrong than
    the noise is, and all others leave nearly nothing open: what they expect comes in place.
    """
    others = Others(state)
    values = state.values.copy() if others.white else others.filled(state, clear)
    if others.white:
        noise = deviation * np.random.default_rng(seed).normal(size=clear.sum())
        good, wrong = state.looked_at[~clear], state.looked_at[clear]
        for at, own in zip(wrong, noise, strict=True):
            place = int(np.searchsorted(good, at))
            near = good[max(place - _BESIDE, 0) : place + _BESIDE]
            values[at] = values[near].mean() + own
    state.values = values
    read_again(state)
