"""Placing a legend where it hides nothing, and what is drawn where."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.legend import Legend
from matplotlib.lines import Line2D

Drawn = Line2D | LineCollection

_MARGIN = 0.02  # in fractions of the axes: a legend keeps clear of the frame and of what is drawn
_BETWEEN = 50  # points that stand for a stretch of a line or for a bar
_STEP = 0.03  # of the height, by which the frame grows


def seen(axes: Axes, artists: Sequence[Drawn]) -> Float[np.ndarray, "points 2"]:
    """What lines, marks and bars cover, as points in fractions of the axes, beyond them too.

    The axes must have their limits.
    """
    to_axes = axes.transData + axes.transAxes.inverted()
    found = [np.empty((0, 2))]
    for artist in artists:
        if isinstance(artist, LineCollection):
            # An end that is undefined is left out of its bar.
            bars = [each for each in artist.get_segments() if len(each) == 2]
            ends = np.array(bars, dtype=float).reshape(-1, 2, 2)
        else:
            marks = np.asarray(artist.get_xydata(), dtype=float)
            marks = marks[np.isfinite(marks).all(axis=1)]
            ends = np.stack([marks[:-1], marks[1:]], axis=1)
            if artist.get_linestyle() == "None":
                ends = np.stack([marks, marks], axis=1)
        ends = ends[np.isfinite(ends).all(axis=(1, 2))]
        begin, end = (to_axes.transform(ends[:, side]) for side in (0, 1))
        along = np.linspace(0, 1, _BETWEEN)[:, None, None]
        found.append((begin + along * (end - begin)).reshape(-1, 2))
    return np.concatenate(found)


def place_legend(axes: Axes, handles: Mapping[str, Any], drawn: Sequence[Drawn]) -> Legend:
    """A legend of `handles` by their names where nothing is `drawn`.

    Where no corner and no edge is free, the frame grows at the top until one is. The axes must
    have their limits.
    """
    # The ground hides the grid.
    frame = {"frameon": True, "framealpha": 0.75, "edgecolor": "none", "borderaxespad": 0.0}
    legend = axes.legend(list(handles.values()), list(handles), loc="upper right", **frame)
    for text in legend.get_texts():
        text.set_parse_math(False)
    box = legend.get_window_extent().transformed(axes.transAxes.inverted())
    right, top = 1 - _MARGIN - box.width, 1 - _MARGIN - box.height
    spots = [
        *((x, y) for y in (top, _MARGIN) for x in (right, _MARGIN)),
        *((right / 2, y) for y in (top, _MARGIN)),
        *((x, top / 2) for x in (right, _MARGIN)),
    ]
    taken = seen(axes, drawn)
    for growth in np.arange(1.0, 1 / max(top - _MARGIN, _STEP) + _STEP, _STEP):
        left = taken / [1.0, growth]
        free = [spot for spot in spots if not _inside(left, spot, (box.width, box.height))]
        if free:
            legend.set_loc(free[0])
            _grow(axes, growth)
            break
    return legend


def _inside(
    points: Float[np.ndarray, "points 2"], corner: tuple[float, float], size: tuple[float, float]
) -> bool:
    """Whether any of the points is in a box, or as near to it as the margin."""
    low = np.array(corner) - _MARGIN
    high = np.array(corner) + size + _MARGIN
    return bool(((points > low) & (points < high)).all(axis=1).any())


def _grow(axes: Axes, growth: float) -> None:
    """The frame as many times as high, from the bottom, on whatever scale."""
    ends = axes.transAxes.transform([[0.0, 0.0], [0.0, growth]])
    bottom, top = axes.transData.inverted().transform(ends)[:, 1].tolist()
    axes.set_ylim(bottom, top)
