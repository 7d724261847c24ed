"""Placing the letter of each line where the plot is emptiest."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

_MARGIN = 0.05  # in fractions of the axes: letters keep clear of the frame
_FAR_ENOUGH = 0.12  # beyond this distance, more of it makes a place no better
_TOO_CLOSE = 0.02  # the line runs along another, which the letter would hide
_STEPS = 200


def _path(axes: Axes, line: Line2D) -> np.ndarray:
    """The line in fractions of the axes, evenly filled in, only what the frame shows."""
    data = np.asarray(line.get_xydata(), dtype=float)
    data = data[np.isfinite(data).all(axis=1)]
    if not len(data):
        return np.empty((0, 2))
    points = axes.transAxes.inverted().transform(axes.transData.transform(data))
    fine = np.linspace(points[0, 0], points[-1, 0], _STEPS)
    path = np.column_stack([fine, np.interp(fine, points[:, 0], points[:, 1])])
    return path[((path > 0) & (path < 1)).all(axis=1)]


def _distance(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """From each place to the nearest of the others."""
    return np.linalg.norm(places[:, None] - others[None], axis=-1).min(axis=1)


def label_lines(axes: Axes, lines: Mapping[str, Line2D], obstacles: Sequence[Line2D]) -> None:
    """Write each line's name on the line, clear of the other lines, the obstacles and the frame.

    The axes must have their limits, from which distances follow. A line that is
    outside the frame, or everywhere close to another, gets no name.
    """
    paths = {name: _path(axes, line) for name, line in lines.items()}
    taken = [_path(axes, line) for line in obstacles]
    for name, path in paths.items():
        inside = path[((path > _MARGIN) & (path < 1 - _MARGIN)).all(axis=1)]
        if not len(inside):
            continue
        rivals = [other for rival, other in paths.items() if rival != name]
        blocks = [block for block in (*rivals, *taken) if len(block)]
        room = _distance(inside, np.concatenate(blocks)) if blocks else np.ones(len(inside))
        if room.max() < _TOO_CLOSE:
            continue
        place = inside[np.argmax(np.minimum(room, _FAR_ENOUGH))]
        taken.append(place[None])
        axes.text(
            place[0],
            place[1],
            name,
            transform=axes.transAxes,
            color=lines[name].get_color(),
            fontweight="bold",
            ha="center",
            va="center",
            bbox={"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": "none"},
            zorder=4,
        )
