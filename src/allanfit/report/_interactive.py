"""A curve and its residuals for a reader's hand: what `_panels` draws, as plotly takes it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._panels import BAND_95, COLOURS, Curve, curve_limits, load_curve
from ._plotly import layout, line, numbers, plain, points

# Neighbours on the curve differ in their dashes too.
_DASHES = {"Q": "4px,3px", "N": "9px,4px", "B": "9px,3px,2px,3px", "K": "15px,4px", "R": "5px,2px"}
_DOTS = "1px,4px"  # of a term that is not resolved
_FAR_ENOUGH = 0.5  # decades from a letter to the next line, beyond which more is no better


def curve_figure(channel: Mapping[str, Any], kind: str) -> dict[str, Any] | None:
    """A curve ("allan" or "psd") of a channel with its residuals; None where there are no data."""
    curve = load_curve(channel, kind)
    if not np.isfinite(curve.data).any():
        return None
    across, along = curve_limits(curve)
    lower = "residual [\N{GREEK SMALL LETTER SIGMA}]"
    residual = curve.residual()
    limit = max(4.0, 1.15 * float(np.nanmax(np.abs(residual), initial=0.0)))
    labels = (curve.x_label, curve.y_label, lower)
    sheet = layout(labels, across, along, share=0.26, range=[-limit, limit])
    band = {"yref": "y2", "xref": "paper", "x0": 0, "x1": 1, "y0": -BAND_95, "y1": BAND_95}
    sheet["shapes"] = [
        {**band, "fillcolor": "#E6E6E6", "line": {"width": 0}, "layer": "below"},
        {**band, "y0": 0, "y1": 0, "line": {"color": "#000", "width": 1}, "layer": "below"},
    ]
    data = {"name": "data, 95 % interval", "legendgroup": "data"}
    traces = [
        line(curve.x, curve.model, "fit", "fit", "#000", "solid"),
        *_terms(curve, channel["coefficients"], along),
        {**points(curve.x, curve.data, curve.low, curve.high), **data},
        {
            **data,
            "name": "residual",
            "mode": "markers",
            "x": numbers(curve.x),
            "y": numbers(residual),
            "yaxis": "y2",
            "marker": {"color": "#4D4D4D", "size": 5},
            "hovertemplate": "residual %{y:.2f} \N{GREEK SMALL LETTER SIGMA}<extra></extra>",
            "showlegend": False,
        },
    ]
    return {"data": traces, "layout": sheet}


def _terms(
    curve: Curve, coefficients: Mapping[str, Any], along: tuple[float, float]
) -> list[dict[str, Any]]:
    """A line for each term, and its letter on the line."""
    traces = []
    for symbol, values in curve.terms_in_sight().items():
        resolved = coefficients[symbol]["resolved"]
        doubt = "" if resolved else " (not resolved)"
        dash = _DASHES.get(symbol, "dash") if resolved else _DOTS
        name = f"{symbol}  {coefficients[symbol]['name']}{doubt}"
        colour = COLOURS.get(symbol, "#000")
        shown = line(curve.x, values, name, symbol, colour, dash)
        traces.append(shown)
        place = _emptiest(curve, symbol, along)
        if place is not None:
            traces.append(
                {
                    "mode": "markers+text",
                    "x": numbers(curve.x[[place]]),
                    "y": numbers(values[[place]]),
                    "text": [plain(symbol)],
                    "textfont": {"color": colour, "size": 13, "weight": "bold"},
                    "marker": {"color": "#fff", "size": 17},
                    "legendgroup": shown["legendgroup"],
                    "showlegend": False,
                    "hoverinfo": "skip",
                }
            )
    return traces


def _emptiest(curve: Curve, symbol: str, along: tuple[float, float]) -> int | None:
    """Where a letter on the line is farthest from the other lines, None where it has no room."""
    values = np.log10(curve.terms[symbol])
    others = [curve.model, *(each for name, each in curve.terms.items() if name != symbol)]
    room = np.min(
        [np.nan_to_num(abs(values - np.log10(each)), nan=np.inf) for each in others], axis=0
    )
    low, high = np.log10(along)
    margin = 0.05 * (high - low)
    inside = (values > low + margin) & (values < high - margin)
    inside[[0, -1]] = False
    if not inside.any():
        return None
    return int(np.argmax(np.where(inside, np.minimum(room, _FAR_ENOUGH), -1.0)))
