"""Drawing one quantity over the fleet, in which matplotlib is imported."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from ..formatting import significant
from ..report._panels import BAND_COLOUR, COLOURS, say_empty, style
from ..report._units import typeset
from ._compare import Coefficient, Quantity

_PANEL_INCHES = (2.5, 2.7)
_SHOWN = ("N", "B", "K")
_ODD_COLOUR = "#C00000"
_LIMIT_COLOUR = "#8C8C8C"
_MOST_NAMES = 25  # of devices along the axis; beyond, their numbers
_LABELLED = 6  # outliers named in a panel; all are in the list
_FEW_DECADES = 1.0


def draw_quantity(quantity: Quantity) -> Figure:
    """Side by side N, B and K: a dot a device with its 95 % interval, on a logarithmic axis.

    Triangles are upper limits; the band is the middle of the fleet, give or take what devices
    differ by; outliers are named.
    """
    shown = [each for each in quantity.coefficients if each.symbol in _SHOWN]
    width, height = _PANEL_INCHES
    names = _short(quantity.devices)
    below = 0.12 + 0.06 * max(map(len, names)) if names else 0.45
    with style():
        sheet = Figure(figsize=(width * len(shown), height + below))
        panels = sheet.subplots(1, len(shown), squeeze=False)[0]
        sheet.subplots_adjust(
            left=0.085,
            right=0.99,
            bottom=below / (height + below),
            top=1 - 0.08 / (height + below),
            wspace=0.4,
        )
        for axes, coefficient in zip(panels, shown, strict=True):
            _draw(axes, coefficient)
            if names:
                axes.set_xticks(range(1, len(names) + 1))
                axes.set_xticklabels(names, rotation=90, parse_math=False)
                axes.tick_params("x", which="both", top=False)
            else:
                axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
                axes.set_xlabel("device")
        return sheet


def _short(devices: tuple[str, ...]) -> tuple[str, ...]:
    """The names as labels of ticks, none if there are too many or they are long."""
    if len(devices) > _MOST_NAMES or max(map(len, devices)) > 20:
        return ()
    return devices


def _draw(axes: Axes, coefficient: Coefficient) -> None:
    unit = f" [{typeset(coefficient.unit)}]" if coefficient.unit else ""
    axes.set_ylabel(f"{coefficient.symbol}{unit}", parse_math=False)
    points = coefficient.points
    value = np.array([point.value for point in points])
    x = np.arange(1, len(points) + 1)
    axes.set_xlim(0.3, len(points) + 0.7)
    if not (np.isfinite(value) & (value > 0)).any():
        say_empty(axes)
        return
    axes.set_yscale("log")
    found = coefficient.spread
    if found is not None:
        low, high = np.exp([found.middle - found.tau, found.middle + found.tau])
        axes.axhspan(low, high, color=BAND_COLOUR, linewidth=0, zorder=0.5)
        axes.axhline(np.exp(found.middle), color="black", linewidth=0.8, zorder=1)
    resolved = np.array([point.resolved for point in points])
    odd = np.array([point.outlier for point in points])
    low, high = (np.array([getattr(point, end) for point in points]) for end in ("low", "high"))
    size = 3.6 if len(points) <= 60 else 2.0
    axes.plot(x[~resolved], value[~resolved], "v", color=_LIMIT_COLOUR, markersize=size,
              markeredgewidth=0)  # fmt: skip
    for mine, colour, mark in (
        (resolved & ~odd, COLOURS[coefficient.symbol], "o"),
        (odd, _ODD_COLOUR, "D"),
    ):
        axes.vlines(x[mine], low[mine], high[mine], color=colour, linewidth=0.9)
        axes.plot(x[mine], value[mine], mark, color=colour, markersize=size, markeredgewidth=0)
    for index in np.flatnonzero(odd)[:_LABELLED]:
        left = index < len(points) / 2
        axes.annotate(
            points[index].device,
            (x[index], value[index]),
            xytext=(5 if left else -5, 0),
            textcoords="offset points",
            ha="left" if left else "right",
            va="center",
            color=_ODD_COLOUR,
            parse_math=False,
        )
    _label_decades(axes)


def _label_decades(axes: Axes) -> None:
    """Round numbers along an axis that holds too few powers of ten to be read by them."""
    low, high = axes.get_ylim()
    if np.log10(high / low) > _FEW_DECADES:
        return
    axes.yaxis.set_major_locator(FixedLocator(MaxNLocator(5).tick_values(low, high)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: significant(value, 3)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_ylim(low, high)
