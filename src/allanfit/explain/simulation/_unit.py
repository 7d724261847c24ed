"""Whether a simulation that gives no unit looks to be in another than the recording's."""

import numpy as np
from jaxtyping import Float

from ...formatting import listed, significant
from ...physics import SYMBOLS
from ...recording import Channel
from ...recording._units import parse_unit
from ._references import Reference

# What simulators compute in, and data sheets quote.
_USUAL = {
    "gyro": ("rad/s", "deg/s", "mrad/s", "deg/h"),
    "accelerometer": ("m/s^2", "g", "mg", "ug"),
}
# Standard deviations beyond which a coefficient is not zero, or not one with another.
_SHOWN, _APART = 2.0, 2.0
# Logarithm of what several coefficients may be off by beside their unit, each by itself: that all
# are off by tens, and alike, is no matter of tuning. A single one has to match a unit as it is.
_SEVERAL, _SINGLE = np.log(1.6), 0.03


def unit_advice(
    own: tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]],
    reference: Reference,
    channel: Channel,
) -> list[str]:
    """A sentence if all coefficients of a simulation are off as by another unit; else none.

    `own` are Q, N, B, K and R of the `channel` in SI, and their standard deviations. Nothing is
    said of a simulation that gives its unit.
    """
    (values, errors), theirs = own, reference.coefficients
    shown = (values > _SHOWN * errors) & (theirs > _SHOWN * reference.deviations) & (theirs > 0)
    which = np.flatnonzero(shown[:4])
    if not reference.unit_assumed or not which.size:
        return []
    ratio = theirs[which] / values[which]
    spread = np.hypot(errors[which] / values[which], reference.deviations[which] / theirs[which])
    allowed = np.maximum(_APART * spread, _SEVERAL if which.size > 1 else _SINGLE)
    off = {
        # Numbers of this unit that are taken for the channel's are so many times too large.
        unit: np.abs(np.log(ratio * parse_unit(unit).factor / channel.factor))
        for unit in _USUAL.get(channel.kind, ())
    }
    as_it_is = np.abs(np.log(ratio))
    alike = [
        unit
        for unit, distance in off.items()
        # What is that uncertain may be anything.
        if (distance < allowed).all() and (as_it_is > 2 * allowed).all()
    ]
    if not alike:
        return []
    likely = min(alike, key=lambda unit: float(np.sum(np.square(off[unit]))))
    names = listed([SYMBOLS[index] for index in which])
    sizes = listed([significant(float(each), 3) for each in ratio])
    expected = significant(channel.factor / parse_unit(likely).factor, 3)
    verb = "is" if which.size == 1 else "are"
    return [
        f"The simulation gives no unit and looks to be in {likely}: its {names} {verb} {sizes} "
        f"times the recording's, and {likely} taken for {channel.unit} makes {expected}; name the "
        "unit in its file."
    ]
