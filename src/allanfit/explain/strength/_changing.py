"""Whether the shape of a spectrum, or the strength of noise, changes in the course of a record."""

import numpy as np
from jaxtyping import Bool, Float, Shaped
from scipy.stats import chi2

# A swing of the noise is looked for from so many periods on, and up to a hundred short of half the
# rate, or at that. Slower ones are courses of its strength.
_FEWEST_SWINGS, _FASTEST = 8, 100
# A harmonic is there if its power, one on average, is so large: by chance one of 400 sets of three.
_MOST_HARMONICS, _THERE, _MOST_OF_THEM = 200, 7.0, 0.7
#: Samples of a tile.
TILE = 256
_BANDS, _FEWEST_BANDS = 12, 4
# A spectrum is watched in so many parts of the record.
_MOST_PARTS = 24
# A changing spectrum must be as unlikely under a change of white noise.
_RESHAPED = 1e-6
# And as large beside the quiet spectrum, or in one band: of no sensor does the noise keep its shape
# exactly.
_PLAIN, _PLAIN_ALONE = 0.1, 0.06
# A band that has less than that of its mean at times is left out.
_FULL = 0.5
# Less of a tile's power is none; more of a tile is all of it.
_CUT, _NEARLY_ALL = 0.02, 0.99
# And no tile has less of what it is whitened by, rounding aside.
_FAINTEST = 1e-6
# Of the periods over all tiles the slowest are looked at: one in so many.
_SLOWEST = 8
# Contrasts with a smaller part of their own are one.
_PARALLEL = 1e-3

# Parts of a record differ in their number of tiles.
Powers = Float[np.ndarray, "_ frequencies"]


def tiles(
    white: Float[np.ndarray, " samples"], window: Float[np.ndarray, " tile"] | None = None
) -> Powers:
    """Powers of short pieces of a white record, from zero to the Nyquist frequency: ones.

    A `window` keeps what is strong from leaking, and makes neighbours alike.
    """
    window = np.ones(TILE) if window is None else window
    return np.abs(np.fft.rfft(_tiled(white) * window)) ** 2 / np.sum(window**2)


def shares(values: Shaped[np.ndarray, " samples"]) -> Float[np.ndarray, " tiles"]:
    """The mean of each tile: of flags, how much of it is flagged."""
    return _tiled(values).mean(axis=1)


def _tiled(values: np.ndarray) -> np.ndarray:
    count = values.size // TILE
    return values[: count * TILE].reshape(count, TILE)


