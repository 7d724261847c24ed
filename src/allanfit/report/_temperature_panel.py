"""Drawing a channel's slow changes against temperature, and against time."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ._panels import style
from ._shares_panel import time_axis
from ._units import typeset

_WIDTH_INCHES, _HEIGHT_INCHES = 7.2, 2.9
_TEMPERATURES = 5
_POINT_COLOUR, _CURVE_COLOUR, _BAND_COLOUR = "#4D4D4D", "#D55E00", "#F6CDB0"


def draw_temperature(channel: Mapping[str, Any]) -> Figure:
    """Two axes: means of pieces against temperature with the fitted curve, and against time.

    The band is where the effect at each temperature lies with 95 % probability, against that at
    the mean temperature.
    """
    entry = channel["temperature"]
    slow, curve = entry["slow"], entry["curve"]
    unit = f" [{typeset(channel['unit'])}]" if channel["unit"] else ""
    with style():
        sheet = Figure(figsize=(_WIDTH_INCHES, _HEIGHT_INCHES))
        against, along = sheet.subplots(1, 2, sharey=True)
        sheet.subplots_adjust(left=0.105, right=0.9, bottom=0.16, top=0.91, wspace=0.06)
        against.fill_between(
            curve["temperature_degC"], *curve["band_95"], color=_BAND_COLOUR, linewidth=0
        )
        against.plot(curve["temperature_degC"], curve["effect"], color=_CURVE_COLOUR)
        points = {"color": _POINT_COLOUR, "markersize": 2.6, "markeredgewidth": 0}
        against.plot(slow["temperature_degC"], slow["residual"], "o", **points)
        against.set_xlabel("temperature [°C]")
        # Over little heat numbers have many digits, and more of them would run together.
        against.xaxis.set_major_locator(MaxNLocator(_TEMPERATURES))
        against.set_ylabel(f"slow change{unit}", parse_math=False)
        time, name = time_axis(slow["time_s"])
        (seen,) = along.plot(time, slow["residual"], "o", **points)
        (effect,) = along.plot(time, slow["effect"], color=_CURVE_COLOUR)
        along.set_xlabel(f"time in the recording [{name}]")
        warm = along.twinx()
        (course,) = warm.plot(
            time, slow["temperature_degC"], color="#0072B2", linestyle=":", linewidth=0.9
        )
        warm.set_ylabel("temperature [°C]")
        warm.grid(visible=False)
        # Above the axes: there are two of them, and no corner is empty in both.
        names = ["means", "effect", "temperature"]
        above = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 3}
        along.legend([seen, effect, course], names, **above)
        # The band may be far wider than what is seen, where nothing is known.
        shown = np.array([*slow["residual"], *slow["effect"], *curve["effect"]])
        room = 0.08 * float(np.ptp(shown)) or 1.0
        against.set_ylim(shown.min() - room, shown.max() + room)
        return sheet
