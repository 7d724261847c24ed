"""Temperatures beside the channels: which columns they are, and in degC."""

import itertools
import re

import numpy as np
from jaxtyping import Float64

from ._lateness import SHORTEST_STRETCH
from ._recording import Channel, Table
from ._timestamps import Clock, time_columns
from ._units import temperature_scale
from ._wording import count, percent

_NAME = re.compile(r"(?:.*[\W_])?temp", re.IGNORECASE)
# No sensor is at rest in a place as hot as that in degC; in kelvin every one is hotter.
_SURELY_KELVIN = 200.0
# A hole longer than this part of the recording may hide what the temperature did there.
_LONGEST_HOLE = 0.05


def is_temperature(name: str, unit: str, table: Table) -> bool:
    """Whether a column holds a temperature: by its name, its unit, or as `T` beside the time."""
    if _NAME.match(name) or temperature_scale(unit) is not None:
        return True
    return name == "T" and any(other != name for other in time_columns(table.columns, table.units))


def read_temperature(
    name: str, values: Float64[np.ndarray, " values"], unit: str, length: int, clock: Clock
) -> tuple[Channel | None, tuple[str, ...]]:
    """A temperature as a channel in degC, or None with the reason.

    Unlike a sensor's samples, missing values are interpolated: a temperature is only ever a slow
    regressor, and logged more rarely than the channels as often as not.
    """
    scale = (1.0, 0.0) if not unit else temperature_scale(unit)
    if scale is None:
        return None, (
            f"The temperature {name} is not used: its unit '{unit}' is none of degC, K and degF.",
        )
    if values.size != length:
        return None, (
            f"The temperature {name} is not used: it has {values.size} values and the channels "
            f"{length} samples; repeat or interpolate it to one value a sample.",
        )
    present = np.flatnonzero(np.isfinite(values))
    hole = int(np.diff(present, prepend=-1, append=length).max()) - 1 if present.size else length
    if present.size < SHORTEST_STRETCH or hole > _LONGEST_HOLE * length:
        return None, (
            f"The temperature {name} is not used: it has {count(int(present.size), 'value')}, and "
            f"{percent(hole / length)} of the recording on end has none.",
        )
    findings = ()
    whole = np.interp(np.arange(length), present, values[present])
    if not unit:
        kelvin = float(np.median(whole)) > _SURELY_KELVIN
        scale = (1.0, -273.15) if kelvin else scale
        what = name if "temp" in name.lower() else f"temperature {name}"
        findings += (
            f"The {what} is taken to be in {'K' if kelvin else 'degC'}: write its unit in the "
            f"file, as in `{name} [degC]`.",
        )
    edges = (0, *clock.breaks, length)
    channel = Channel(
        name=name,
        unit=unit,
        factor=scale[0],
        si_unit="degC",
        kind="temperature",
        samples=whole * scale[0] + scale[1],
        stretches=tuple(pair for pair in itertools.pairwise(edges) if pair[0] < pair[1]),
        findings=findings,
    )
    return channel, findings