def parts(powers: Powers) -> list[Powers]:
    """Tiles in equal parts of the record, each of enough for its spectrum."""
    count = min(_MOST_PARTS, len(powers) // _BANDS)
    part = np.arange(len(powers)) * count // max(len(powers), 1)
    return [powers[part == each] for each in range(count)]


def reshaped(
    groups: list[Powers],
    density: Float[np.ndarray, " frequencies"],
    usable: Bool[np.ndarray, " frequencies"] | None = None,
    passed: Float[np.ndarray, " frequencies"] | None = None,
) -> tuple[float, float] | None:
    """Where spectra of parts of a record differ most in shape, and the log of its chance.

    `groups` are powers of tiles of the white record, and `density` is what their frequencies were
    made white with. Those that are not `usable`, since lines were cut out of them, are left out.
    Louder white noise is no other shape, nor what a filter lets pass of it, which is `passed`.
    """
    if len(groups) < 2 or min(len(group) for group in groups) < _BANDS:
        return None
    usable = np.ones(density.size, bool) if usable is None else usable
    edges = np.unique(np.geomspace(1, TILE // 2, _BANDS + 1).round().astype(int))
    in_band = np.maximum(np.add.reduceat(usable, edges, dtype=int)[:-1], 1)

    def banded(spectra: np.ndarray) -> np.ndarray:
        return np.add.reduceat(spectra * usable, edges, axis=-1)[..., :-1] / in_band

    in_bands = [banded(group) for group in groups]
    mean = np.stack([each.mean(axis=0) for each in in_bands])
    variance = np.stack([each.var(axis=0, ddof=1) / len(each) for each in in_bands])
    # What is faint at times, others leak into.
    kept = np.min(mean, axis=0) > _FULL
    if kept.sum() < _FEWEST_BANDS:
        return None
    mean, variance, count = mean[:, kept], variance[:, kept], in_band[kept]
    # Whitened by their mean, white noise that is added weighs as one over the density there.
    gains = [np.ones(density.size)] if passed is None else [np.ones(density.size), passed]
    weights = [banded(gain / density)[kept] for gain in gains]
    tiles_in = np.array([[len(group)] for group in groups])
    variance = np.maximum(variance, mean**2 / count / tiles_in)
    if len(groups) == 2:
        # One may be many times as strong, and less well known: it is measured by the other alone.
        difference, variance = mean[:1] - mean[1:], variance.sum(axis=0, keepdims=True)
        mean = mean[:1]
    else:
        difference = mean - np.average(mean, axis=0, weights=tiles_in[:, 0])

    def rest(weight: np.ndarray) -> np.ndarray:
        added = np.sum(difference * weight / variance, axis=1) / np.sum(
            weight**2 / variance, axis=1
        )
        return difference - added[:, None] * weight

    left = min(map(rest, weights), key=lambda each: float(np.sum(each**2 / variance)))
    misfit = float(np.sum(left**2 / variance))
    freedom = (len(groups) - 1) * (count.size - 1)
    sizes = np.mean((left**2 - variance) / mean**2, axis=0)
    log_p = float(chi2.logsf(misfit, freedom))
    # What moves through the spectrum is a small change of all of it, and a larger one of a band.
    alone = chi2.logsf(np.sum(left**2 / variance, axis=0), len(groups) - 1) + np.log(count.size)
    moves = np.any((alone < np.log(_RESHAPED)) & (sizes > _PLAIN_ALONE**2))
    if log_p > np.log(_RESHAPED) or (np.mean(sizes) < _PLAIN**2 and not moves):
        return None
    middle = np.sqrt(edges[:-1] * (edges[1:] - 1))[kept] / TILE
    return float(middle[int(np.argmax(np.sum(left**2 / variance, axis=0)))]), log_p


def reshaped_at_times(
    powers: Powers,
    share: Float[np.ndarray, " tiles"],
    density: Float[np.ndarray, " frequencies"],
    usable: Bool[np.ndarray, " frequencies"] | None = None,
    passed: Float[np.ndarray, " frequencies"] | None = None,
) -> tuple[float, float] | None:
    """The same of the tiles of which a `share` of one is loud, against those of none.

    Loud tiles may be many times as strong: they are measured by the quiet ones, and not by the mean
    of all.
    """
    loud, quiet = loud_and_quiet(powers, share)
    usual = quiet_spectrum(loud, quiet)
    return reshaped([loud / usual, quiet / usual], density * usual, usable, passed)


def loud_and_quiet(powers: Powers, share: Float[np.ndarray, " tiles"]) -> tuple[Powers, Powers]:
    """The tiles of which all is loud, and those of which nothing is."""
    return powers[share > _NEARLY_ALL], powers[share < 1 - _NEARLY_ALL]


def quiet_spectrum(loud: Powers, quiet: Powers) -> Float[np.ndarray, " frequencies"]:
    """The mean of quiet tiles, or one where a line was cut out, of loud ones as well."""
    if not len(quiet):
        return np.ones(quiet.shape[1])
    usual = quiet.mean(axis=0)
    strongest = np.maximum(usual, loud.mean(axis=0) if len(loud) else 0.0)
    return np.where(strongest > _CUT, np.maximum(usual, _FAINTEST), 1.0)


def moved_along(
    powers: Powers,
    contrasts: Float[np.ndarray, "frequencies k"],
    level: Float[np.ndarray, " frequencies"] | None = None,
) -> tuple[float, float]:
    """How much a spectrum moves to and fro along contrasts: twice the gain in log-likelihood.

    In each tile the contrasts, freed of what the level does and of another `level` that may change,
    have values; over time these are white, unless something goes on that is slow. Returns the gain
    of the strongest period, of which the record has one at least, and the log of the chance that
    one of them gains as much.
    """
    flat = np.ones(len(contrasts))
    levels, _ = np.linalg.qr(np.column_stack([flat] if level is None else [flat, level]))
    freed = contrasts - levels @ (levels.T @ contrasts)
    basis, sizes, _ = np.linalg.svd(freed, full_matrices=False)
    basis = basis[:, sizes > _PARALLEL * max(float(np.linalg.norm(contrasts)), 1e-300)]
    values = (powers - powers.mean(axis=0)) @ basis
    # Half an ordinate apart, so that no period falls between two.
    last = 2 * len(values) // (2 * _SLOWEST)
    if last < 4 or not values.any():
        return 0.0, 0.0
    spectra = np.fft.rfft(values, 2 * len(values), axis=0)[2:last]
    inverse = np.linalg.inv(values.T @ values)
    gains = 2 * np.einsum("fi,ij,fj->f", spectra, inverse, spectra.conj()).real
    gain = float(gains.max())
    log_p = chi2.logsf(gain, 2 * basis.shape[1]) + np.log(gains.size)
    return gain, float(min(0.0, log_p))


def swinging(
    white: Float[np.ndarray, " samples"], longest: float = np.inf
) -> tuple[float, float] | None:
    """Period [samples] and log chance of noise whose strength swings, too fast for `_modulation`.

    The squares of a white record are white; a periodic strength is a line among them. Periods from
    `longest` on are not looked at.
    """
    white = white[: white.size // 2 * 2]
    squares = white**2 - np.mean(white**2)
    power = np.abs(np.fft.rfft(squares)) ** 2 / np.sum(squares**2)
    usable = np.zeros(power.size, bool)
    usable[max(_FEWEST_SWINGS, int(white.size / longest) + 1) : -1 - _FASTEST] = True
    if usable.sum() < TILE:
        return None
    # A strong resonance makes the squares uneven: each stretch of them by its own median.
    starts = np.arange(0, power.size, TILE)
    own = np.array([np.median(power[a : a + TILE]) for a in starts]) / np.log(2)
    power = power / np.maximum(np.repeat(own, TILE)[: power.size], 1.0)
    at = int(np.argmax(np.where(usable, power, 0.0)))
    log_p = float(min(0.0, np.log(usable.sum()) - power[at]))
    # Two converters by turns are at the last ordinate, which is the square of one normal variate.
    by_turns = float(min(0.0, np.log(usable.sum()) - power[-1] / 2))
    if by_turns < log_p:
        at, log_p = power.size - 1, by_turns
    return white.size / at * _harmonic(power, at), log_p


def _harmonic(power: Float[np.ndarray, " ordinates"], at: int) -> int:
    """The number of the harmonic that is strongest, at ordinate `at`: brief pulses have many alike.

    Of all slower ones of its fundamental most are there; of half of that half are.
    """
    for number in range(min(_MOST_HARMONICS, at // _FEWEST_SWINGS), 1, -1):
        # To one ordinate, as the strongest is known.
        slower = np.rint(np.arange(1, number) * at / number).astype(int)
        there = np.max([power[slower + step] for step in (-1, 0, 1)], axis=0) > _THERE
        if np.mean(there) > _MOST_OF_THEM:
            return number
    return 1
