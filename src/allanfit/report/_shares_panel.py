"""Drawing where in the recording each coefficient comes from."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ._panels import COLOURS, style

_WIDTH_INCHES = 7.2
_PANEL_INCHES = 0.95
_MARGIN_INCHES = (0.60, 0.10, 0.42, 0.06)  # left, right, bottom, top
_GAP_INCHES = 0.08
_PALENESS = 0.62  # of the pieces that do not stand out: told apart in grey print too
_ROOM_ABOVE = 1.25
_TIME_UNITS = ((36000.0, 3600.0, "h"), (600.0, 60.0, "min"), (0.0, 1.0, "s"))


def draw_shares(channel: Mapping[str, Any]) -> Figure:
    """One axes a term: the share of each piece, the expected share, triangles on what stands out.

    Shares are in per cent of the term's square (of the ramp itself).
    """
    entry = channel["influence"]
    symbols = list(entry["share"])
    left, right, bottom, top = _MARGIN_INCHES
    height = bottom + top + len(symbols) * _PANEL_INCHES + (len(symbols) - 1) * _GAP_INCHES
    with style():
        sheet = Figure(figsize=(_WIDTH_INCHES, height))
        panels = sheet.subplots(len(symbols), 1, sharex=True, squeeze=False)[:, 0]
        sheet.subplots_adjust(
            left=left / _WIDTH_INCHES,
            right=1 - right / _WIDTH_INCHES,
            bottom=bottom / height,
            top=1 - top / height,
            hspace=_GAP_INCHES / _PANEL_INCHES,
        )
        time, unit = time_axis(entry["time_s"])
        for axes, symbol in zip(panels, symbols, strict=True):
            rows = (entry[key][symbol] for key in ("share", "expected", "stands_out"))
            _draw_term(axes, symbol, time, *map(np.asarray, rows))
            axes.yaxis.set_label_coords(-0.45 / _WIDTH_INCHES, 0.5)
        panels[-1].set_xlabel(f"time in the recording [{unit}]")
        panels[0].set_xlim(time[0], time[-1])
        return sheet


def time_axis(edges: list[float]) -> tuple[np.ndarray, str]:
    """Times in the largest unit that they fill, and its name."""
    size, unit = time_unit(edges[-1])
    return np.array(edges) / size, unit


def time_unit(longest: float) -> tuple[float, str]:
    """The largest unit that a time fills, in seconds, and its name."""
    _, size, unit = next(each for each in _TIME_UNITS if longest >= each[0])
    return size, unit


def _draw_term(
    axes: Axes,
    symbol: str,
    time: np.ndarray,
    share: np.ndarray,
    expected: np.ndarray,
    stands_out: np.ndarray,
) -> None:
    colour = COLOURS.get(symbol, "black")
    pale = tuple(_PALENESS + (1 - _PALENESS) * channel for channel in to_rgb(colour))
    axes.bar(
        time[:-1],
        100 * share,
        np.diff(time),
        align="edge",
        color=[colour if marked else pale for marked in stands_out],
        linewidth=0,
        zorder=2,
    )
    axes.axhline(0.0, color="black", linewidth=0.6, zorder=2.5)
    axes.stairs(100 * expected, time, baseline=None, color="black", linewidth=0.9, zorder=3)
    middle = (time[:-1] + time[1:]) / 2
    top = 100 * np.maximum(np.maximum(share, expected), 0.0)
    low, high = min(0.0, 100 * float(share.min())), float(top.max())
    room = 0.06 * (high - low)
    axes.plot(
        middle[stands_out], top[stands_out] + room, "v", color="black", markersize=3, zorder=4
    )
    axes.set_ylim(_ROOM_ABOVE * low, low + _ROOM_ABOVE * (high - low))
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.set_ylabel("share [%]")
    axes.text(
        0.012,
        0.9,
        symbol,
        transform=axes.transAxes,
        color=colour,
        fontweight="bold",
        va="top",
        bbox={"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": "none"},
        zorder=5,
    )
