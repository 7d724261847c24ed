"""What a calibration finds: quantities with intervals, an axis, and the whole of it."""

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any, Literal

import numpy as np
from jaxtyping import Float64

from ._intervals import Intervals

SCHEMA = "allanfit.calibrate/1"

Procedure = Literal["up-down", "rate-table", "multi-position"]


@dataclass(frozen=True)
class Quantity:
    """One result in the user's unit, with its intervals at 0.68 and 0.95."""

    value: float
    unit: str
    intervals: Intervals
    """`(low, high)` by level, None where the data give none."""

    @property
    def significant(self) -> bool | None:
        """Whether the 95 % interval excludes zero; None where there is no interval."""
        interval = self.intervals["0.95"]
        return None if interval is None else not interval[0] <= 0 <= interval[1]

    def scaled(self, factor: float, unit: str) -> "Quantity":
        """The same in another unit, one of the old unit being `factor` of the new."""
        intervals = {
            level: None if ends is None else (ends[0] * factor, ends[1] * factor)
            for level, ends in self.intervals.items()
        }
        return Quantity(self.value * factor, unit, intervals)

    def to_dict(self) -> dict[str, Any]:
        """Value, unit and intervals as plain data."""
        return {"value": self.value, "unit": self.unit, "intervals": _plain(self.intervals)}


@dataclass(frozen=True)
class Residuals:
    """What an axis, or the triad, leaves unexplained, for a figure."""

    x: Float64[np.ndarray, " points"]
    x_label: str
    """With its unit in brackets."""
    values: Float64[np.ndarray, " points"]
    unit: str
    groups: tuple[str, ...]
    """What each point belongs to, such as `clockwise`; points of a group look alike."""

    def to_dict(self) -> dict[str, Any]:
        """The points as plain data."""
        return {
            "x": self.x.tolist(),
            "x_label": self.x_label,
            "values": self.values.tolist(),
            "unit": self.unit,
            "groups": list(self.groups),
        }


@dataclass(frozen=True)
class AxisCalibration:
    """Bias B and scale-factor error S of one axis: measured = a + S a + B + noise."""

    bias: Quantity
    scale_factor: Quantity
    bias_of_these_recordings: Quantity | None = None
    """Up-down only: the bias as it was while recording, which white noise alone blurs."""
    per_rate: tuple[dict[str, float], ...] | None = None
    """Rate table only: `rate`, `bias` and `scale_factor` of each pair of readings."""
    residuals: Residuals | None = None

    def to_dict(self) -> dict[str, Any]:
        """The axis in the calibrate JSON."""
        document: dict[str, Any] = {
            "bias": self.bias.to_dict(),
            "scale_factor": self.scale_factor.to_dict(),
            "significant": {
                "bias": self.bias.significant,
                "scale_factor": self.scale_factor.significant,
            },
        }
        if self.bias_of_these_recordings is not None:
            document["bias_of_these_recordings"] = self.bias_of_these_recordings.to_dict()
        if self.per_rate is not None:
            document["per_rate"] = [dict(row) for row in self.per_rate]
        if self.residuals is not None:
            document["residuals"] = self.residuals.to_dict()
        return document


@dataclass(frozen=True)
class Correction:
    """What turns a reading y of the triad into a: a = matrix (y - bias)."""

    matrix: Float64[np.ndarray, "3 3"]
    bias: Float64[np.ndarray, " 3"]
    """In the unit of the readings, as is the corrected reading."""
    unit: str
    axes: tuple[str, ...]
    """The names of the three, in the order of matrix and bias."""

    def __call__(
        self, readings: Float64[np.ndarray, "*batch 3"]
    ) -> Float64[np.ndarray, "*batch 3"]:
        """Corrected readings."""
        return (readings - self.bias) @ self.matrix.T

    def to_dict(self) -> dict[str, Any]:
        """Matrix and bias as lists."""
        return {
            "matrix": self.matrix.tolist(),
            "bias": self.bias.tolist(),
            "unit": self.unit,
            "axes": list(self.axes),
        }


@dataclass(frozen=True)
class Calibration:
    """The deterministic errors of a sensor, from one of the three procedures."""

    procedure: Procedure
    source: str
    """The names of the files, or `data`."""
    description: str
    """What was measured and under which conditions, in one line."""
    intervals: str
    """One sentence: what the intervals stand for."""
    conditions: dict[str, Any]
    """Numbers that went in, in SI: gravity, lengths, latitude."""
    axes: dict[str, AxisCalibration]
    findings: tuple[str, ...]
    """What the reader should know before trusting the numbers, one sentence each."""
    misalignment: dict[str, Quantity] = field(default_factory=dict)
    """Multi-position only: small angles between the axes [rad]."""
    misalignment_convention: str = ""
    correction: Correction | None = None
    residuals: Residuals | None = None
    """Of the triad as a whole, where there are no residuals of each axis."""

    def __getitem__(self, name: str) -> AxisCalibration:
        """The axis of that name; `KeyError` if there is none."""
        return self.axes[name]

    def to_dict(self) -> dict[str, Any]:
        """The calibrate JSON, schema allanfit.calibrate/1, in the unit that the user gave."""
        document: dict[str, Any] = {
            "schema": SCHEMA,
            "procedure": self.procedure,
            "source": self.source,
            "allanfit_version": version("allanfit"),
            "description": self.description,
            "intervals": self.intervals,
            "conditions": dict(self.conditions),
            "axes": {name: axis.to_dict() for name, axis in self.axes.items()},
        }
        if self.misalignment:
            document["misalignment"] = {
                **{name: angle.to_dict() for name, angle in self.misalignment.items()},
                "convention": self.misalignment_convention,
            }
        if self.correction is not None:
            document["correction"] = self.correction.to_dict()
        if self.residuals is not None:
            document["residuals"] = self.residuals.to_dict()
        return {**document, "findings": list(self.findings)}

    def _repr_html_(self) -> str:
        """The axes with their intervals, for a notebook."""
        # The words know this class.
        from ._text import calibration_html

        return calibration_html(self)


def _plain(intervals: Intervals) -> dict[str, list[float] | None]:
    return {level: None if ends is None else list(ends) for level, ends in intervals.items()}
