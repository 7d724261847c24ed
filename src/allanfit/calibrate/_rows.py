"""The results as a list of rows, which the terminal and the page both print."""

from typing import NamedTuple

from ..formatting import Reading, reading
from ..recording._units import parse_unit
from ._result import AxisCalibration, Calibration, Procedure, Quantity

_FIELD_UNIT = {"rate-table": "deg/s", "up-down": "mg", "multi-position": "mg"}
_MICRO = 1e6
# Half-widths from which a scale factor is read in per cent and not in parts per million.
_COARSE = 1e-3


class Row(NamedTuple):
    """One quantity, in one unit or several."""

    label: str
    readings: tuple[Reading, ...]
    state: str
    """`significant`, `not significant`, or "" where there is no interval or no such question."""


def axis_rows(axis: AxisCalibration, procedure: Procedure) -> list[Row]:
    """Bias and scale factor of one axis."""
    rows = [Row("bias", _bias(axis.bias, procedure), _state(axis.bias))]
    if axis.bias_of_these_recordings is not None:
        while_recording = _bias(axis.bias_of_these_recordings, procedure)
        rows.append(Row("as recorded", while_recording, ""))
    return [*rows, Row("scale factor", (_scale(axis.scale_factor),), _state(axis.scale_factor))]


def misalignment_rows(found: Calibration) -> list[Row]:
    """The angles between the axes."""
    return [
        Row(name, (_read(angle.scaled(1e3, "mrad")),), _state(angle))
        for name, angle in found.misalignment.items()
    ]


def _bias(bias: Quantity, procedure: Procedure) -> tuple[Reading, ...]:
    field, unit = parse_unit(_FIELD_UNIT[procedure]), parse_unit(bias.unit)
    if unit.kind != field.kind or unit.factor == field.factor:
        return (_read(bias),)
    return _read(bias), _read(bias.scaled(unit.factor / field.factor, field.name))


def _scale(scale: Quantity) -> Reading:
    interval = scale.intervals["0.95"]
    coarse = abs(scale.value) if interval is None else (interval[1] - interval[0]) / 2
    if coarse >= _COARSE:
        return _read(scale.scaled(100.0, "%"))
    return _read(scale.scaled(_MICRO, "ppm"))


def _read(quantity: Quantity) -> Reading:
    return reading(quantity.value, quantity.intervals["0.95"], quantity.unit)


def _state(quantity: Quantity) -> str:
    if quantity.significant is None:
        return ""
    return "significant" if quantity.significant else "not significant"
