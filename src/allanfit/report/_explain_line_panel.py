"""Drawing the spectrum close to one line of it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..formatting import reading, significant
from ._explain_panels import AFTER, BEFORE
from ._panels import DATA_COLOUR, positive, say_empty, style
from ._units import squared_per_hertz, typeset

_SIZE_INCHES = (2.9, 2.3)
_NARROW_HZ = 0.5


def draw_line(
    line: Mapping[str, Any], unit: str, effects: Sequence[Mapping[str, Any]] = ()
) -> Figure:
    """The density at full resolution around a line, with the better model in blue.

    Its frequency has the digits that its interval has among the parameters of the `effects`.
    """
    size = len(line["frequency_hz"])
    offset = np.array(line["frequency_hz"], dtype=float) - line["line_hz"]
    narrow = bool(size) and float(np.abs(offset).max()) < _NARROW_HZ
    offset *= 1e3 if narrow else 1.0
    density, model = positive(line["density"], size), positive(line["model"], size)
    with style():
        sheet = Figure(figsize=_SIZE_INCHES)
        axes = sheet.subplots()
        sheet.subplots_adjust(left=0.27, right=0.965, bottom=0.18, top=0.9)
        axes.set_title(_frequency(line["line_hz"], effects))
        axes.set_xlabel(f"frequency less this [{'mHz' if narrow else 'Hz'}]")
        axes.set_ylabel(f"density [{typeset(squared_per_hertz(unit))}]", parse_math=False)
        if not np.isfinite(density).any():
            say_empty(axes)
            return sheet
        axes.set_yscale("log")
        axes.axvline(0.0, color=BEFORE["color"], linestyle=":", linewidth=0.9)
        points: dict[str, Any] = {"markersize": 2.2, "markeredgewidth": 0, "linewidth": 0.5}
        axes.plot(offset, density, "o-", color=DATA_COLOUR, **points)
        if np.isfinite(model).any():
            axes.plot(offset, model, **AFTER)
        axes.xaxis.set_major_locator(MaxNLocator(4))
        axes.margins(x=0.02)
        return sheet


def _frequency(line_hz: float, effects: Sequence[Mapping[str, Any]]) -> str:
    for effect in effects:
        told = effect["parameters"].get("frequency") or {}
        interval = (told.get("intervals") or {}).get("0.95")
        if interval and told["value"] == line_hz:
            return f"{reading(line_hz, interval, 'Hz').value} Hz"
    return f"{significant(line_hz, 6)} Hz"
