"""Plotly's script as a page carries it: packed, and named by its checksum."""

import base64
import hashlib
import json
import zlib
from collections.abc import Sequence
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np

from ..formatting import printable, significant
from ._errors import report_extra

_DIGITS = 6


class Scripts(NamedTuple):
    """What makes the figures of a page answer to a hand, and the policy that lets it run."""

    packed: str  # plotly.js, zlib and base64: 2.0 MB in place of 4.8
    loader: str
    policy: str  # of these two scripts and of nothing else that may have crept into the page


@cache
def scripts() -> Scripts:
    """The scripts of a page with interactive figures.

    **Raises** `ReportError` when plotly is not installed.
    """
    with report_extra():
        import plotly
    library = files(plotly).joinpath("package_data", "plotly.min.js").read_bytes()
    loader = files("allanfit.report").joinpath("interactive.js").read_text("utf-8")
    hashes = " ".join(_hash(each) for each in (library, loader.encode()))
    return Scripts(
        packed=base64.b64encode(zlib.compress(library, 9)).decode(),
        loader=loader,
        # The camera of a figure draws it into an image that the browser then saves.
        policy=f"script-src {hashes}; img-src blob: data:",
    )


def _hash(script: bytes) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"


def as_script(value: Any) -> str:
    """JSON that no string in it can end, inside a `script` element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text


def plain(text: str) -> str:
    """A user's string that plotly shows as it stands: no tags, no formula and no placeholder."""
    shown = escape(printable(text))
    return shown.replace("$", "&#36;").replace("%", "&#37;").replace("{", "&#123;")


def numbers(values: np.ndarray | Sequence[float]) -> list[float | None]:
    """As many digits as an eye can use, and null for what is not finite."""
    return [
        float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
        for value in np.asarray(values, dtype=float).tolist()
    ]


def points(x: np.ndarray, data: np.ndarray, low: np.ndarray, high: np.ndarray) -> dict[str, Any]:
    """The trace of data with their 95 % intervals, as bars and in what the pointer tells."""
    return {
        "mode": "markers",
        "x": numbers(x),
        "y": numbers(data),
        "error_y": {
            "array": numbers(high - data),
            "arrayminus": numbers(data - low),
            "symmetric": False,
            "type": "data",
            "color": "#B3B3B3",
            "thickness": 1,
            "width": 0,
        },
        "text": [
            f"{significant(value)} [{significant(bottom)}, {significant(top)}]"
            for value, bottom, top in zip(data, low, high, strict=True)
        ],
        "hovertemplate": "data %{text}<extra></extra>",
        "legendrank": 1,
        "marker": {"color": "#4D4D4D", "size": 5},
    }


def line(
    x: np.ndarray, y: np.ndarray, name: str, short: str, colour: str, dash: str
) -> dict[str, Any]:
    """The trace of a model, or of one part of it; `short` is its name under the pointer."""
    return {
        "mode": "lines",
        "x": numbers(x),
        "y": numbers(y),
        "name": plain(name),
        "legendgroup": plain(name),
        "line": {"color": colour, "dash": dash, "width": 2},
        "text": [significant(value) for value in y],
        "hovertemplate": f"{plain(short)} %{{text}}<extra></extra>",
    }


def layout(
    labels: tuple[str, str, str],
    x: tuple[float, float],
    y: tuple[float, float],
    *,
    share: float,
    **lower: Any,
) -> dict[str, Any]:
    """Two panels above each other on logarithmic axes.

    **Arguments**: `labels` stand along the axes: x, upper y, lower y; `x` and `y` are the limits
    of the upper panel; `share` is the height of the lower panel, and `lower` its axis.
    """
    across, upper, below = (plain(label) for label in labels)
    small = {"font": {"size": 11}}
    shared = {
        "gridcolor": "#E4E4E4",
        "linecolor": "#444",
        "mirror": "all",
        "nticks": 6,
        "showline": True,
        "ticks": "inside",
        "zeroline": False,
        "exponentformat": "power",
    }
    logarithmic = {**shared, "type": "log", "minor": {"ticks": "inside", "ticklen": 3}}
    return {
        "xaxis": {
            **logarithmic,
            "range": np.log10(x).round(4).tolist(),
            "title": {"text": across, "standoff": 8, **small},
            "anchor": "y2",
            "unifiedhovertitle": {"text": f"{across}: %{{x:.4~g}}"},
        },
        "yaxis": {
            **logarithmic,
            "range": np.log10(y).round(4).tolist(),
            "title": {"text": upper, "standoff": 4, **small},
            "domain": [share + 0.05, 1],
        },
        "yaxis2": {
            **shared,
            "title": {"text": below, "standoff": 4, **small},
            "domain": [0, share],
            **lower,
        },
        "hovermode": "x unified",
        "hoversubplots": "axis",
        "hoverlabel": small,
        "legend": {"orientation": "h", "x": 0, "y": -0.17, "yanchor": "top"},
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#1c1e21"},
        "paper_bgcolor": "#fff",
        "plot_bgcolor": "#fff",
        "margin": {"l": 64, "r": 12, "t": 30, "b": 52},
    }
