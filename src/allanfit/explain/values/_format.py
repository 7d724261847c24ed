"""How samples were made: held, rounded, clipped. Told from the values alone, and for sure."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.stats import binom

from ...physics import AngleCodes
from ...recording._angle_codes import angle_codes
from ...recording._checks import (
    Repeats,
    code_width,
    fresh_deviation,
    local_deviation,
    rails,
    repeated,
    usable,
    wide,
)
from .._intervals import runs

# A code this wide beside the local noise adds 0.5 % to its variance, and an engineer should know.
_COARSE = 0.25
# Up to here rounded noise is as good as normal; wider codes look like outliers.
_DISCRETE = 0.5
# Log of a chance below which chances are all alike.
_SURE = -1e4
_WINDOW = 64
# Windows with as many samples at a rail show no noise, and with as many it is cut.
_STUCK, _CUT = 0.9, 0.1


@dataclass(frozen=True)
class Repeat:
    """Samples that repeat the one before."""

    #: Mean samples for each fresh value, and the standard deviation of that.
    samples: float
    deviation: float
    log_p: float


@dataclass(frozen=True)
class Format:
    """What the values say of how they were made."""

    #: Difference between neighbouring codes, and whether it matters beside the noise.
    width: float
    coarse: bool
    #: Whether codes are so wide that rounded noise is not normal.
    discrete: bool
    #: Local standard deviation of the samples.
    sigma: float
    rails: tuple[float, ...]
    #: Share of the samples at the rails.
    clipped: float
    repeat: Repeat | None
    #: Log of the chance that as many samples are of one value, if that is a dead band's, else 0.
    dead: float = 0.0
    #: How an angle moves among these codes, if they are wide, and those of an angle.
    angle: AngleCodes | None = None

    @property
    def normal(self) -> bool:
        """Whether values are as normal and as independent as their noise."""
        return not self.discrete and self.repeat is None


def sample_format(
    values: Float[np.ndarray, " samples"], pieces: tuple[tuple[int, int], ...]
) -> Format:
    """Look at the values of all stretches [u]."""
    used = usable(values, pieces)
    width = code_width(used)
    sigma = local_deviation(used)
    whole = sigma or fresh_deviation(used)
    coarse, discrete = (width > part * whole for part in (_COARSE, _DISCRETE))
    ends = () if wide(width, whole) else rails(used, width)
    clipped = float(np.mean(np.isin(used, ends))) if ends else 0.0
    angle = angle_codes(used, width)
    again = repeated(used, ends, width)
    if angle is not None:
        # It stays within a code for many samples.
        again = again._replace(beyond=False, dead=np.nan, few=False)
    dead = _log_chance(again, used.size) if np.isfinite(again.dead) else 0.0
    repeat = _repeat(again, used.size)
    return Format(width, coarse, discrete, sigma, ends, clipped, repeat, dead, angle)


def stuck(
    values: Float[np.ndarray, " samples"], pieces: tuple[tuple[int, int], ...], made: Format
) -> list[tuple[int, int]]:
    """`[start, stop)` of times at a rail, from where noise is cut to where it is whole again."""
    if not made.rails:
        return []
    found = []
    for start, stop in pieces:
        count = (stop - start) // _WINDOW
        windows = np.isin(values[start : start + count * _WINDOW], made.rails)
        share = windows.reshape(count, _WINDOW).mean(axis=1)
        found += [
            (start + a * _WINDOW, start + b * _WINDOW if b < count else stop)
            for a, b in runs(share > _CUT)
            if np.any(share[a:b] > _STUCK)
        ]
    return found


def _repeat(found: Repeats, samples: int) -> Repeat | None:
    if not found.beyond:
        return None
    # Neighbours that rounding alone makes equal are no repeats.
    mean = 1 / (1 - (found.share - found.by_chance))
    # Of 1/(1 - p); what chance explains was counted too, on codes next to zero.
    variance = (found.share * (1 - found.share) + found.by_chance) / samples
    return Repeat(mean, mean**2 * variance**0.5, _log_chance(found, samples))


def _log_chance(found: Repeats, samples: int) -> float:
    """Log of the chance that rounding makes as many neighbours equal."""
    chance = max(found.most_by_chance, 1e-9)
    return max(float(binom.logsf(int(found.share * samples) - 1, samples, chance)), _SURE)
