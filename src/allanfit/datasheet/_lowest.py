"""The lowest point of an Allan deviation, which data sheets call bias instability."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.stats import chi2

from ..physics import STANDARD_TERMS

# The model's lowest point is sought between one sample and about a day.
_LONGEST_S = 1e5
_TAUS = 200
# Beyond a tenth of the record a curve has too few independent differences to have a lowest point.
_TENTH = 10
_DRAWS = 4000


def lowest_of_model(
    draws: Float[np.ndarray, "draws terms"], dt: float
) -> Float[np.ndarray, " draws"]:
    """The lowest Allan deviation of all five terms together, for each draw of Q, N, B, K, R."""
    sizes = jnp.asarray(np.geomspace(1.0, max(_LONGEST_S / dt, 1.0), _TAUS))
    unit = [term(jnp.asarray(1.0)).allan_variance(sizes, dt, "averaged") for term in STANDARD_TERMS]  # pyright: ignore[reportCallIssue]  (every term has this one field)
    return np.sqrt(np.min(draws**2 @ np.asarray(unit, np.float64), axis=1))


def lowest_of_curve(
    sizes: Float[np.ndarray, " taus"], deviation: Float[np.ndarray, " taus"], samples: int
) -> tuple[Float[np.ndarray, " draws"], bool]:
    """The lowest point of a measured curve, and whether the curve has reached it.

    The draws are its chi-square uncertainty, with the degrees of freedom 5 N^2/(4 n (N + 3 n)) of
    the overlapping Allan variance of flicker noise (Howe, Allan and Barnes 1981, table 1). A curve
    that falls up to a tenth of the record goes lower, who knows how far.
    """
    usable = np.flatnonzero((sizes <= samples / _TENTH) & np.isfinite(deviation))
    if not usable.size:
        return np.full(_DRAWS, np.inf), False
    place = int(usable[np.argmin(deviation[usable])])
    freedom = 5 * samples**2 / (4 * sizes[place] * (samples + 3 * sizes[place]))
    quantiles = (np.arange(_DRAWS) + 0.5) / _DRAWS
    draws = deviation[place] * np.sqrt(freedom / chi2.ppf(quantiles, freedom))
    return draws, bool(place != usable[-1])
