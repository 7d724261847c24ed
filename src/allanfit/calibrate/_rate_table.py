"""The rate-table test of a gyroscope: bias and scale factor from constant rates either way."""

import math
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float64

from ..formatting import significant
from ._intervals import student_intervals
from ._line import straight_line
from ._outlier import rounding, stands_out
from ._rate_file import RateData, RatePairs, RateTable, read_rate_table
from ._result import AxisCalibration, Calibration, Quantity, Residuals

#: rad/s against the stars, one turn a sidereal day: IERS Conventions 2010, table 1.1.
EARTH_RATE = 7.292115e-5
# Slopes are within a few per cent of one; columns that were mixed up are not.
_LARGEST_SCALE_ERROR = 0.5
_FEWEST_RATES = 3
_MEANING = (
    "Student's t intervals from the scatter of the readings about one straight line, which "
    "includes whatever bends the line."
)
_EARTH_MEANING = (
    "Student's t intervals from the scatter of repeated readings; none where no reading is "
    "repeated."
)

Reference = Literal["table", "earth"]

_straight_line = jax.jit(straight_line)


def rate_table(
    table: RateData,
    *,
    unit: str | None = None,
    latitude_deg: float | None = None,
    reference: Reference = "table",
) -> Calibration:
    """Bias and scale factor of gyro axes on a rate table, by least squares over all rates.

    Each rate w gives a clockwise reading w1 and a counter-clockwise one w2, a negative number.
    With measured = w + S w + B, the pair alone gives

        B = (w1 + w2)/2,    S = (w1 - w2 - 2 w)/(2 w),

    which are `per_rate`; B and S of all rates together are those of the straight line through the
    signed readings, with Student's t intervals on readings - 2 degrees of freedom.

    The table turns on an Earth that turns: with `latitude_deg`, the clockwise rate w (seen from
    above, on a level table) is w - w_e sin(latitude) against the stars, and -w the other way
    round. Both directions shift alike, so that the Earth is taken out of the bias and leaves the
    scale factor alone. With `reference="earth"` there is no table: each row is a gyro at rest
    with its axis along the vertical, in `cw` where the Earth's rate reads positive (up in the
    north), in `ccw` turned over, and w = w_e |sin(latitude)|.

    **Arguments:**

    - `table`: a CSV file, or columns by name: `rate` (positive) with `cw` and `ccw`, or with a
      pair for each axis, `roll_cw`, `roll_ccw`. Counter-clockwise readings are magnitudes, or
      negative. A unit may stand in a header, `rate [rpm]`.
    - `unit`: rpm, deg/s, rad/s, ... of the columns without a unit of their own.
    - `latitude_deg`: where the table stands, positive in the north [deg].
    - `reference`: "table" or "earth".

    Fewer than three different rates give values without intervals, since a line through two has
    no way to show that it is none.

    **Raises:** `ValueError` for missing columns, what is not a number, a rate of zero or below, a
    copied row, swapped columns, a latitude without a unit, and readings unlike the rates.
    """
    if reference not in ("table", "earth"):
        raise ValueError(f"reference must be 'table' or 'earth'; got {reference!r}.")
    found = read_rate_table(table, unit, signed=reference == "earth")
    earth = _earth_rate(found, latitude_deg, reference)
    rate = _checked_rates(found, earth, reference)
    # Seen against the stars, a table that stands still turns counter-clockwise in the north.
    shift = -earth if reference == "table" else 0.0
    axes, findings = {}, found.findings
    for pairs in found.axes:
        axes[pairs.name], about = _calibrate(pairs, rate, shift, reference)
        findings += about
    distinct = len(np.unique(rate))
    if reference == "table" and distinct < _FEWEST_RATES:
        findings += (
            f"The table has {distinct} different rate{'s' * (distinct > 1)}: no intervals, which "
            f"take at least {_FEWEST_RATES}, since fewer cannot show whether the response is a "
            "straight line.",
        )
    return Calibration(
        procedure="rate-table",
        source=found.name,
        description=_description(found, distinct, latitude_deg, reference),
        intervals=_MEANING if reference == "table" else _EARTH_MEANING,
        conditions={
            "reference": reference,
            "latitude_deg": latitude_deg,
            "earth_rate": None if latitude_deg is None else earth,
        },
        axes=axes,
        findings=findings,
    )


