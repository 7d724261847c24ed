"""Drawing a curve with both models, and the ratio of recording to model below it."""

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter, NullLocator
from scipy.optimize import isotonic_regression

from ._explain_words import label
from ._legend import place_legend
from ._panels import (
    BAND_COLOUR,
    BAR_COLOUR,
    DATA_COLOUR,
    POINTS,
    axis_labels,
    empty_sheet,
    framed,
    positive,
    say_empty,
    style,
)

# Okabe and Ito's palette again; dashes and open marks tell the models apart in grey print too.
BEFORE: dict[str, Any] = {"color": "#D55E00", "linestyle": "--"}
AFTER: dict[str, Any] = {"color": "#0072B2", "linestyle": "-"}
SIMULATION: dict[str, Any] = {"color": "#000000", "linestyle": "-."}
SHADE: dict[str, Any] = {"color": "#F0E442", "alpha": 0.45, "linewidth": 0}
_NUMBERED = re.compile(r" \d+$")
EFFECT_COLOURS = ("#009E73", "#CC79A7", "#56B4E9", "#E69F00")
_HEIGHTS = (2.1, 1.3)
_NUMBERS_INCHES = 0.12
_ROOM_BELOW_DATA = 3.0
# And so much at most where an effect is as weak: less than that is nothing beside the others.
_MOST_ROOM_BELOW_DATA = 30.0
_ROOM_BELOW_PEAK = 2.0
_NARROWEST = 0.012  # of a shaded band, in widths of the axes: a line in a spectrum has none
# Allan variance feels a frequency f most at the averaging time _FELT/f, where the transfer function
# sin^4(pi f tau)/(pi f tau)^2 has its maximum.
_FELT = 0.371
_SEEN_AT = {"tau": ("frequency",)}
# Widths of the axes that a digit of a number takes, and that tell a number from the next.
_DIGIT, _APART = 0.025, 0.02
_LARGEST_LINEAR_RATIO = 2.5
LARGEST_FINE_RATIO = 60.0


