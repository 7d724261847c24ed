"""Drawing a recording against time: its mean and its noise level, and what stands out."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ._explain_panels import AFTER, shade
from ._panels import DATA_COLOUR, say_empty, style
from ._shares_panel import time_unit
from ._units import in_brackets

_WIDTH_INCHES, _HEIGHT_INCHES = 7.2, 3.3
_MARKED = {"color": "#F6CDB0", "linewidth": 0}
_PLAIN_EXPONENTS = range(-2, 4)


def has_time(channel: Mapping[str, Any]) -> bool:
    """Whether anything that happens at a certain time is told."""
    entry = (channel["curves"] or {}).get("time") or {}
    seen = any(each["domain"] == "time" for each in channel["mismatch"])
    return bool(entry.get("time_s")) and bool(seen or entry.get("model") or entry.get("intervals"))


def draw_time(channel: Mapping[str, Any]) -> Figure:
    """Two axes: means of blocks with the deterministic model, and deviations within blocks.

    Marked intervals are orange, stretches of mismatch yellow with their numbers.
    """
    entry = channel["curves"]["time"]
    seconds = np.array(entry["time_s"], dtype=float)
    size, name = time_unit(float(seconds[-1]))
    with style():
        sheet = Figure(figsize=(_WIDTH_INCHES, _HEIGHT_INCHES))
        upper, lower = sheet.subplots(2, 1, sharex=True)
        sheet.subplots_adjust(left=0.1, right=0.985, bottom=0.13, top=0.945, hspace=0.07)
        points = {"color": DATA_COLOUR, "markersize": 2.4, "markeredgewidth": 0}
        for axes, key, label in ((upper, "mean", "mean"), (lower, "deviation", "deviation")):
            values = np.array(entry[key], dtype=float)
            shown = values - np.nanmean(values) if key == "mean" else values
            axes.plot(seconds / size, shown, "o", zorder=3, **points)
            # Beside the unit: above the lower axes there is no room for a power of ten.
            power = _power_of_ten(shown)
            axes.set_ylabel(label + in_brackets(power, channel["unit"]), parse_math=False)
            axes.yaxis.set_label_coords(-0.078, 0.5)
            axes.yaxis.set_major_formatter(_in_units_of(10.0**power))
            if not np.isfinite(values).any():
                say_empty(axes)
        if entry.get("model"):
            model = np.array(entry["model"], dtype=float)
            upper.plot(
                seconds / size, model - np.nanmean(model), zorder=4, label="better model", **AFTER
            )
            upper.legend(loc="best")
        lower.set_xlabel(f"time in the recording [{name}]")
        step = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 1.0
        upper.set_xlim((seconds[0] - step) / size, (seconds[-1] + step) / size)
        for start, stop in entry.get("intervals") or ():
            for axes in (upper, lower):
                axes.axvspan(start / size, stop / size, zorder=1, **_MARKED)
        shade(channel, "time", (upper, lower), size)
        return sheet


def _power_of_ten(values: np.ndarray) -> int:
    """In which numbers along an axes are short; zero for those that are short as they are."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    power = int(np.floor(np.log10(largest))) if largest > 0 else 0
    return 0 if power in _PLAIN_EXPONENTS else power


def _in_units_of(size: float) -> Callable[[float, float], str]:
    return lambda value, _: f"{value / size:.6g}".replace("-", "\N{MINUS SIGN}")