def _earth_rate(table: RateTable, latitude_deg: float | None, reference: Reference) -> float:
    """w_e sin(latitude) [rad/s]; zero if no latitude is given."""
    if latitude_deg is None:
        if reference == "earth":
            raise ValueError("The Earth as the reference takes --latitude, in degrees.")
        return 0.0
    if not abs(latitude_deg) <= 90:
        raise ValueError(f"--latitude is {latitude_deg:g}; give degrees from -90 to 90.")
    if not table.axes[0].unit.name:
        raise ValueError("A latitude takes a unit: give that of the table, as in --unit rpm.")
    return EARTH_RATE * math.sin(math.radians(latitude_deg))


def _checked_rates(
    table: RateTable, earth: float, reference: Reference
) -> Float64[np.ndarray, " rates"]:
    rows = len(table.axes[0].clockwise)
    if reference == "earth":
        if table.rate is not None:
            raise ValueError(
                f"{table.name} has a column rate, and the Earth is to be the reference; leave one "
                "of them out."
            )
        if not abs(earth) > 1e-3 * EARTH_RATE:
            raise ValueError(
                "At the equator the vertical sees nothing of the Earth's rate; use a rate table."
            )
        return np.full(rows, abs(earth))
    if table.rate is None:
        raise ValueError(f"{table.name} has no column rate, the speed of the table for each row.")
    for row, rate in enumerate(table.rate, start=1):
        if not rate > 0:
            raise ValueError(
                f"{table.name}: the rate in row {row} is {'zero' if rate == 0 else 'negative'}; "
                "rates are positive magnitudes, and the columns cw and ccw give the direction."
            )
    columns = [each for axis in table.axes for each in (axis.clockwise, axis.counter_clockwise)]
    whole = np.column_stack([table.rate, *columns])
    copied = rows - len(np.unique(whole, axis=0))
    if copied:
        raise ValueError(
            f"{table.name} holds {copied} row{'s' * (copied > 1)} twice; a copy is no second "
            "measurement: leave it out."
        )
    return table.rate


def _calibrate(
    pairs: RatePairs, rate: Float64[np.ndarray, " rates"], shift: float, reference: Reference
) -> tuple[AxisCalibration, tuple[str, ...]]:
    signed = np.concatenate([rate, -rate]) + shift
    reading = np.concatenate([pairs.clockwise, pairs.counter_clockwise])
    name, factor = pairs.unit.name, pairs.unit.factor
    rounded = rounding(reading / factor) * factor
    with jax.enable_x64(True):
        fitted = _straight_line(jnp.asarray(signed), jnp.asarray(reading), rounded)
        line = jax.tree.map(np.asarray, fitted)
    bias, slope = (float(each) for each in line.value)
    if reference == "table":
        _refuse_mixed_signs(pairs, rate)
        _refuse_mixed_up(pairs, slope)
    told = reference == "earth" or len(np.unique(rate)) >= _FEWEST_RATES
    freedom = len(reading) - 2 if told else 0
    # Numbers that lie on a line exactly are still rounded.
    least = np.finfo(float).eps * np.array([np.abs(signed).max(), 1.0])
    errors = np.maximum(np.sqrt(np.diag(line.covariance)), least)

    def quantity(value: float, error: float) -> Quantity:
        return Quantity(value, "1", student_intervals(value, float(error), freedom))

    axis = AxisCalibration(
        bias=quantity(bias, errors[0]).scaled(1 / factor, name),
        scale_factor=quantity(slope, errors[1]),
        per_rate=tuple(_per_rate(pairs, rate, shift)),
        residuals=Residuals(
            signed / factor,
            "rate" + (f" [{name}]" if name else ""),
            line.residual / factor,
            name,
            ("clockwise",) * len(rate) + ("counter-clockwise",) * len(rate),
        ),
    )
    findings = _about_outlier(pairs, rate, line.studentized) if told else ()
    if reference == "earth":
        findings += _about_turned_over(pairs.name, axis.scale_factor)
    return axis, findings


