"""A move of emcee that proposes where draws from nearly the same posterior lie."""

import numpy as np
from emcee.moves import MHMove
from jaxtyping import Float

_KERNELS = 256
# Degrees of freedom: where tails are lighter than those of the posterior, walkers get stuck there.
_TAILS = 4.0


def kernel_move(draws: Float[np.ndarray, "draws dim"]) -> MHMove:
    """Proposals independent of where a walker is, from a kernel density of such draws.

    Kernels are multivariate t, of the draws' covariance and Scott's bandwidth (1992, Multivariate
    Density Estimation, eq. 6.42). By Hastings' rule (1970, Biometrika 57:97) the posterior is the
    one that the walkers have whatever the draws are; how fast they get there depends on these.
    """
    dimension = draws.shape[1]
    count = min(_KERNELS, len(draws))
    mean, covariance = draws.mean(axis=0), np.cov(draws, rowvar=False)
    ridge = 1e-9 * np.trace(covariance) * np.eye(dimension)
    root = np.linalg.cholesky(covariance + ridge)
    back = np.linalg.inv(root).T
    middles = (draws[np.linspace(0, len(draws) - 1, count).astype(int)] - mean) @ back
    breadth = count ** (-1 / (dimension + 4))

    def log_density(x: Float[np.ndarray, "walkers dim"]) -> Float[np.ndarray, " walkers"]:
        whitened = (x - mean) @ back
        squares = np.sum(whitened**2, axis=1)[:, None] + np.sum(middles**2, axis=1)
        distance = np.maximum(squares - 2 * whitened @ middles.T, 0.0) / breadth**2
        return np.log(np.sum((1 + distance / _TAILS) ** (-(_TAILS + dimension) / 2), axis=1))

    def propose(x: Float[np.ndarray, "walkers dim"], random: np.random.RandomState):
        middle = middles[random.randint(count, size=len(x))]
        stretch = np.sqrt(_TAILS / random.chisquare(_TAILS, size=(len(x), 1)))
        there = mean + (middle + breadth * stretch * random.standard_normal(x.shape)) @ root.T
        return there, log_density(x) - log_density(there)

    return MHMove(propose)
