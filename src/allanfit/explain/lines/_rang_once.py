"""A narrow band whose power is all at one time: no resonance of the sensor, but a turn by hand.

Slow movements have no fast noise by which they would be loud, and of all the spectrum they are a
peak.
"""

import numpy as np
from jaxtyping import Float

from .._state import Investigation, whitened_piece, whitened_pieces
from ..spectrum._narrow import Narrow, alone, narrow_groups
from ..strength._knocks import BRIEF_SHARE, knock
from ..strength._modulation import Modulation

# Widths of a band to either side, and how many widths the record has to tell apart in time.
_REACH, _FEWEST = 2.0, 15
# So much of a band's power, above the noise beside it, is within a brief time. Of 24 independent
# powers of normal noise, as 15 widths have, the largest two never are.
_MOSTLY = 0.8
# Lengths of times that are tried, up to the longest that is brief.
_LENGTHS = 12


def rang_once(state: Investigation) -> bool:
    """Whether a narrow noise is one brief movement, which has to be cut out."""
    groups = narrow_groups(state)
    if not groups:
        return False
    white = whitened_piece(state, state.longest, model_only=True)
    for group in groups:
        found = _moved(state, white, group)
        if found is not None:
            knock(state, found, whitened_pieces(state))
            return True
    return False


def _moved(
    state: Investigation, white: Float[np.ndarray, " samples"], group: list[Narrow]
) -> Modulation | None:
    """When a group's power is there, if that is brief."""
    start, stop = state.longest
    if max(each.width for each in group) * white.size < _FEWEST:
        return None
    low = max(min(each.middle - _REACH * each.width for each in group), 0.0)
    high = max(each.middle + _REACH * each.width for each in group)
    band = alone(state, white, group, (low + high) / 2, (high - low) / 2).band
    times = _brief(np.abs(band) ** 2 - 1)
    if times is None:
        return None
    each = (stop - start) / band.size
    loud = np.zeros(state.values.size, bool)
    loud[start + int(times[0] * each) : start + int(np.ceil(times[1] * each))] = True
    place = group[0].place - len(state.model.kinds.added)
    finding = state.findings_of(state.model.kinds.names)[place]
    chance = 1e-300 if finding is None else float(np.exp(max(finding.log_p, -690.0)))
    return Modulation(1.0, np.ones(1), loud[state.looked_at], max(int(each), 1), chance)


def _brief(excess: Float[np.ndarray, " band"]) -> tuple[int, int] | None:
    """The shortest time with most of the power, if it is brief."""
    total = excess.sum()
    # Of noise alone it scatters by one a sample.
    if total < 5 * np.sqrt(excess.size):
        return None
    sums = np.concatenate([[0.0], np.cumsum(excess)])
    longest = int(BRIEF_SHARE * excess.size)
    lengths = np.unique(np.geomspace(1, max(longest, 1), _LENGTHS).round().astype(int))
    for length in lengths:
        inside = sums[length:] - sums[:-length]
        at = int(np.argmax(inside))
        if inside[at] > _MOSTLY * total:
            return at, at + int(length)
    return None
