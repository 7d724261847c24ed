"""Drawing a curve and its residuals with matplotlib."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, NamedTuple

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from ..formatting import Number
from ._labels import label_lines
from ._legend import place_legend
from ._units import squared_per_hertz, typeset

# Okabe and Ito's palette, which people with any common colour blindness tell apart. Terms that
# are neighbours on the curve have colours that also differ in lightness.
COLOURS = {"Q": "#CC79A7", "N": "#0072B2", "B": "#009E73", "K": "#D55E00", "R": "#E69F00"}
DATA_COLOUR = "#4D4D4D"
BAR_COLOUR = "#B3B3B3"
BAND_COLOUR = "#E6E6E6"
# In standard deviations: within it, the interval of a point holds the model.
BAND_95 = 1.959964
# Where a document keeps the points of each curve.
POINTS = {"allan": ("tau_s", "deviation"), "psd": ("frequency_hz", "density")}
_COLUMN_INCHES = (3.5, 4.6)  # one column of a journal
_MARGIN_INCHES = (0.60, 0.10, 0.45, 0.06)  # left, right, bottom, top
_TITLE_INCHES = 0.25
_LABEL_POSITION = -0.15  # of the y labels, in widths of their axes
_ROOM_BELOW_DATA = 3.0
# The ratio of the ends of an interval that one ordinate has and two have not, and how far below a
# model one may be seen.
_VAGUE, _FAR_BELOW = 1e3, 1e3
_LARGEST_LINEAR_RESIDUAL = 20.0

_STYLE = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 9,
    "axes.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.grid.which": "both",
    "grid.color": "#ECECEC",
    "grid.linewidth": 0.4,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.minor.top": False,
    "ytick.minor.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "pdf.fonttype": 42,
    # Letters as paths look the same everywhere; the salt makes identifiers repeatable.
    "svg.fonttype": "path",
    "svg.hashsalt": "allanfit",
}


def style() -> AbstractContextManager[None]:
    """The settings of the figures, whatever the user's own configuration says."""
    return matplotlib.style.context(["default", _STYLE])


class Curve(NamedTuple):
    """One statistic of one channel, undefined entries as NaN."""

    x: np.ndarray
    data: np.ndarray
    model: np.ndarray
    low: np.ndarray
    high: np.ndarray
    terms: dict[str, np.ndarray]
    x_label: str
    y_label: str

    def terms_in_sight(self) -> dict[str, np.ndarray]:
        """The terms that are within the limits of the figure anywhere."""
        _, (bottom, _) = curve_limits(self)
        return {
            name: values
            for name, values in self.terms.items()
            if np.isfinite(values).any() and np.nanmax(values) > bottom
        }

    def residual(self) -> np.ndarray:
        """log(data / model) in standard deviations: beyond 1.96 where the band misses the model.

        The band is taken on the side of the model, since few averages make it lopsided.
        """
        side = np.where(self.model > self.data, self.high / self.data, self.data / self.low)
        deviation = np.log(side) / BAND_95
        return np.log(self.data / self.model) / np.where(deviation > 0, deviation, np.nan)


def positive(numbers: Sequence[Number | None] | None, size: int) -> np.ndarray:
    """As an array with NaN for what a logarithmic axis cannot show."""
    if not numbers:
        return np.full(size, np.nan)
    array = np.array(numbers, dtype=float)
    return np.where(array > 0, array, np.nan)


def axis_labels(kind: str, unit: str) -> tuple[str, str]:
    """What stands along both axes of a curve ("allan" or "psd") of a channel in `unit`."""
    if kind == "allan":
        x_label = "averaging time \N{GREEK SMALL LETTER TAU} [s]"
        return x_label, "Allan deviation" + (f" [{typeset(unit)}]" if unit else "")
    return "frequency [Hz]", f"power spectral density [{typeset(squared_per_hertz(unit))}]"


def load_curve(channel: Mapping[str, Any], kind: str) -> Curve:
    """A curve ("allan" or "psd") of a channel of a fit document."""
    entry = channel["curves"][kind]
    x_key, data_key = POINTS[kind]
    x, data = entry[x_key], entry[data_key]
    x_label, y_label = axis_labels(kind, channel["unit"])
    size = len(x)
    low, high = entry.get("band_95") or (None, None)
    terms = {name: positive(values, size) for name, values in (entry.get("terms") or {}).items()}
    return Curve(
        x=positive(x, size),
        data=positive(data, size),
        model=positive(entry["model"], size),
        low=positive(low, size),
        high=positive(high, size),
        terms=terms,
        x_label=x_label,
        y_label=y_label,
    )


def draw(channel: Mapping[str, Any], curves: Sequence[str], title: bool) -> Figure:
    """The curves ("allan", "psd") of a channel side by side, each above its residuals."""
    with style():
        sheet, panels = empty_sheet(len(curves), _TITLE_INCHES if title else 0.0)
        if title:
            sheet.suptitle(channel["channel"], fontsize=9, fontweight="bold", parse_math=False)
        for column, kind in enumerate(curves):
            curve = load_curve(channel, kind)
            _draw_curve(panels[0, column], curve, channel["coefficients"])
            _draw_residuals(panels[1, column], curve)
        return sheet


