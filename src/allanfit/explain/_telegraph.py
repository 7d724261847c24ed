"""Two levels, or a normal process? What second-order statistics cannot say.

A random telegraph has the spectrum and the Allan variance of a Gauss-Markov process. Seen through
the Wiener filter that takes it out of the other noise, it dwells at two values, and its kurtosis
is below that of a normal process seen the same way.
"""

import numpy as np
from jaxtyping import Float
from scipy.fft import idct

_SURROGATES = 199
# Modes beyond this many corner frequencies of the process are noise.
_CORNERS = 12


def two_levels(
    amplitude: Float[np.ndarray, " modes"],
    signal: Float[np.ndarray, " modes"],
    total: Float[np.ndarray, " modes"],
    corner: int,
    seed: int,
) -> tuple[float, float]:
    """Kurtosis of the filtered process, and the chance that a normal one has less.

    `amplitude` are the signed cosine amplitudes of one stretch from order 2 on, as `ordinates`
    makes them, `signal` and `total` the expected squares of the process alone and of everything;
    `corner` is the mode at which the process's density has fallen to half.
    """
    count = min(amplitude.size, max(_CORNERS * corner, 64))
    weight = (signal / total)[:count]
    found = _kurtosis(weight * amplitude[:count])
    rng = np.random.default_rng(seed)
    spread = np.sqrt(total[:count])
    null = np.array(
        [_kurtosis(weight * spread * rng.standard_normal(count)) for _ in range(_SURROGATES)]
    )
    # Beyond all surrogates the tail is taken for normal, in the logarithm of what is above 1: no
    # kurtosis is below that, and of two levels alone it is as much.
    above = np.log(np.maximum(null - 1, 1e-9))
    normal = (np.log(max(found - 1, 1e-9)) - above.mean()) / above.std()
    beyond = float(np.mean(null <= found))
    if beyond > 0:
        return found, beyond
    return found, float(min(1 / _SURROGATES, 0.5 * np.exp(-(normal**2) / 2)))


def _kurtosis(coefficients: Float[np.ndarray, " modes"]) -> float:
    # Neither a mean nor the order that only says how a ramp ends.
    series = np.asarray(idct(np.concatenate([[0.0, 0.0], coefficients]), norm="ortho"))
    return float(np.mean(series**4) / np.mean(series**2) ** 2)
