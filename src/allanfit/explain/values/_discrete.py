"""Held or rounded values: which of them tell of the noise, and spikes among them.

Such values are neither normal nor independent. Of a log that repeats samples at random the fresh
ones are; rounding adds a variance of its own, which lasts while the noise is not much narrower than
a code. What is far from all that both can do is a spike.
"""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.stats import binom, norm

from .._intervals import runs
from .._state import Investigation
from ..strength._modulation import Modulation, modulation
from ._contamination import Contamination, beyond, in_units

# Codes so many times as wide as the noise hide whether it lasts, and so many times, what is brief.
LASTING, BRIEF = 3.0, 5.0
#: What goes from one coarse code to the next, or dwells on both, moves by so many at most.
CROSSED = 1.5
# A variance must change by more than codes change it by themselves, so many times.
_MORE = 2.0
# A spike is so many standard deviations from all others, beyond what rounding does.
_FAR = 6.0
# At fewer places it may be something else, as a step is.
_FEWEST = 3
_ROUNDS = 20


def codes_over_noise(state: Investigation) -> float:
    """The width of a code over the standard deviation of what was rounded.

    Behind a filter it is that of noise whose neighbours differ as much as those that are logged:
    values that hardly move within a code make errors that depend on them, however many codes they
    cross in the end.
    """
    width, made = state.format.width, state.rounding
    logged, added = made.logged, made.added
    if logged == 0:
        logged, added = state.format.sigma**2, width**2 / 12
    moved = np.diff(state.values[state.looked_at][telling(state)])
    squared = min(logged, float(np.var(moved)) / 2) - added
    return float(width / np.sqrt(squared)) if squared > 0 else np.inf


def telling(state: Investigation) -> Int[np.ndarray, " told"]:
    """Which of those `looked_at` are no copies of the one before."""
    if state.format.repeat is None:
        return np.arange(state.looked_at.size)
    return np.flatnonzero(np.diff(state.values[state.looked_at], prepend=np.nan) != 0)


def as_held(
    flags: Bool[np.ndarray, " told"], told: Int[np.ndarray, " told"], samples: int
) -> Bool[np.ndarray, " looked_at"]:
    """What is true of samples that are told, of their copies too."""
    return flags[np.searchsorted(told, np.arange(samples), "right") - 1]


def change(
    state: Investigation, white: Float[np.ndarray, " looked_at"], height: float, seed: int
) -> tuple[Modulation, Float[np.ndarray, " told"]]:
    """When the noise is loud, as far as its values tell, and the whitened values that do.

    `height` is that of one unit in the whitened record.
    """
    told = telling(state)
    heard = white[told] / white[told].std()
    # Rounded noise is followed between two levels, and no further.
    found = modulation(heard, seed)._replace(strength=None, extremes=None, odds=None)
    codes = codes_over_noise(state)
    lasts = codes > LASTING or found.ratio**2 - 1 < _MORE * (_own_change(codes) - 1)
    loud = as_held(found.loud, told, white.size)
    if lasts or not loud.any() or loud.all():
        return found._replace(loud=np.zeros(white.size, bool)), heard
    window = -(-found.window * white.size // told.size)
    # Rounding adds as much to loud noise as to quiet noise.
    quiet = float(np.var(white[told][~found.loud])) / height**2
    share = min(max(state.rounding.added, 0.0) / quiet, 0.9)
    ratio, draws = (
        np.sqrt(np.maximum((each**2 - share) / (1 - share), 0.0))
        for each in (found.ratio, found.draws)
    )
    return found._replace(ratio=float(ratio), draws=draws, loud=loud, window=window), heard


def _own_change(codes: float) -> float:
    """The largest variance of rounded noise over its smallest, as its mean goes through a code.

    By the first harmonic of the error in the mean's place, for codes up to some times the noise
    (Widrow and Kollár 2008, 4.3): s^2 + q^2/12 -/+ (4 s^2 + q^2/pi^2) exp(-2 (pi s/q)^2).
    """
    if codes == 0:
        return 1.0
    mean = 1 + codes**2 / 12
    swing = (4 + codes**2 / np.pi**2) * np.exp(-2 * (np.pi / codes) ** 2)
    return float((mean + swing) / max(mean - swing, 1e-9))


def clear_spikes(
    state: Investigation, even: Float[np.ndarray, " looked_at"], height: float, seed: int
) -> tuple[Contamination, Bool[np.ndarray, " looked_at"]] | None:
    """Spikes that are clear of all that noise and codes do, in whitened units, and where they are.

    Those within reach of the noise are counted by what the others say: how many are beyond, and
    how far, tells how many there are, and their size.
    """
    told = telling(state)
    values = even[told]
    clear = np.zeros(values.size, bool)
    sigma = code = 0.0
    for _ in range(_ROUNDS):
        sigma = float(values[~clear].std())
        code = state.format.width * height / sigma
        now = np.abs(values) > (_FAR + code) * sigma
        if np.array_equal(now, clear):
            break
        clear = now
    places = len(runs(clear))
    if places < _FEWEST or clear.mean() > 0.5:
        return None
    found = beyond(np.abs(values[clear]) / sigma, _FAR + code, values.size, seed)
    # Samples of one place are no witnesses of their own.
    log_p = float(binom.logsf(places - 1, values.size, 2 * norm.sf(_FAR)))
    found = found._replace(gain=max(-2 * log_p, 0.0), p_value=float(np.exp(log_p)))
    return in_units(found, 1 / sigma), as_held(clear, told, even.size)


def replaced(
    values: Float[np.ndarray, " samples"], wrong: Int[np.ndarray, " wrong"], seed: int
) -> Float[np.ndarray, " samples"]:
    """Good values from nearby in place of the `wrong` ones; of a held one, of its copies too."""
    rng = np.random.default_rng(seed)
    good = np.ones(values.size, bool)
    good[wrong] = False
    at = np.flatnonzero(good)
    filled = values.copy()
    for start, stop in runs(~good):
        near = at[max(np.searchsorted(at, start) - 8, 0) :][:16]
        begins = np.flatnonzero(np.diff(values[start:stop], prepend=np.nan) != 0)
        lengths = np.diff(np.append(begins, stop - start))
        filled[start:stop] = np.repeat(values[rng.choice(near, begins.size)], lengths)
    return filled
