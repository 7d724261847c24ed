"""Placing the letter of each line where the plot is emptiest."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from scipy.spatial import KDTree

from ._legend import Drawn, seen

_MARGIN = 0.05  # in fractions of the axes: letters keep clear of the frame
_FAR_ENOUGH = 0.12  # beyond this distance, more of it makes a place no better
_TOO_CLOSE = 0.02  # the line runs along another, which the letter would hide
_COVERED = 0.04  # from the middle of a letter to what its ground leaves in sight
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
    if not len(others):
        return np.ones(len(places))
    return KDTree(others).query(places)[0]


def label_lines(
    axes: Axes,
    lines: Mapping[str, Line2D],
    obstacles: Sequence[Drawn],
    bars: Drawn,
    legend: Legend,
) -> None:
    """Write each line's name on the line, clear of the other lines, the obstacles and the frame.

    Where it would hide any of them or of the `bars` on all of the line, it stands beside it. The
    axes must have their limits and their `legend`, from which distances follow. A line that is
    outside the frame, or everywhere close to another, gets no name.
    """
    paths = {name: _path(axes, line) for name, line in lines.items()}
    points, hidden = seen(axes, obstacles), [seen(axes, [bars]), _ground(axes, legend)]
    for name, path in paths.items():
        on = _clear_of_frame(path)
        curves = [points, *(other for rival, other in paths.items() if rival != name)]
        if not len(on) or _distance(on, np.concatenate(curves)).max() < _TOO_CLOSE:
            continue
        others = np.concatenate([*curves, *hidden])
        room = np.minimum(_distance(on, others), _FAR_ENOUGH)
        place = on[np.argmax(room)]
        if room.max() < _COVERED:
            below, above = (np.add(path, (0.0, shift)) for shift in (-_COVERED, _COVERED))
            near = _clear_of_frame(np.concatenate([below, above]))
            clear = _distance(near, np.concatenate([others, path]))
            if clear.size and clear.max() > room.max():
                place = near[np.argmax(clear)]
        hidden.append(place[None])
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


def _clear_of_frame(path: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "inside 2"]:
    """Places that are clear of the frame."""
    return path[((path > _MARGIN) & (path < 1 - _MARGIN)).all(axis=1)]


def _ground(axes: Axes, legend: Legend) -> Float[np.ndarray, "points 2"]:
    """The ground of a legend, as points in fractions of the axes."""
    box = legend.get_window_extent().transformed(axes.transAxes.inverted())
    across, along = (
        np.arange(low, high, _TOO_CLOSE) for low, high in (box.intervalx, box.intervaly)
    )
    return np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2)
