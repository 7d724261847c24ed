"""Whether a chain can be believed, as arviz computes it.

arviz is imported when it is needed: it takes longer to load than a short chain takes to run.
"""

from types import ModuleType

import numpy as np
from jaxtyping import Float


def r_hat(draws: Float[np.ndarray, "walkers steps"]) -> float:
    """Rank-normalised split R-hat (Vehtari et al. 2021, Bayesian Analysis 16:667)."""
    return float(_arviz().rhat(draws))


def effective_sample_size(draws: Float[np.ndarray, "walkers steps"]) -> float:
    """The smaller of the bulk and tail effective sample sizes (same source)."""
    ess = _arviz().ess
    return float(min(ess(draws, method="bulk"), ess(draws, method="tail")))


def _arviz() -> ModuleType:
    try:
        import arviz
    except ImportError as error:
        raise ImportError(
            "Diagnostics of the posterior need arviz; run: pip install 'allanfit[cli]'"
        ) from error
    return arviz