class ExplainedCurve(NamedTuple):
    """One statistic of one channel with both models, undefined entries as NaN."""

    x: np.ndarray
    data: np.ndarray
    before: np.ndarray
    after: np.ndarray
    simulation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    effects: dict[str, np.ndarray]  # by name, only those that the curve shows
    x_label: str
    y_label: str

    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Limits in x and y that frame the data; below, room to see the effects."""
        models = self.before, self.after, self.simulation
        levels = np.concatenate([framed(self.data, self.low, self.high, *models), *models])
        top = 2.0 * np.nanmax(np.concatenate([levels, self.high]))
        lowest = float(np.nanmin(levels))
        # A line in one bin of a spectrum is spread over all of it.
        peaks = [float(np.nanmax(each)) / _ROOM_BELOW_PEAK for each in self.effects.values()]
        faintest = max(min(peaks, default=lowest), lowest / _MOST_ROOM_BELOW_DATA)
        return (
            (float(np.nanmin(self.x)) / 1.3, float(np.nanmax(self.x)) * 1.3),
            (min(lowest / _ROOM_BELOW_DATA, faintest), float(top)),
        )

    def effects_in_sight(self) -> dict[str, np.ndarray]:
        """The effects that are within the limits anywhere."""
        _, (bottom, _) = self.limits()
        return {name: each for name, each in self.effects.items() if np.nanmax(each) > bottom}

    def ratio_range(self) -> tuple[float, float]:
        """The smallest and the largest ratio of recording to model, and one."""
        models = (self.before, self.after, self.simulation)
        data = framed(self.data, self.low, self.high, *models)
        ratios = np.concatenate([*(data / each for each in models), [1.0]])
        return float(np.nanmin(ratios)), float(np.nanmax(ratios))


def load_explained(channel: Mapping[str, Any], kind: str) -> ExplainedCurve:
    """A curve ("allan" or "psd") of a channel of an explanation."""
    entry = (channel["curves"] or {}).get(kind) or {}
    x_key, data_key = POINTS[kind]
    size = len(entry.get(x_key) or ())
    x, data, before, after, simulation = (
        positive(entry.get(key), size)
        for key in (x_key, data_key, "model_before", "model_after", "simulation")
    )
    if channel["verdict"] == "consistent":
        after = np.full(size, np.nan)  # there is no better model
    low, high = (positive(each, size) for each in entry.get("band_95") or (None, None))
    parts = {name: positive(values, size) for name, values in (entry.get("effects") or {}).items()}
    effects = _whole_effects(channel, kind, parts)
    labels = axis_labels(kind, channel["unit"])
    return ExplainedCurve(x, data, before, after, simulation, low, high, effects, *labels)


def _whole_effects(
    channel: Mapping[str, Any], kind: str, parts: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """The curves of effects by their names in a legend, only those that show anything.

    A numbered part of an effect that is named once, as of a line that wanders, adds to the others.
    """
    named = Counter(each["name"] for each in channel["effects"])
    power = 2 if kind == "allan" else 1
    found: dict[str, np.ndarray] = {}
    for part, values in parts.items():
        if not np.isfinite(values).any():
            continue
        whole = _NUMBERED.sub("", part)
        name = label(whole if named[whole] == 1 else part)
        if name in found:
            both = np.nan_to_num([found[name], values]) ** power
            found[name] = positive((both.sum(axis=0) ** (1 / power)).tolist(), len(values))
        else:
            found[name] = values
    return found


def draw_curve(channel: Mapping[str, Any], kind: str) -> Figure:
    """A curve ("allan" or "psd") of a channel with both models, above recording / model."""
    curve = load_explained(channel, kind)
    x = curve.x
    with style():
        sheet, panels = empty_sheet(1, _NUMBERS_INCHES, _HEIGHTS)
        upper, lower = panels[:, 0]
        upper.set_ylabel(curve.y_label, parse_math=False)
        lower.set_xlabel(curve.x_label)
        lower.set_ylabel("recording / model")
        if not np.isfinite(curve.data).any():
            upper.set_xticks([])
            say_empty(upper)
            say_empty(lower)
            return sheet
        upper.set_xscale("log")
        upper.set_yscale("log")
        across, along = curve.limits()
        upper.set_xlim(across)
        bars = upper.vlines(x, curve.low, curve.high, color=BAR_COLOUR, linewidth=0.9, zorder=2)
        (points,) = upper.plot(x, curve.data, "o", zorder=3, **_points())
        handles: dict[str, Any] = {"recording, 95 % interval": (bars, points)}
        # The dashes on top, so that both show where the models are one.
        for name, model, look, order in (
            ("five terms", curve.before, BEFORE, 2.9),
            ("better model", curve.after, AFTER, 2.8),
            ("simulation", curve.simulation, SIMULATION, 2.95),
        ):
            if np.isfinite(model).any():
                (handles[name],) = upper.plot(x, model, zorder=order, **look)
        for index, (name, effect) in enumerate(curve.effects_in_sight().items()):
            colour = EFFECT_COLOURS[index % len(EFFECT_COLOURS)]
            # A line in one bin has zeros beside it, and would show as no line at all.
            shown = np.where(np.isfinite(effect), effect, along[0] / 1e3)
            line = upper.plot(x, shown, color=colour, linestyle=":", linewidth=1.4)
            handles[name] = line[0]
        upper.set_ylim(along)
        place_legend(upper, handles, (bars, *upper.lines))
        _draw_ratio(lower, curve)
        domain = "tau" if kind == "allan" else "frequency"
        shade(channel, domain, (upper, lower))
        return sheet


def _points() -> dict[str, Any]:
    return {"color": DATA_COLOUR, "markersize": 2.6, "markeredgewidth": 0}


def _draw_ratio(axes: Axes, curve: ExplainedCurve) -> None:
    """A point in the grey band has a 95 % interval that holds the model."""
    x, data = curve.x, curve.data
    axes.fill_between(x, data / curve.high, data / curve.low, color=BAND_COLOUR, linewidth=0)
    axes.axhline(1.0, color="black", linewidth=0.8)
    open_mark = {"markerfacecolor": "white", "markeredgewidth": 0.7, "markersize": 3.2}
    axes.plot(x, data / curve.before, "D", color=BEFORE["color"], **open_mark)
    axes.plot(x, data / curve.after, "o", color=AFTER["color"], markersize=2.8, markeredgewidth=0)
    if np.isfinite(curve.simulation).any():
        axes.plot(x, data / curve.simulation, "x", color=SIMULATION["color"], markersize=3.2)
    _scale_ratio(axes, *curve.ratio_range())


def ratio_is_linear(low: float, high: float) -> bool:
    """Whether ratios in this range are best read on a linear axis."""
    return high < _LARGEST_LINEAR_RATIO and low > 1 / _LARGEST_LINEAR_RATIO


def _scale_ratio(axes: Axes, low: float, high: float) -> None:
    """Limits and ticks that stay readable from a few per cent to a line of many decades."""
    if ratio_is_linear(low, high):
        room = max(0.1 * (high - low), 0.03)
        axes.set_ylim(low - room, high + room)
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        return
    axes.set_yscale("log")
    room = (high / low) ** 0.08
    axes.set_ylim(low / room, high * room)
    if high / low < LARGEST_FINE_RATIO:
        decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
        ticks = np.outer(decades, (1, 2, 5)).ravel()
        axes.yaxis.set_major_locator(FixedLocator(ticks.tolist()))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        return
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_formatter(NullFormatter())


class Band(NamedTuple):
    """A stretch of mismatch and where its number in the list stands, in widths of the axes."""

    start: float
    stop: float
    label: str
    place: float


def bands(
    channel: Mapping[str, Any],
    domain: str,
    across: Callable[[np.ndarray], np.ndarray],
    limits: tuple[float, float],
    unit: float = 1.0,
) -> list[Band]:
    """Where recording and model differ in a domain, numbered as in the list.

    What differs in frequency does so at the averaging times that feel it most, too.

    **Arguments**: `across` turns places along the axes, which end at `limits`, into widths of
    the axes; `unit` is the size of their unit.
    """
    found: dict[str, tuple[float, float]] = {}
    for number, entry in enumerate(channel["mismatch"], start=1):
        if entry["domain"] not in (domain, *_SEEN_AT.get(domain, ())):
            continue
        low, high = entry["low"], entry["high"]
        if entry["domain"] != domain:
            low, high = _FELT / high, _FELT / low if low > 0 else np.inf
        ends = np.clip(np.array([low, high]) / unit, *limits)
        low, high = across(ends).tolist()
        middle = (low + high) / 2
        half = max((high - low) / 2, _NARROWEST / 2)
        found[str(number)] = middle - half, middle + half
    places = _places(found)
    return [Band(*span, number, places[number]) for number, span in found.items()]


def _places(spans: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """Where the numbers of such spans stand: each in the middle of its own, if that is free.

    In a span that holds others it stands where none of these is, as near to the middle. Numbers
    that would overlap move apart, in their order, by as little as it takes.
    """
    wanted = {}
    for number, (start, stop) in spans.items():
        at = np.linspace(start, stop, 201)
        for low, high in spans.values():
            if high - low < stop - start:
                at = at[(at < low - _DIGIT / 2) | (at > high + _DIGIT / 2)]
        middle = (start + stop) / 2
        wanted[number] = float(at[np.argmin(np.abs(at - middle))]) if at.size else middle
    order = sorted(wanted, key=lambda number: wanted[number])
    widths = np.array([_DIGIT * len(number) + _APART for number in order])
    widths *= min(1.0, 1 / max(widths.sum(), _DIGIT))
    offset = np.cumsum(widths) - widths / 2
    # Where none overlap, places less their offsets never fall: least squares move them the least.
    free = isotonic_regression([wanted[number] for number in order] - offset).x
    moved = np.clip(free, 0.0, 1 - widths.sum()) + offset
    return dict(zip(order, moved.tolist(), strict=True))


def shade(
    channel: Mapping[str, Any], domain: str, panels: Sequence[Axes], unit: float = 1.0
) -> None:
    """Shade where recording and model differ, with the numbers of the list, the strongest first.

    `unit` is the size of the unit along the axes, which must have their limits.
    """
    upper = panels[0]
    transform = upper.transData + upper.transAxes.inverted()

    def across(x: np.ndarray) -> np.ndarray:
        return transform.transform(np.column_stack([x, np.ones_like(x)]))[:, 0]

    for band in bands(channel, domain, across, upper.get_xlim(), unit):
        place = {"xy": (band.start, 0.0), "width": band.stop - band.start, "height": 1.0}
        for axes in panels:
            axes.add_patch(Rectangle(**place, transform=axes.transAxes, zorder=1.5, **SHADE))
        upper.text(
            band.place,
            1.01,
            band.label,
            transform=upper.transAxes,
            ha="center",
            va="bottom",
            fontweight="bold",
            zorder=5,
        )
