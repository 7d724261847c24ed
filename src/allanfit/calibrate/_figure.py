"""Residuals as a figure, in which matplotlib is imported."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..report._panels import style
from ..report._units import typeset
from ._result import Residuals

_SIZE_INCHES = (7.2, 2.6)
# Told apart in grey print too, by shape.
_LOOKS = (("o", "#0072B2"), ("^", "#D55E00"), ("s", "#009E73"))


def residual_figure(residuals: Residuals) -> Figure:
    """Residuals about zero, each group with its own mark."""
    with style():
        sheet = Figure(figsize=_SIZE_INCHES)
        axes = sheet.subplots()
        sheet.subplots_adjust(left=0.12, right=0.98, bottom=0.18, top=0.96)
        axes.axhline(0.0, color="black", linewidth=0.8)
        groups = list(dict.fromkeys(residuals.groups))
        for group, (mark, colour) in zip(groups, _LOOKS, strict=False):
            mine = np.array(residuals.groups) == group
            axes.plot(
                residuals.x[mine],
                residuals.values[mine],
                mark,
                color=colour,
                markersize=4,
                markeredgewidth=0,
                label=group,
            )
        if np.array_equal(residuals.x, np.round(residuals.x)):
            # Numbers of positions have no halves.
            axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
        axes.set_xlabel(typeset(residuals.x_label), parse_math=False)
        unit = f" [{typeset(residuals.unit)}]" if residuals.unit else ""
        axes.set_ylabel(f"residual{unit}", parse_math=False)
        largest = float(np.abs(residuals.values).max())
        # What is zero but for rounding should not fill the frame.
        axes.set_ylim(*((-1.25 * largest, 1.25 * largest) if largest > 1e-12 else (-1, 1)))
        if len(groups) > 1:
            axes.legend(loc="upper right", ncols=len(groups))
        return sheet
