"""Drawing a curve with both models, and the ratio of recording to model below it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter, NullLocator

from ._panels import (
    BAND_COLOUR,
    BAR_COLOUR,
    DATA_COLOUR,
    POINTS,
    axis_labels,
    empty_sheet,
    positive,
    say_empty,
    style,
)

# Okabe and Ito's palette again; dashes and open marks tell the models apart in grey print too.
BEFORE: dict[str, Any] = {"color": "#D55E00", "linestyle": "--"}
AFTER: dict[str, Any] = {"color": "#0072B2", "linestyle": "-"}
SHADE: dict[str, Any] = {"color": "#F0E442", "alpha": 0.45, "linewidth": 0}
_EFFECT_COLOURS = ("#009E73", "#CC79A7", "#56B4E9", "#E69F00")
_HEIGHTS = (2.1, 1.3)
_NUMBERS_INCHES = 0.12
_ROOM_BELOW_DATA = 3.0
_NARROWEST = 0.012  # of a shaded band, in widths of the axes: a line in a spectrum has none
_NUMBER_APART = 0.045  # two numbers closer than this would overlap
_LARGEST_LINEAR_RATIO = 2.5
_LARGEST_FINE_RATIO = 60.0


def draw_curve(channel: Mapping[str, Any], kind: str) -> Figure:
    """A curve ("allan" or "psd") of a channel with both models, above recording / model."""
    entry = (channel["curves"] or {}).get(kind) or {}
    x_key, data_key = POINTS[kind]
    size = len(entry.get(x_key) or ())
    x, data, before, after = (
        positive(entry.get(key), size) for key in (x_key, data_key, "model_before", "model_after")
    )
    if channel["verdict"] == "consistent":
        after = np.full(size, np.nan)  # there is no better model
    low, high = (positive(each, size) for each in entry.get("band_95") or (None, None))
    x_label, y_label = axis_labels(kind, channel["unit"])
    with style():
        sheet, panels = empty_sheet(1, _NUMBERS_INCHES, _HEIGHTS)
        upper, lower = panels[:, 0]
        upper.set_ylabel(y_label, parse_math=False)
        lower.set_xlabel(x_label)
        lower.set_ylabel("recording / model")
        if not np.isfinite(data).any():
            upper.set_xticks([])
            say_empty(upper)
            say_empty(lower)
            return sheet
        upper.set_xscale("log")
        upper.set_yscale("log")
        upper.set_xlim(np.nanmin(x) / 1.3, np.nanmax(x) * 1.3)
        bars = upper.vlines(x, low, high, color=BAR_COLOUR, linewidth=0.9, zorder=2)
        (points,) = upper.plot(x, data, "o", zorder=3, **_points())
        handles: dict[str, Any] = {"recording, 95 % interval": (bars, points)}
        # The dashes on top, so that both show where the models are one.
        for name, model, look, order in (
            ("five terms", before, BEFORE, 2.9),
            ("better model", after, AFTER, 2.8),
        ):
            if np.isfinite(model).any():
                (handles[name],) = upper.plot(x, model, zorder=order, **look)
        levels = np.concatenate([data, before, after])
        bottom = np.nanmin(levels) / _ROOM_BELOW_DATA
        for index, (name, values) in enumerate((entry.get("effects") or {}).items()):
            effect = positive(values, size)
            if np.isfinite(effect).any():
                colour = _EFFECT_COLOURS[index % len(_EFFECT_COLOURS)]
                # A line in one bin has zeros beside it, and would show as no line at all.
                shown = np.where(np.isfinite(effect), effect, bottom / 1e3)
                line = upper.plot(x, shown, color=colour, linestyle=":", linewidth=1.4)
                handles[name.replace("_", " ")] = line[0]
        upper.set_ylim(bottom, 2.0 * np.nanmax(np.concatenate([levels, high])))
        # A pale ground: where there is no empty corner, the bars of the data lie behind it.
        frame = {"frameon": True, "framealpha": 0.75, "edgecolor": "none"}
        legend = upper.legend(list(handles.values()), list(handles), loc="best", **frame)
        for text in legend.get_texts():
            text.set_parse_math(False)
        _draw_ratio(lower, x, data, (before, after), (low, high))
        domain = "tau" if kind == "allan" else "frequency"
        shade(channel, domain, (upper, lower))
        return sheet


def _points() -> dict[str, Any]:
    return {"color": DATA_COLOUR, "markersize": 2.6, "markeredgewidth": 0}


def _draw_ratio(
    axes: Axes,
    x: np.ndarray,
    data: np.ndarray,
    models: tuple[np.ndarray, np.ndarray],
    band: tuple[np.ndarray, np.ndarray],
) -> None:
    """A point in the grey band has a 95 % interval that holds the model."""
    before, after = models
    low, high = band
    axes.fill_between(x, data / high, data / low, color=BAND_COLOUR, linewidth=0)
    axes.axhline(1.0, color="black", linewidth=0.8)
    open_mark = {"markerfacecolor": "white", "markeredgewidth": 0.7, "markersize": 3.2}
    axes.plot(x, data / before, "D", color=BEFORE["color"], **open_mark)
    axes.plot(x, data / after, "o", color=AFTER["color"], markersize=2.8, markeredgewidth=0)
    ratios = np.concatenate([data / before, data / after, [1.0]])
    _scale_ratio(axes, float(np.nanmin(ratios)), float(np.nanmax(ratios)))


def _scale_ratio(axes: Axes, low: float, high: float) -> None:
    """Limits and ticks that stay readable from a few per cent to a line of many decades."""
    if high < _LARGEST_LINEAR_RATIO and low > 1 / _LARGEST_LINEAR_RATIO:
        room = max(0.1 * (high - low), 0.03)
        axes.set_ylim(low - room, high + room)
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        return
    axes.set_yscale("log")
    room = (high / low) ** 0.08
    axes.set_ylim(low / room, high * room)
    if high / low < _LARGEST_FINE_RATIO:
        decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
        ticks = np.outer(decades, (1, 2, 5)).ravel()
        axes.yaxis.set_major_locator(FixedLocator(ticks.tolist()))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        return
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_formatter(NullFormatter())


def shade(
    channel: Mapping[str, Any], domain: str, panels: Sequence[Axes], unit: float = 1.0
) -> None:
    """Shade where recording and model differ, with the numbers of the list, the strongest first.

    `unit` is the size of the unit along the axes, which must have their limits.
    """
    taken: list[float] = []
    upper = panels[0]
    across = upper.transData + upper.transAxes.inverted()
    for number, entry in enumerate(channel["mismatch"], start=1):
        if entry["domain"] != domain:
            continue
        bottom, top = upper.get_xlim()
        ends = np.clip((entry["low"] / unit, entry["high"] / unit), bottom, top)
        low, high = (float(across.transform((end, 1.0))[0]) for end in ends)
        middle = (low + high) / 2
        half = max((high - low) / 2, _NARROWEST / 2)
        for axes in panels:
            axes.add_patch(
                Rectangle(
                    (middle - half, 0.0),
                    2 * half,
                    1.0,
                    transform=axes.transAxes,
                    zorder=1.5,
                    **SHADE,
                )
            )
        if all(abs(middle - other) > _NUMBER_APART for other in taken):
            taken.append(middle)
            upper.text(
                middle,
                1.01,
                str(number),
                transform=upper.transAxes,
                ha="center",
                va="bottom",
                fontweight="bold",
                zorder=5,
            )
