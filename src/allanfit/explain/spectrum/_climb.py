"""Fisher scoring of a structure from many starts at once.

What each effect puts into the bins, and its derivatives, come from JAX, vmapped over the starts and
compiled once an effect. The loop around them is on the host: compiled, it would have to be compiled
anew for every structure, which takes longer than all its steps.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ._ordinates import points
from ._structure import (
    EACH,
    FLOOR,
    RUNNING_MEAN,
    TERMS,
    Data,
    Kinds,
    active,
    added_density,
    foreign,
    held_rows,
    left_of,
    shaped,
    without_droop,
)

MOST_STEPS = 60
# Less than this in twice the log-likelihood is as good as nothing.
LEAST_GAIN = 1e-4
_LONGEST_STEP = 3.0
# Single ordinates are asked for by so many.
_LENGTH = 1024
# Starts that climb together: one would be as slow as two, and of eight that go all the way each
# waits for the last. Programs are compiled for as many.
TOGETHER, ON_TRIAL = 2, 8

Starts = Float[np.ndarray, "starts parameters"]


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
    moving, held = active(kinds, data.terms), held_rows(data)

    def mean(theta):
        return _mean(theta, kinds, data, held)

    def slopes(theta):
        return _mean_and_slopes(theta, kinds, data, held)

    return _ascend(np.array(starts), moving, mean, slopes, data, enough, steps=steps)


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
    unit = np.vstack([rows[0], *units])
    alien = foreign(data) * bump[0]

    def mean(logs):
        return _powers(logs, moving) @ unit + alien

    def slopes(logs):
        total = mean(logs)
        return total, _powers(logs, moving)[..., None] * unit / total[:, None]

    reached, value = _ascend(np.array(theta[sizes][None]), moving, mean, slopes, data)
    best = np.array(theta)
    best[sizes] = reached[0]
    return best, float(value[0])


def expected_density(
    theta: Float[np.ndarray, " parameters"], kinds: Kinds, data: Data
) -> Float[np.ndarray, " bins"]:
    """The expected density of each bin [u^2]."""
    return _mean(theta[None], kinds, data, held_rows(data))[0]


def log_slopes(
    theta: Starts, kinds: Kinds, data: Data
) -> Float[np.ndarray, "starts bins parameters"]:
    """Derivatives of the log of the expected density."""
    found = _mean_and_slopes(theta, kinds, data, held_rows(data))[1].swapaxes(1, 2)
    return np.where(active(kinds, data.terms) & np.isfinite(found), found, 0.0)


def log_scatter(
    theta: Float[np.ndarray, " parameters"], kinds: Kinds, data: Data
) -> tuple[Float[np.ndarray, "bins parameters"], Float[np.ndarray, "parameters parameters"]]:
    """`log_slopes` at one place, and the covariance of the parameters by their information."""
    slopes = log_slopes(theta[None], kinds, data)[0]
    information = (slopes * np.asarray(data.bins.shape)[:, None]).T @ slopes
    return slopes, np.linalg.pinv(information, hermitian=True)


def filter_slopes(
    shaping: str, three: Float[np.ndarray, " three"], nodes: Any, samples: Any
) -> tuple[Float[np.ndarray, " bins"], Float[np.ndarray, "bins three"]]:
    """The gain of a filter on white noise, aliases included, and its derivatives."""
    slopes, gains = _evaluated(_gain_slopes, shaping, three[None], nodes, samples)
    return gains[0][0], slopes[0][0].T


def parts(theta: Starts, kinds: Kinds, data: Data, held: Float[np.ndarray, "terms bins"]):
    """Rows of the terms, the bump, and what each added noise puts into each bin.

    For each start: shapes (starts, terms, bins), (starts, bins), or (starts, 1) where there is no
    bump, and (starts, bins) each. `held` are the `held_rows` of the data, which no parameter
    changes.
    """
    gains, _ = _shape(theta, kinds, data, slopes=False)
    slots = _slots(theta, kinds)
    added = [
        noise_density(name, slots[:, i], data) * (gains[1] if _passes(name, kinds) else 1.0)
        for i, name in enumerate(kinds.added)
    ]
    return _rows(gains, kinds, held), gains[2], added


def effects_density(
    theta: Float[np.ndarray, " parameters"], kinds: Kinds, data: Data
) -> Float[np.ndarray, "slots bins"]:
    """What each added noise puts into each bin, the bump included."""
    _, bump, added = parts(theta[None], kinds, data, held_rows(data))
    nothing = np.zeros((0, len(data.bins.nodes)))
    return np.concatenate([nothing, *(each * bump for each in added)])


def noise_density(
    name: str, threes: Float[np.ndarray, "starts three"], data: Data
) -> Float[np.ndarray, "starts bins"]:
    """What an added noise alone puts into each bin [u^2]."""
    return _evaluated(_density, name, threes, data.bins.nodes, data.samples) * _left(name, data)


def deviances(mean: Float[np.ndarray, "starts bins"], data: Data) -> Float[np.ndarray, " starts"]:
    """Twice the log-likelihood that each mean density leaves to a perfect fit."""
    with np.errstate(all="ignore"):
        ratio = np.asarray(data.bins.density) / mean
        value = (ratio - 1 - np.log(ratio)) @ (2 * np.asarray(data.bins.shape))
    return np.where(np.isfinite(value), value, np.inf)


def noise_at(
    name: str,
    three: Float[np.ndarray, " three"],
    frequency: Float[np.ndarray, " frequencies"],
    data: Data,
) -> Float[np.ndarray, " frequencies"]:
    """What an added noise puts into single ordinates [u^2], at frequencies in cycles per sample."""
    nodes = _filled_up(frequency)
    density = _evaluated(_density, name, np.asarray(three)[None], nodes, data.samples)[0]
    return density[: len(frequency)] * left_of(name, frequency, data.averaging)


def _filled_up(frequency: Float[np.ndarray, " frequencies"]) -> Any:
    """Nodes at single frequencies, of a length that is one of few, so that few are compiled."""
    return points(np.pad(frequency, (0, -len(frequency) % _LENGTH), mode="edge"))


def gain_at(
    theta: Float[np.ndarray, " parameters"],
    name: str,
    kinds: Kinds,
    frequency: Float[np.ndarray, " frequencies"],
    data: Data,
) -> Float[np.ndarray, " frequencies"]:
    """What the filter passes of an added noise at single ordinates: all, unless it comes last."""
    if kinds.shaping is None or not _passes(name, kinds):
        return np.ones(len(frequency))
    nodes = _filled_up(frequency)
    three = theta[None, TERMS : TERMS + EACH]
    passed = _evaluated(_gains, without_droop(kinds.shaping), three, nodes, data.samples)[1]
    return passed[0, : len(frequency)]


def _passes(name: str, kinds: Kinds) -> bool:
    """Whether the filter changes an added noise: a line is as large as it is among the samples."""
    return kinds.last and name != "drifting_line"


def _left(name: str, data: Data) -> float | Float[np.ndarray, " bins"]:
    if not data.averaging:
        return 1.0
    return left_of(name, data.bins.nodes[:, 1], data.averaging)


def _slots(theta: Starts, kinds: Kinds) -> Float[np.ndarray, "starts added three"]:
    return theta[:, kinds.first_slot :].reshape(len(theta), -1, EACH)


def _powers(
    logs: Float[np.ndarray, "starts sizes"], present: Any
) -> Float[np.ndarray, "starts sizes"]:
    """Those of sizes given by their logarithms, zero where they are not present."""
    return np.where(present, np.exp(np.minimum(np.maximum(logs, FLOOR), 60)), 0.0)


def _rows(gains, kinds: Kinds, held) -> Float[np.ndarray, "starts terms bins"]:
    folded, passed, bump = gains
    if kinds.shaping is None:
        return np.broadcast_to(held, (len(bump), *held.shape))
    angle = folded if kinds.angle_filtered else np.ones_like(folded)
    return held * np.stack([angle, folded, passed, passed], axis=1) * bump[:, None]


def _shape(theta: Starts, kinds: Kinds, data: Data, *, slopes: bool):
    """Filter, aliases and all or not, and bump of each start; their derivatives if asked for."""
    if kinds.shaping is None:
        one = np.ones((len(theta), 1))
        return (one, one, one), None
    three = theta[:, TERMS : TERMS + EACH]
    # A filter that droops is the same program as one that does not.
    asked = without_droop(kinds.shaping), three, data.bins.nodes, data.samples
    # Of whole numbers there is nothing to climb along.
    if not slopes or kinds.shaping == RUNNING_MEAN:
        gains = _evaluated(_gains, *asked)
        return gains, tuple(np.zeros((len(each), EACH, each.shape[1])) for each in gains)
    derivatives, gains = _evaluated(_gain_slopes, *asked)
    return gains, derivatives


def _mean(theta: Starts, kinds: Kinds, data: Data, held) -> Float[np.ndarray, "starts bins"]:
    """The expected density for each start."""
    rows, bump, added = parts(theta, kinds, data, held)
    power = _powers(theta[:, :TERMS], data.terms)
    total = (power[:, None] @ rows)[:, 0] + foreign(data) * bump
    for density in added:
        total = total + density * bump
    return total


def _mean_and_slopes(
    theta: Starts, kinds: Kinds, data: Data, held
) -> tuple[Float[np.ndarray, "starts bins"], Float[np.ndarray, "starts parameters bins"]]:
    """The expected density for each start, and the derivatives of its logarithm."""
    gains, gain_slopes = _shape(theta, kinds, data, slopes=True)
    bump, power = gains[2], _powers(theta[:, :TERMS], data.terms)[..., None]
    noise = _rows(gains, kinds, held) * power
    total = noise.sum(axis=1) + foreign(data) * bump
    filtered, added = 0.0, []
    for name, three in zip(kinds.added, _slots(theta, kinds).swapaxes(0, 1), strict=True):
        slope, density = _evaluated(_density_slopes, name, three, data.bins.nodes, data.samples)
        left = np.asarray(_left(name, data))
        if _passes(name, kinds):
            filtered = filtered + density * left
            left = left * gains[1]
        left = left * bump
        total = total + density * left
        added.append(slope * left[:, None])
    blocks = [noise]
    if gain_slopes is not None:
        folded, passed, bumped = gain_slopes
        strong = held * power
        white = strong[:, 1] + strong[:, 0] if kinds.angle_filtered else strong[:, 1]
        slow = strong[:, 2] + strong[:, 3] + filtered
        slope = folded * (white * bump)[:, None] + passed * (slow * bump)[:, None]
        blocks.append(slope + bumped * (total / bump)[:, None])
    return total, np.concatenate([*blocks, *added], axis=1) / total[:, None]


def _ascend(
    theta,
    moving,
    mean,
    slopes,
    data: Data,
    enough: tuple[float, float] = (LEAST_GAIN, 0.0),
    damping=None,
    steps: int = MOST_STEPS,
):
    """Damped as Marquardt does (1963, J. SIAM 11:431), until nothing more is gained."""
    least_gain, least_share = enough
    density = np.asarray(data.bins.density)
    usual = np.count_nonzero(data.bins.used)
    value = deviances(mean(theta), data)
    damping = np.full(len(theta), 1e-2) if damping is None else damping
    still = np.ones(len(theta), bool)
    along = np.flatnonzero(moving)
    identity = np.eye(along.size)
    for done in range(steps):
        if len(theta) > 1 and still.sum() == 1:
            # The last one on its way goes on alone: all at once cost as much with one as with all.
            theta[still], value[still] = _ascend(
                theta[still], moving, mean, slopes, data, enough, damping[still], steps - done
            )
            break
        total, slope = slopes(theta)
        weighted, normal = _information(slope[:, along], data)
        with np.errstate(all="ignore"):
            gradient = weighted @ np.nan_to_num(density / total - 1)[..., None]
        diagonal = np.einsum("sii->si", normal)
        scale = diagonal + 1e-12 * diagonal.sum(axis=1, keepdims=True) + 1e-30
        moved = np.zeros(len(theta), bool)
        for factor in (0.1, 10.0):
            weight = (factor * damping[:, None] * scale)[..., None] * identity
            step = np.linalg.solve(normal + weight, gradient)[..., 0]
            tried = theta.copy()
            tried[:, along] += np.minimum(np.maximum(step, -_LONGEST_STEP), _LONGEST_STEP)
            reached = deviances(mean(tried), data)
            better = (reached < value) & ~moved & still
            with np.errstate(invalid="ignore"):
                gained = np.where(better, value - reached, 0.0)
                least = np.maximum(least_gain, least_share * (reached - usual))
            theta = np.where(better[:, None], tried, theta)
            value = np.where(better, reached, value)
            damping = np.where(better, np.clip(factor * damping, 1e-9, 1e9), damping)
            still = still & ~(better & (gained < least))
            moved |= better
            if np.all(moved | ~still):
                break
        damping = np.where(moved, damping, damping * 100)
        still &= damping < 1e6
        if not still.any():
            break
    return theta, value


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


def _evaluated(program: Callable[..., Any], name: str, threes: Starts, nodes: Any, samples: Any):
    """What a program gives for all starts, as NumPy arrays."""
    # Filled up to sizes that are compiled; walkers of a posterior come in many, always as many.
    count = len(threes)
    size = next((each for each in (TOGETHER, ON_TRIAL) if count <= each), count)
    filled = threes if count == size else threes[np.minimum(np.arange(size), count - 1)]
    found = program(name, filled, nodes, samples)
    return jax.tree.map(lambda each: np.asarray(each)[:count], found)


@partial(jax.jit, static_argnums=0)
def _density(name, three, nodes, samples):
    return jax.vmap(lambda t: added_density(name, t, nodes, samples))(three)


@partial(jax.jit, static_argnums=0)
def _density_slopes(name, three, nodes, samples):
    def of_shape(shape, scale):
        return added_density(name, jnp.append(scale, shape), nodes, samples)

    slopes, density = _slopes_beside(of_shape, three[:, 1:], three[:, 0])
    # Along the log of its scale a density is its own slope.
    own = jnp.where(three[:, :1] > FLOOR, density, 0.0)
    return jnp.concatenate([own[:, None], slopes], axis=1), density


@partial(jax.jit, static_argnums=0)
def _gains(name, three, nodes, samples):
    return jax.vmap(lambda t: shaped(name, t, nodes, samples))(three)


@partial(jax.jit, static_argnums=0)
def _gain_slopes(name, three, nodes, samples):
    return _slopes_beside(lambda t: shaped(name, t, nodes, samples), three)


def _slopes_beside(values, along, *held):
    """Derivatives along some parameters, and beside them the values, which cost nothing more.

    Of each array of values, (starts, bins), derivatives of shape (starts, parameters, bins).
    """

    def twice(*parameters):
        found = values(*parameters)
        return found, found

    slopes, found = jax.vmap(jax.jacfwd(twice, has_aux=True))(along, *held)
    return jax.tree.map(lambda each: each.swapaxes(1, 2), slopes), found
