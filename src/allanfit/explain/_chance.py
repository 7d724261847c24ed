"""How likely chance is to gain as much by an effect, and what it costs among its rivals."""

import numpy as np
from scipy.special import gammaln
from scipy.stats import chi2

# How many independent places an effect is looked for in, and the parameters that it has: the
# chance that noise alone gains x in twice the log-likelihood is trials * P(chi^2 > x).
# Set so that on simulated records with nothing left out as many fall below e^-3 as should.
_SMOOTH = {
    "gauss_markov": (3.0, 2),
    "resonance": (12.0, 3),
    "power_law": (1.0, 2),
    "low_pass": (4.0, 2),
    "drifting_line": (15.0, 3),
    "bump": (20.0, 3),
}
# Courses in time. The noise that is fitted again beside a course makes chance gains larger than
# chi-square ones; so more.
_COURSES = {
    "step": (3000.0, 1),
    "warm_up": (25.0, 1),
    "sinusoid": (2000.0, 2),
    "temperature": (6.0, 2),
    "vibration_rectification": (2.0, 1),
}
TRIALS = _SMOOTH | _COURSES
# Twice the log-likelihood that a parameter of a smooth effect, and a size of a course, has to pay
# for in the comparison of rivals.
_PRICE = float(np.log(200))
_SIZE_PRICE = 3.2


def log_chance(name: str, gain: float) -> float:
    """Log of the probability that noise alone gains as much by this effect."""
    trials, freedom = TRIALS[name]
    return float(min(0.0, np.log(trials) + _log_tail(gain, freedom)))


def score(name: str, gain: float) -> float:
    """Twice the log of the odds of rivals, up to a constant: the gain less what it costs."""
    trials, freedom = TRIALS[name]
    if name in _COURSES:
        return gain - 2 * float(np.log(trials)) - _SIZE_PRICE * freedom
    return gain - _PRICE * freedom


def _log_tail(gain: float, freedom: int) -> float:
    """Log of P(chi^2 > gain), also where the probability is no float any more."""
    if gain < 600:
        return float(chi2.logsf(gain, freedom))
    return float(-gain / 2 + (freedom / 2 - 1) * np.log(gain / 2) - gammaln(freedom / 2))
