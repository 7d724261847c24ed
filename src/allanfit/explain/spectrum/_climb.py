"""Fisher scoring of a structure from many starts at once.

The loop is on the host: compiled, it would have to be compiled anew for every structure, which
takes longer than all its steps.
"""

from functools import partial

import numpy as np
from jaxtyping import Float

from ._density import Starts, densities_and_slopes, log_slopes, parts, powers
from ._holding import foreign, held_rows
from ._structure import EACH, FLOOR, TERMS, Data, Kinds, active

MOST_STEPS = 60
# Less than this in twice the log-likelihood is as good as nothing.
LEAST_GAIN = 1e-4
_LONGEST_STEP = 3.0


def climb(
    starts: Starts,
    kinds: Kinds,
    data: Data,
    enough: tuple[float, float] = (LEAST_GAIN, 0.0),
    steps: int = MOST_STEPS,
) -> tuple[Starts, Float[np.ndarray, " starts"]]:
    """Where each start leads until a step gains little enough in deviance, and the deviance there.

    `enough` is such a gain, and the same as a part of the deviance beyond one a bin. After so many
    `steps` at most.
    """
    at = partial(densities_and_slopes, kinds=kinds, data=data, held=held_rows(data))
    moving = active(kinds, data.terms)
    return _ascend(np.array(starts), moving, at, data, enough, steps=steps)


def rescale(
    theta: Float[np.ndarray, " parameters"], kinds: Kinds, data: Data
) -> tuple[Float[np.ndarray, " parameters"], float]:
    """The best powers of all terms and added noises, their shapes held: quick, mostly enough."""
    sizes = np.concatenate(
        [np.arange(TERMS), kinds.first_slot + EACH * np.arange(len(kinds.added))]
    )
    moving = active(kinds, data.terms)[sizes]
    rows, bump, added = parts(theta[None], kinds, data, held_rows(data))
    units = [
        density[0] * bump[0] / np.exp(max(theta[place], FLOOR))
        for density, place in zip(added, sizes[TERMS:], strict=True)
    ]
    at = partial(
        _scaled, present=moving, unit=np.vstack([rows[0], *units]), alien=foreign(data) * bump[0]
    )
    reached, value = _ascend(np.array(theta[sizes][None]), moving, at, data)
    best = np.array(theta)
    best[sizes] = reached[0]
    return best, float(value[0])


def _scaled(logs, present, unit, alien):
    """As `densities_and_slopes`, where only sizes change, given by their logarithms."""
    power = powers(logs, present)
    total = power @ unit + alien
    return total, power[..., None] * unit / total[:, None]


def deviances(mean: Float[np.ndarray, "starts bins"], data: Data) -> Float[np.ndarray, " starts"]:
    """Twice the log-likelihood that each mean density leaves to a perfect fit."""
    with np.errstate(all="ignore"):
        ratio = np.asarray(data.bins.density) / mean
        value = (ratio - 1 - np.log(ratio)) @ (2 * np.asarray(data.bins.shape))
    return np.where(np.isfinite(value), value, np.inf)


def log_scatter(
    theta: Float[np.ndarray, " parameters"], kinds: Kinds, data: Data
) -> tuple[Float[np.ndarray, "bins parameters"], Float[np.ndarray, "parameters parameters"]]:
    """`log_slopes` at one place, and the covariance of the parameters by their information."""
    slopes = log_slopes(theta[None], kinds, data)[0]
    information = (slopes * np.asarray(data.bins.shape)[:, None]).T @ slopes
    return slopes, np.linalg.pinv(information, hermitian=True)


def _ascend(
    theta,
    moving,
    at,
    data: Data,
    enough: tuple[float, float] = (LEAST_GAIN, 0.0),
    steps: int = MOST_STEPS,
):
    """Damped as Marquardt does (1963, J. SIAM 11:431), until nothing more is gained.

    `at` gives the density for each start and the slopes of its logarithm. Most steps are taken, and
    need the slopes where they lead: there is no other program for the density alone.
    """
    least_gain, least_share = enough
    density = np.asarray(data.bins.density)
    usual = np.count_nonzero(data.bins.used)
    total, slope = at(theta)
    value = deviances(total, data)
    damping = np.full(len(theta), 1e-2)
    reached, lowest = theta.copy(), value.copy()
    # Those that are still on their way, by their place; all else is of these alone.
    going = np.arange(len(theta))
    along = np.flatnonzero(moving)
    identity = np.eye(along.size)
    for _ in range(steps):
        weighted, normal = _information(slope[:, along], data)
        with np.errstate(all="ignore"):
            gradient = weighted @ np.nan_to_num(density / total - 1)[..., None]
        diagonal = np.einsum("sii->si", normal)
        scale = diagonal + 1e-12 * diagonal.sum(axis=1, keepdims=True) + 1e-30
        moved, ended = np.zeros(going.size, bool), np.zeros(going.size, bool)
        for factor in (0.1, 10.0):
            trying = np.flatnonzero(~moved)
            weight = (factor * damping[trying, None] * scale[trying])[..., None] * identity
            step = np.linalg.solve(normal[trying] + weight, gradient[trying])[..., 0]
            tried = theta[trying]
            tried[:, along] += np.minimum(np.maximum(step, -_LONGEST_STEP), _LONGEST_STEP)
            mean, slopes = at(tried)
            found = deviances(mean, data)
            better = found < value[trying]
            there = trying[better]
            least = np.maximum(least_gain, least_share * (found[better] - usual))
            ended[there] = value[there] - found[better] < least
            theta[there], value[there] = tried[better], found[better]
            total[there], slope[there] = mean[better], slopes[better]
            damping[there] = np.clip(factor * damping[there], 1e-9, 1e9)
            moved[there] = True
            if moved.all():
                break
        damping[~moved] *= 100
        ended |= damping >= 1e6
        if ended.any():
            reached[going], lowest[going] = theta, value
            going, theta, value = going[~ended], theta[~ended], value[~ended]
            total, slope, damping = total[~ended], slope[~ended], damping[~ended]
            if not going.size:
                break
    reached[going], lowest[going] = theta, value
    return reached, lowest


def _information(slope: Float[np.ndarray, "starts along bins"], data: Data):
    """Slopes, each bin as weighty as it is informative, and what these tell of all together.

    The information of a Gamma variate on ln m is its shape.
    """
    shape = np.asarray(data.bins.shape)
    with np.errstate(all="ignore"):
        weighted = slope * shape
        normal = weighted @ slope.swapaxes(1, 2)
        if not np.isfinite(normal).all():
            slope = np.where(np.isfinite(slope), slope, 0.0)
            weighted = slope * shape
            normal = weighted @ slope.swapaxes(1, 2)
    return weighted, normal
