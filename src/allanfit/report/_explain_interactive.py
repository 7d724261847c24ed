"""A curve with both models for a reader's hand: what `_explain_panels` draws, for plotly."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._explain_panels import (
    AFTER,
    BEFORE,
    EFFECT_COLOURS,
    LARGEST_FINE_RATIO,
    SIMULATION,
    ExplainedCurve,
    bands,
    load_explained,
    ratio_is_linear,
)
from ._plotly import layout, line, numbers, points

_EFFECT_DASHES = ("2px,3px", "5px,2px", "9px,3px,2px,3px", "15px,4px")


def explained_figure(channel: Mapping[str, Any], kind: str) -> dict[str, Any] | None:
    """A curve ("allan" or "psd") with both models; None where there are no data.

    What belongs to a model has it as `meta`: "before" or "after"; a simulation is always shown.
    """
    curve = load_explained(channel, kind)
    if not np.isfinite(curve.data).any():
        return None
    across, along = curve.limits()
    low, high = curve.ratio_range()
    fine = {"type": "log", "dtick": "D2" if high / low < LARGEST_FINE_RATIO else 1}
    scale = {"type": "linear"} if ratio_is_linear(low, high) else fine
    labels = (curve.x_label, curve.y_label, "recording / model")
    sheet = layout(labels, across, along, share=0.34, **scale)
    sheet |= _shades(channel, kind, across)
    data = {"name": "recording, 95 % interval", "legendgroup": "data"}
    traces = [
        *_band(curve),
        *_effects(curve, along[0]),
    ]
    for rank, key, name, model, look, dash, symbol in (
        (3, "after", "better model", curve.after, AFTER, "solid", "circle"),
        (2, "before", "five terms", curve.before, BEFORE, "8px,4px", "diamond-open"),
        (4, None, "simulation", curve.simulation, SIMULATION, "6px,3px,2px,3px", "x-thin-open"),
    ):
        if np.isfinite(model).any():
            drawn = line(curve.x, model, name, name, look["color"], dash)
            ratio = {
                "name": f"recording / {name}",
                "legendgroup": drawn["legendgroup"],
                "mode": "markers",
                "x": numbers(curve.x),
                "y": numbers(curve.data / model),
                "yaxis": "y2",
                "marker": {"color": look["color"], "symbol": symbol, "size": 6},
                "hovertemplate": f"recording / {name} %{{y:.3~g}}<extra></extra>",
                "showlegend": False,
            }
            mark = {"legendrank": rank} | ({"meta": key} if key else {})
            traces += [{**each, **mark} for each in (drawn, ratio)]
    traces.append({**points(curve.x, curve.data, curve.low, curve.high), **data})
    return {"data": traces, "layout": sheet}


def _unity() -> dict[str, Any]:
    edge = {"color": "#000", "width": 1}
    ends = {"x0": 0, "x1": 1, "y0": 1, "y1": 1}
    return {"yref": "y2", "xref": "paper", **ends, "line": edge, "layer": "below"}


def _shades(
    channel: Mapping[str, Any], kind: str, across: tuple[float, float]
) -> dict[str, list[dict[str, Any]]]:
    """Where recording and model differ, over both panels, and the numbers of the table."""
    left, right = across
    growth = right / left
    domain = "tau" if kind == "allan" else "frequency"
    found = bands(channel, domain, lambda x: np.log(x / left) / np.log(growth), across)
    shapes = [
        {
            "xref": "x",
            "yref": "paper",
            "x0": left * growth**band.start,
            "x1": left * growth**band.stop,
            "y0": 0,
            "y1": 1,
            "fillcolor": "rgba(240, 228, 66, 0.4)",
            "line": {"width": 0},
            "layer": "below",
        }
        for band in found
    ]
    numbered = [
        {
            "text": band.label,
            "xref": "x",
            "yref": "paper",
            # On a logarithmic axis an annotation stands at a logarithm.
            "x": np.log10(left * growth**band.place),
            "y": 1,
            "yanchor": "top",
            "showarrow": False,
            "font": {"weight": "bold"},
        }
        for band in found
    ]
    return {"shapes": [_unity(), *shapes], "annotations": numbered}


def _band(curve: ExplainedCurve) -> list[dict[str, Any]]:
    """Ratios whose 95 % interval holds the model."""
    finite = np.isfinite(curve.data / curve.high) & np.isfinite(curve.data / curve.low)
    edge = {
        "mode": "lines",
        "x": numbers(curve.x[finite]),
        "yaxis": "y2",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    low, high = ((curve.data / each)[finite] for each in (curve.high, curve.low))
    return [
        {**edge, "y": numbers(low)},
        {**edge, "y": numbers(high), "fill": "tonexty", "fillcolor": "#E6E6E6"},
    ]


def _effects(curve: ExplainedCurve, bottom: float) -> list[dict[str, Any]]:
    traces = []
    for index, (name, values) in enumerate(curve.effects_in_sight().items()):
        colour = EFFECT_COLOURS[index % len(EFFECT_COLOURS)]
        dash = _EFFECT_DASHES[index % len(_EFFECT_DASHES)]
        # A line in one bin has zeros beside it, and would show as no line at all.
        shown = np.where(np.isfinite(values), values, bottom / 1e3)
        traces.append({**line(curve.x, shown, name, name, colour, dash), "meta": "after"})
    return traces