def _per_rate(
    pairs: RatePairs, rate: Float64[np.ndarray, " rates"], shift: float
) -> list[dict[str, Any]]:
    """Bias and scale factor of each pair alone."""
    rows = []
    for w, w1, w2 in zip(rate, pairs.clockwise, pairs.counter_clockwise, strict=True):
        scale = (w1 - w2 - 2 * w) / (2 * w)
        bias = (w1 + w2) / 2 - (1 + scale) * shift
        factor = pairs.unit.factor
        rows.append(
            {
                "rate": float(w / factor),
                "bias": float(bias / factor),
                "scale_factor": float(scale),
            }
        )
    return rows


def _refuse_mixed_signs(pairs: RatePairs, rate: Float64[np.ndarray, " rates"]) -> None:
    """Magnitudes in some rows and signs in others make a line of no slope."""
    ways = (("clockwise", pairs.clockwise), ("counter-clockwise", pairs.counter_clockwise))
    for way, readings in ways:
        # A bias may turn the sign of a reading that is small beside the rate.
        clear = np.abs(readings) > rate / 2
        if clear.any() and np.ptp(np.sign(readings[clear])) > 0:
            row = int(np.flatnonzero(clear & (np.sign(readings) != np.sign(readings[clear][0])))[0])
            raise ValueError(
                f"{pairs.name}: the {way} readings change their sign in row {row + 1}; give all "
                "of a column as magnitudes, or all with their sign."
            )


def _refuse_mixed_up(pairs: RatePairs, slope: float) -> None:
    if abs(slope) < _LARGEST_SCALE_ERROR:
        return
    if abs(slope + 2) < _LARGEST_SCALE_ERROR:
        raise ValueError(
            f"{pairs.name}: clockwise readings are negative and counter-clockwise ones positive: "
            "the columns are swapped, or the axis points the other way; exchange them."
        )
    raise ValueError(
        f"{pairs.name}: the readings change by {1 + slope:.3g} of the rate, and a sensor's do by "
        "nearly 1: check that rates and readings are in one unit (a header may say `rate [rpm]`), "
        "and give counter-clockwise readings a minus sign."
    )


def _about_turned_over(name: str, scale_factor: Quantity) -> tuple[str, ...]:
    """Whether cw and ccw are exchanged, for a gyro whose readings are mostly bias and noise.

    Noise alone may put the value near -2, but its interval seldom.
    """
    interval = scale_factor.intervals["0.95"]
    if interval is not None and all(abs(end + 2) < _LARGEST_SCALE_ERROR for end in interval):
        raise ValueError(
            f"{name}: the readings change against the Earth's rate: the columns are swapped, or "
            "the axis points the other way; exchange them."
        )
    if abs(scale_factor.value + 2) < _LARGEST_SCALE_ERROR:
        return (
            f"{name}: the readings change against the Earth's rate, unless that is noise: the "
            "columns may be swapped; repeat the readings to tell.",
        )
    return ()


def _about_outlier(
    pairs: RatePairs,
    rate: Float64[np.ndarray, " rates"],
    studentized: Float64[np.ndarray, " readings"],
) -> tuple[str, ...]:
    """The reading that stands out most, if by more than one table in a hundred would show."""
    worst = stands_out(studentized, len(studentized) - 2)
    if worst is None:
        return ()
    way = "clockwise" if worst < len(rate) else "counter-clockwise"
    shown = significant(rate[worst % len(rate)] / pairs.unit.factor)
    return (
        f"{pairs.name}: the {way} reading at {f'{shown} {pairs.unit.name}'.strip()} stands out "
        f"from the line (studentized residual {studentized[worst]:.1f}); repeat it.",
    )


def _description(
    table: RateTable, distinct: int, latitude_deg: float | None, reference: Reference
) -> str:
    readings = 2 * len(table.axes[0].clockwise)
    if reference == "earth":
        return (
            f"the Earth as the reference, {readings} readings an axis, latitude {latitude_deg:g} "
            "deg"
        )
    earth = (
        "Earth's rate not taken out"
        if latitude_deg is None
        else f"Earth's rate taken out at latitude {latitude_deg:g} deg, clockwise seen from above"
    )
    rates = f"{distinct} rate{'s' * (distinct > 1)}"
    return f"{rates}, {readings} readings an axis, {earth}"
