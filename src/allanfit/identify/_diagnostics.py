"""Whether a chain can be believed, as ArviZ computes it."""

from typing import Any

import numpy as np
from jaxtyping import Float

_AXES: dict[str, Any] = {"chain_axis": 0, "draw_axis": 1}


def r_hat(draws: Float[np.ndarray, "walkers steps"]) -> float:
    """Rank-normalised split R-hat (Vehtari et al. 2021, Bayesian Analysis 16:667)."""
    return float(_arviz().rhat(draws, **_AXES))


def effective_sample_size(draws: Float[np.ndarray, "walkers steps"]) -> float:
    """The smaller of the bulk and tail effective sample sizes (same source)."""
    ess = _arviz().ess
    bulk = ess(draws, method="bulk", **_AXES)
    return float(min(bulk, ess(draws, method="tail", prob=(0.05, 0.95), **_AXES)))


def _arviz() -> Any:
    # It is in no way needed where nothing is sampled, and takes half a second to load.
    try:
        from arviz_stats.base.array import array_stats
    except ImportError as error:
        raise ImportError(
            "Diagnostics of the posterior need arviz-stats; run: pip install 'allanfit[cli]'"
        ) from error
    return array_stats
