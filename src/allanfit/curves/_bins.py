"""Logarithmic frequency averaging."""

import numpy as np
from jaxtyping import Float


def logarithmic_edges(
    first: float, spacing: float, bins_per_decade: int
) -> Float[np.ndarray, " edges"]:
    """Edges between ordinates, in cycles per sample, from below `first` to 0.5.

    Equally spaced in log f where the ordinates are dense enough, one ordinate a bin where not.
    """
    growth = 10 ** (1 / bins_per_decade) - 1
    edges = [first - spacing / 2]
    while edges[-1] < 0.5:
        width = max(1, round(edges[-1] * growth / spacing))
        edges.append(edges[-1] + width * spacing)
    # A last bin that is mostly beyond the Nyquist frequency joins its neighbour.
    if len(edges) > 2 and edges[-1] - 0.5 > (edges[-1] - edges[-2]) / 2:
        del edges[-2]
    return np.asarray(edges)
