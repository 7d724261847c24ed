"""How likely chance is to gain as much by an effect, and what it costs among its rivals."""

import numpy as np
from scipy.special import betainc, betaln, gammaln
from scipy.stats import chi2

# How many independent places a smooth effect is looked for in, and the parameters that it has: the
# chance that noise alone gains x in twice the log-likelihood is trials * P(chi^2 > x).
# Set by records with nothing left out; `python -m benchmarks.chances` shows how true they are.
_SMOOTH = {
    "gauss_markov": (3.0, 2),
    "resonance": (12.0, 3),
    "power_law": (1.0, 2),
    "low_pass": (4.0, 2),
    "droop": (1.0, 1),
    "floor": (1.0, 1),
    "drifting_line": (15.0, 3),
    "bump": (70.0, 3),
}
#: Twice the log-likelihood that a parameter of a smooth effect, and a size of a course, has to pay
#: for in the comparison of rivals.
PRICE = float(np.log(200))
_SIZE_PRICE = 3.2
#: Twice the log of the prior odds that a cause is in the catalogue: nineteen of twenty are.
INSIDE = 2 * float(np.log(19))
# Below this much gain tails are looked up, above it expanded.
_FAR = 600.0


def log_chance(name: str, gain: float) -> float:
    """Log of the probability that noise alone gains as much by this smooth effect."""
    trials, parameters = _SMOOTH[name]
    return float(min(0.0, np.log(trials) + _log_tail(gain, parameters)))


def score(name: str, gain: float) -> float:
    """Twice the log of the odds of rivals, up to a constant: the gain less what it costs."""
    return gain - PRICE * _SMOOTH[name][1]


def course_log_chance(
    gain: float, sizes: int, known: float, places: float = 1.0, length: float = 0.0
) -> float:
    """Log of the probability that noise alone gains as much by a course in time.

    The noise is fitted again beside a course of `sizes` columns. If it was known as well as from
    `known` ordinates of one common variance, the gain is known * ln(1 + explained/left), and
    exp(-gain/known) has a beta distribution. The course is the best of `places` unrelated ones,
    or of all along a path of that `length` in the space of unit signals, where the chance grows by
    length/pi * exp(-gain/2) at most (Naiman 1986, Ann. Statist. 14:896, for known variance).
    """
    left = max(known - sizes, 1.0)
    single = np.log(places) + _log_beta(gain / known, left / 2, sizes / 2)
    along = np.log(length / np.pi) - gain * left / known / 2 if length > 0 else -np.inf
    return float(min(0.0, np.logaddexp(single, along)))


def course_score(gain: float, sizes: int, places: float = 1.0, length: float = 0.0) -> float:
    """As `score`, for a course."""
    looked = places + length * np.sqrt(max(gain, 1.0) / (2 * np.pi))
    return gain - 2 * float(np.log(looked)) - _SIZE_PRICE * sizes


def _log_beta(minus_log: float, a: float, b: float) -> float:
    """Log of the regularised incomplete beta function at exp(-minus_log)."""
    if minus_log * a < _FAR / 2:
        return float(np.log(betainc(a, b, np.exp(-minus_log))))
    return float(-a * minus_log - np.log(a) - betaln(a, b))


def _log_tail(gain: float, freedom: int) -> float:
    """Log of P(chi^2 > gain), also where the probability is no float any more."""
    if gain < _FAR:
        return float(chi2.logsf(gain, freedom))
    return float(-gain / 2 + (freedom / 2 - 1) * np.log(gain / 2) - gammaln(freedom / 2))
