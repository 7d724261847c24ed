"""Does the noise lean to one side, by more than spikes on that side make it do?"""

import numpy as np
from jaxtyping import Float
from scipy.stats import norm

_QUARTILES = (0.25, 0.5, 0.75)
# Standard error of that skewness of normal values, times the root of their number: from the
# covariance p (1 - q) / (f_p f_q) of two sample quantiles p <= q (David and Nagaraja 2003, 10.1).
_ERROR = 1.356


def skewness(values: Float[np.ndarray, " samples"]) -> float:
    """Bowley's: how much farther the upper quartile is from the median than the lower one.

    As a share of the distance between the two quartiles. Spikes do not reach it by their height.
    """
    low, middle, high = np.quantile(values, _QUARTILES)
    return float((high + low - 2 * middle) / (high - low))


def leans(values: Float[np.ndarray, " samples"], spikes: float, code: float, seed: int) -> float:
    """Log of the chance that normal values lean so, a share of which has `spikes` of one side.

    A share of all values that is beyond all others on one side moves the quartiles of the rest to
    where the quantiles p/(1 - share) were. Values in steps of `code` get noise as wide.
    """
    rng = np.random.default_rng(seed)
    smooth = values + code * rng.uniform(-0.5, 0.5, values.size)
    part = min(max(spikes, 0.0), _QUARTILES[0] - 0.01)
    low, middle, high = norm.ppf(np.array(_QUARTILES) / (1 - part))
    most = abs(float((high + low - 2 * middle) / (high - low)))
    beyond = (abs(skewness(smooth)) - most) / (_ERROR / np.sqrt(values.size))
    return min(float(norm.logsf(beyond)) + float(np.log(2)), 0.0)
