"""Where draws from nearly a posterior lie, as a density that follows their ridges."""

from typing import NamedTuple

import numpy as np
from emcee.moves import MHMove
from jaxtyping import Float
from scipy.special import gammaln, logsumexp

_KERNELS = 64
# Of all draws so many are neighbours, of which a kernel has its place and its covariance.
_NEAR = 1 / 12
# Degrees of freedom: where tails are lighter than those of the posterior, walkers get stuck there.
_TAILS = 5.0
# Part of the covariance of all draws that each kernel has at least.
_LEAST = 1e-5


class Kernels(NamedTuple):
    """A mixture of multivariate t, each as its neighbourhood is wide and turned."""

    middles: Float[np.ndarray, "kernels dim"]
    #: Cholesky factors of their covariances, and the inverses of these.
    roots: Float[np.ndarray, "kernels dim dim"]
    inverses: Float[np.ndarray, "kernels dim dim"]
    #: The middles as the inverses turn them.
    turned: Float[np.ndarray, "kernels dim"]
    #: Logarithm of the density of each in its middle, over their number.
    heights: Float[np.ndarray, " kernels"]

    def log_density(self, x: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, " points"]:
        """Of the mixture."""
        count, dimension = self.middles.shape
        # One product for all kernels: it takes most of the time.
        turned = x @ self.inverses.reshape(-1, dimension).T
        apart = turned.reshape(-1, count, dimension) - self.turned
        squares = np.einsum("pki,pki->pk", apart, apart)
        tail = (_TAILS + dimension) / 2
        every = self.heights - tail * np.log1p(squares / _TAILS)
        return np.asarray(logsumexp(every, axis=1))

    def draw(self, count: int, random: np.random.RandomState) -> Float[np.ndarray, "count dim"]:
        """Points of the mixture."""
        which = random.randint(len(self.middles), size=count)
        stretch = np.sqrt(_TAILS / random.chisquare(_TAILS, size=(count, 1)))
        normal = stretch * random.standard_normal((count, self.middles.shape[1]))
        return self.middles[which] + np.einsum("pij,pj->pi", self.roots[which], normal)


def kernels(draws: Float[np.ndarray, "draws dim"]) -> Kernels:
    """Kernels about some of the draws, each of the covariance of its nearest neighbours."""
    dimension = draws.shape[1]
    covariance = np.atleast_2d(np.cov(draws, rowvar=False))
    # However narrow a coordinate is beside the others, a little more leaves it as it is.
    whole = np.linalg.cholesky(covariance + 1e-9 * np.diag(np.diag(covariance)))
    white = np.linalg.solve(whole, draws.T).T
    about = white[np.linspace(0, len(draws) - 1, min(_KERNELS, len(draws))).astype(int)]
    near = min(max(int(_NEAR * len(draws)), 4 * dimension), len(draws))
    squares = np.sum(white**2, axis=1) - 2 * about @ white.T
    places = np.argpartition(squares, near - 1, axis=1)[:, :near]
    neighbours = draws[places]
    middles = neighbours.mean(axis=1)
    apart = neighbours - middles[:, None]
    local = apart.swapaxes(1, 2) @ apart / (near - 1) + _LEAST * (whole @ whole.T)
    roots = np.linalg.cholesky(local)
    sizes = np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)
    one = gammaln((_TAILS + dimension) / 2) - gammaln(_TAILS / 2)
    one -= dimension / 2 * np.log(np.pi * _TAILS) + np.log(len(about))
    inverses = np.linalg.inv(roots)
    turned = np.einsum("kij,kj->ki", inverses, middles)
    return Kernels(middles, roots, inverses, turned, one - sizes)


def kernel_move(found: Kernels) -> MHMove:
    """Walkers of emcee to where the kernels are, wherever each of them is.

    By Hastings' rule (1970, Biometrika 57:97) the posterior is the one that the walkers have
    whatever the kernels are; how fast they get there depends on these.
    """

    def propose(x: Float[np.ndarray, "walkers dim"], random: np.random.RandomState):
        there = found.draw(len(x), random)
        return there, found.log_density(x) - found.log_density(there)

    return MHMove(propose)
