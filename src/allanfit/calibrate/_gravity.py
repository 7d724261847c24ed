"""The reference of every accelerometer test: gravity, and whether the readings can be it."""

import math

#: m/s^2, exact by definition: CGPM 1901, resolution 2.
STANDARD_GRAVITY = 9.80665
# Of the size of gravity; sensors are within a few per cent, wrong units are not.
_LARGEST_SCALE_ERROR = 0.3
_UNITS = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY}


def checked_gravity(gravity: float | None) -> tuple[float, tuple[str, ...]]:
    """Gravity [m/s^2], and a finding when nobody said what it is where the test was made.

    **Raises:** `ValueError` for what is no gravity on Earth, in m/s^2.
    """
    if gravity is None:
        return STANDARD_GRAVITY, (
            f"Gravity is taken as the standard {STANDARD_GRAVITY} m/s^2; where the sensor stood it "
            "is up to 0.3 % less or more, and the scale factor with it: give it with --gravity.",
        )
    if not (math.isfinite(gravity) and 9.7 < gravity < 9.9):
        hint = " (not in g)" if gravity == 1 else ""
        raise ValueError(
            f"--gravity is {gravity:g}; give the local one in m/s^2{hint}, which is 9.76 to 9.84 "
            "everywhere on Earth."
        )
    return float(gravity), ()


def refuse_wrong_unit(name: str, unit: str, size: float, gravity: float) -> None:
    """Refuse readings [m/s^2] whose `size` under gravity is nothing like gravity.

    **Raises:** `ValueError` that says in which unit it would be, if in any.
    """
    if abs(size / gravity - 1) < _LARGEST_SCALE_ERROR:
        return
    own = _UNITS.get(unit)
    fits = [
        other
        for other, factor in _UNITS.items()
        if own is not None and abs(size / own * factor / gravity - 1) < _LARGEST_SCALE_ERROR
    ]
    hint = f"; it would be in {fits[0]}: if so, give --unit {fits[0]}" if fits else ""
    shown = size if own is None else size / own
    raise ValueError(
        f"{name} feels {shown:.4g} {unit if own is not None else 'm/s^2'} under gravity, which is "
        f"not gravity{hint or '; check the unit and the positions'}."
    )
