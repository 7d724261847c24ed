"""Whether a chain can be believed, as arviz computes it.

arviz is imported when it is needed: it takes longer to load than a short chain takes to run.
"""

import numpy as np
from jaxtyping import Float


def r_hat(draws: Float[np.ndarray, "walkers steps"]) -> float:
    """Rank-normalised split R-hat (Vehtari et al. 2021, Bayesian Analysis 16:667)."""
    import arviz

    return float(arviz.rhat(draws))


def effective_sample_size(draws: Float[np.ndarray, "walkers steps"]) -> float:
    """The smaller of the bulk and tail effective sample sizes (same source)."""
    import arviz

    return float(min(arviz.ess(draws, method="bulk"), arviz.ess(draws, method="tail")))
