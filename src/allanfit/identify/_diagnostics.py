"""Whether a chain can be believed, as arviz computes it.

arviz is imported when it is needed: it takes longer to load than a short chain takes to run.
"""

import warnings
from functools import cache
from tempfile import TemporaryDirectory
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


@cache
def _arviz() -> ModuleType:
    try:
        import platformdirs

        # At its first import it makes a folder in the user's home, where nothing may be writable,
        # to announce once a day the next version, which is not the one that is used here.
        usual = platformdirs.user_cache_dir
        with TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.filterwarnings("ignore", r"\s*ArviZ is undergoing", FutureWarning)
            platformdirs.user_cache_dir = lambda *_, **__: folder
            try:
                import arviz
            finally:
                platformdirs.user_cache_dir = usual
    except ImportError as error:
        raise ImportError(
            "Diagnostics of the posterior need arviz; run: pip install 'allanfit[cli]'"
        ) from error
    return arviz