def empty_sheet(
    columns: int, room_for_title: float = 0.0, heights: tuple[float, float] = (3, 1)
) -> tuple[Figure, np.ndarray]:
    """An empty figure with two axes a column, one above the other, of these relative heights.

    Margins are fixed, since labels are of one size: a layout engine would draw everything twice.
    """
    width, height = _COLUMN_INCHES
    left, right, bottom, top = _MARGIN_INCHES
    sheet = Figure(figsize=(width * columns, height))
    panels = sheet.subplots(
        2,
        columns,
        sharex="col",
        squeeze=False,
        gridspec_kw={
            "height_ratios": heights,
            "left": left / (width * columns),
            "right": 1 - right / (width * columns),
            "bottom": bottom / height,
            "top": 1 - (top + room_for_title) / height,
            "hspace": 0.06,
            "wspace": (left + right) / (width - left - right),
        },
    )
    for axes in panels.flat:
        axes.yaxis.set_label_coords(_LABEL_POSITION, 0.5)
    return sheet, panels


def _draw_curve(axes: Axes, curve: Curve, coefficients: Mapping[str, Any]) -> None:
    axes.set_ylabel(curve.y_label, parse_math=False)
    if not np.isfinite(curve.data).any():
        axes.set_xticks([])
        say_empty(axes)
        return
    axes.set_xscale("log")
    axes.set_yscale("log")
    # Bars rather than a filled band, which would claim to know the curve between the points.
    bars = axes.vlines(curve.x, curve.low, curve.high, color=BAR_COLOUR, linewidth=0.9, zorder=2)
    (points,) = axes.plot(
        curve.x, curve.data, "o", color=DATA_COLOUR, markersize=2.6, markeredgewidth=0, zorder=3
    )
    (fit,) = axes.plot(curve.x, curve.model, color="black", zorder=2.8)
    across, along = curve_limits(curve)
    axes.set_xlim(across)
    axes.set_ylim(along)
    lines = {}
    for name, values in curve.terms_in_sight().items():
        (lines[name],) = axes.plot(
            curve.x,
            values,
            color=COLOURS.get(name, "black"),
            linestyle="--" if coefficients[name]["resolved"] else ":",
            zorder=2.5,
        )
    handles = {"data, 95 % interval": (bars, points), "fit": fit}
    for name, line in lines.items():
        doubt = "" if coefficients[name]["resolved"] else " (not resolved)"
        handles[f"{name}  {coefficients[name]['name']}{doubt}"] = line
    legend = place_legend(axes, handles, (points, bars, fit, *lines.values()))
    label_lines(axes, lines, (points, fit), bars, legend)


def framed(data: np.ndarray, low: np.ndarray, high: np.ndarray, *models: np.ndarray) -> np.ndarray:
    """The data that limits have to hold.

    A single ordinate may be nothing by chance, and then say nothing: decades below all models it
    gets no room, and its bar is cut off.
    """
    lowest = np.fmin.reduce(models)
    chance = (high > _VAGUE * low) & (data < lowest / _FAR_BELOW)
    return np.where(chance, lowest / _FAR_BELOW, data)


def curve_limits(curve: Curve) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits in x and y that frame the data; below, room to see terms smaller than their sum."""
    shown = np.concatenate([curve.data, curve.model, curve.high])
    data = framed(curve.data, curve.low, curve.high, curve.model)
    bottom = np.nanmin(np.concatenate([data, curve.model])) / _ROOM_BELOW_DATA
    return (
        (float(np.nanmin(curve.x)) / 1.3, float(np.nanmax(curve.x)) * 1.3),
        (float(bottom), float(np.nanmax(shown)) * 1.5),
    )


def _draw_residuals(axes: Axes, curve: Curve) -> None:
    axes.set_xlabel(curve.x_label)
    axes.set_ylabel("residual [\N{GREEK SMALL LETTER SIGMA}]")
    residual = curve.residual()
    if not np.isfinite(residual).any():
        say_empty(axes)
        return
    axes.axhspan(-BAND_95, BAND_95, color=BAND_COLOUR, linewidth=0)
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.plot(curve.x, residual, "o", color=DATA_COLOUR, markersize=2.6, markeredgewidth=0)
    limit = max(4.0, 1.15 * float(np.nanmax(np.abs(residual))))
    if limit > _LARGEST_LINEAR_RESIDUAL:
        # A gross misfit would flatten everything else on a linear axis.
        limit *= 1.5
        axes.set_yscale("symlog", linthresh=10.0, linscale=1.0)
        powers = 10.0 ** np.arange(1, int(np.log10(limit)) + 1)
        axes.set_yticks([*-powers[::-1], 0.0, *powers])
        axes.yaxis.set_minor_locator(NullLocator())
    else:
        axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 4, 5, 10]))
    axes.set_ylim(-limit, limit)


def say_empty(axes: Axes) -> None:
    """Words in place of points."""
    axes.grid(visible=False)
    axes.set_yticks([])
    axes.text(0.5, 0.5, "no data", transform=axes.transAxes, ha="center", va="center")
