"""How fast a temperature may change and still be believed.

A thermometer is slow, noisy and rounded, and read more often than it converts. Where its own
errors are not small beside its changes, a regression on it finds too little (errors in the
regressor pull a slope toward zero), and what it finds it finds with too much confidence. So the
regression uses the slow changes alone: up to the highest octave of frequency in which the
temperature, a straight line in time taken out, has `_CLEAR` times the power of its errors.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from scipy.fft import dct, idct

from ..curves._spectrum import RampProjection

# Slopes are then too small by a part in 3 _CLEAR at the worst, which is a temperature that wanders
# like a random walk beside a sensor that does; by far less where either is smoother.
_CLEAR = 10.0
# A thermal effect that is faster than a thousandth of a record is rare, and memory is not free.
_MOST_MODES = 2048
_FEWEST_MODES = 4
# Rounding of the arithmetic, relative to the whole power of the temperature.
_SMALLEST = 1e-10


def highest_mode(stretches: Sequence[Float[np.ndarray, " _"]]) -> int:
    """The order up to which cosine coefficients of a temperature can be believed.

    Of the longest stretch; a mode j of L samples has the frequency j/(2 L) per sample. The errors
    are taken to be as large as a temperature of no noise but rounding would have, or as second
    differences from value to value say, and to last as long as a value does.

    **Arguments:** the temperature between gaps, each stretch of shape (samples,), in any unit.

    **Returns:** the order, or 0 where the temperature is nothing but a straight line in time and
    errors.
    """
    longest = max(stretch.size for stretch in stretches)
    power = np.zeros(longest)
    count = np.zeros(longest)
    for stretch in stretches:
        coefficients = np.asarray(dct(stretch - stretch.mean(), type=2, norm="ortho"))[1:]
        # Of what no straight line explains.
        squares = np.asarray(RampProjection(stretch.size)(coefficients))
        # Orders of the longest stretch with about the same frequency, from 2 on.
        order = np.arange(2, stretch.size) * longest // stretch.size
        np.add.at(power, order, squares)
        np.add.at(count, order, 1)
    whole = sum(float(np.sum((stretch - stretch.mean()) ** 2)) for stretch in stretches)
    least = max(_CLEAR * error_power(stretches), _SMALLEST * whole)
    orders = [top for k in range(2, 12) for top in (2**k, 3 * 2 ** (k - 1))]
    believed = 0
    for top in orders:
        octave = slice(top // 2 + 1, top + 1)
        if _FEWEST_MODES <= top <= min(_MOST_MODES, longest // 4) and (
            power[octave].sum() >= least * count[octave].sum() > 0
        ):
            believed = top
    return believed


def believable(
    temperature: Float[np.ndarray, " samples"], stretches: Sequence[tuple[int, int]]
) -> Float[np.ndarray, " samples"]:
    """The changes of a temperature that can be believed: as slow as `highest_mode` says.

    Their mean is taken out, and between the stretches they are interpolated. Where a temperature
    is a straight line and errors it stays as it is.
    """
    parts = [temperature[start:stop] for start, stop in stretches]
    top, longest = highest_mode(parts), max(part.size for part in parts)
    mean = float(np.mean(np.concatenate(parts)))
    slow = []
    for part in parts:
        coefficients = np.asarray(dct(part - mean, norm="ortho"))
        if top:
            coefficients[top * part.size // longest + 1 :] = 0.0
        slow.append(np.asarray(idct(coefficients, norm="ortho")))
    inside = np.concatenate([np.arange(start, stop) for start, stop in stretches])
    return np.interp(np.arange(temperature.size), inside, np.concatenate(slow))


def error_power(stretches: Sequence[Float[np.ndarray, " _"]]) -> float:
    """Variance that a temperature's own errors give each slow cosine coefficient [unit^2]."""
    values = np.unique(np.concatenate(list(stretches)))
    code = float(np.quantile(np.diff(values), 0.1)) if values.size > 1 else 0.0
    runs = [stretch[np.flatnonzero(np.diff(stretch, prepend=np.nan))] for stretch in stretches]
    bends = np.concatenate([run[1:-1] - (run[:-2] + run[2:]) / 2 for run in runs])
    # The second difference of independent values, halved, has 3/2 of their variance.
    noise = 2 / 3 * float(np.mean(bends**2)) if bends.size else 0.0
    held = sum(stretch.size for stretch in stretches) / sum(run.size for run in runs)
    return held * max(noise, code**2 / 12)
