"""The expected density of a structure in each bin, and its derivatives, for many starts at once.

What each effect puts into the bins, and its derivatives, come from JAX, compiled once an effect,
for one start after another; what is put together of them is too little to be worth compiling for
each structure.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ...compilation import quick_to_compile
from ._holding import changing, foreign, held_rows, late_part
from ._in_bins import added_density, notched, shaped
from ._ordinates import points
from ._structure import (
    EACH,
    FLOOR,
    MEANS,
    NOTCH,
    SHAPE,
    SHAPING,
    TERMS,
    Data,
    Kinds,
    active,
    with_order,
    without_droop,
)

# Single ordinates are asked for by so many.
_LENGTH = 1024
# Starts that climb together. Programs are compiled for as many and serve fewer in less time; for
# another size they would have to be compiled again.
TOGETHER = 16

_quick = quick_to_compile(partial(jax.jit, static_argnums=0))
_quick_noise = quick_to_compile(partial(jax.jit, static_argnums=(0, 1)))

Starts = Float[np.ndarray, "starts parameters"]


def densities_and_slopes(
    theta: Starts, kinds: Kinds, data: Data, held
) -> tuple[Float[np.ndarray, "starts bins"], Float[np.ndarray, "starts parameters bins"]]:
    """The expected density for each start, and the derivatives of its logarithm."""
    gains, gain_slopes = _shape(theta, kinds, data, slopes=True)
    own = gains[2]
    gains, notch_slopes = _notched(theta, kinds, data, gains, slopes=True)
    bump, power = gains[2], powers(theta[:, :TERMS], data.terms)[..., None]
    noise = _rows(gains, kinds, held) * power
    total = noise.sum(axis=1) + foreign(data) * bump
    filtered, added = 0.0, []
    for name, three in zip(kinds.added, _slots(theta, kinds).swapaxes(0, 1), strict=True):
        slope, density = _evaluated(_slopes_of(data), name, three, data.bins.nodes, data.samples)
        left = bump
        if _passes(name, kinds):
            filtered = filtered + density
            left = left * gains[1]
        total = total + density * left
        added.append(slope * left[:, None])
    blocks = [noise]
    if gain_slopes is not None:
        folded, passed, bumped = gain_slopes
        strong = held * power
        behind = filtered + (strong[:, 0] if kinds.angle_filtered else 0.0)
        slow = strong[:, 2] + strong[:, 3] + behind
        slope = folded * (strong[:, 1] * bump)[:, None] + passed * (slow * bump)[:, None]
        blocks.append(slope + bumped * (total / own)[:, None])
    blocks += [slope * total[:, None] for slope in notch_slopes]
    return total, np.concatenate([*blocks, *added], axis=1) / total[:, None]


def expected_density(
    theta: Float[np.ndarray, " parameters"], kinds: Kinds, data: Data
) -> Float[np.ndarray, " bins"]:
    """The expected density of each bin [u^2]."""
    every = parts(theta[None], kinds, data, held_rows(data))
    return summed(powers(theta[None, :TERMS], data.terms), every, foreign(data))[0]


def log_slopes(
    theta: Starts, kinds: Kinds, data: Data
) -> Float[np.ndarray, "starts bins parameters"]:
    """Derivatives of the log of the expected density."""
    found = densities_and_slopes(theta, kinds, data, held_rows(data))[1].swapaxes(1, 2)
    return np.where(active(kinds, data.terms) & np.isfinite(found), found, 0.0)


def filter_slopes(
    shaping: str, four: Float[np.ndarray, " four"], nodes: Any, samples: Any
) -> tuple[Float[np.ndarray, " bins"], Float[np.ndarray, "bins three"]]:
    """The gain of a filter on white noise, aliases included, and its derivatives but of a floor."""
    slopes, gains = _evaluated(_gain_slopes, shaping, four[None], nodes, samples, room=1)
    return gains[0][0], slopes[0][0, :EACH].T


def parts(theta: Starts, kinds: Kinds, data: Data, held: Float[np.ndarray, "terms bins"]):
    """Rows of the terms, the bump, and what each added noise puts into each bin.

    For each start: shapes (starts, terms, bins), (starts, bins), or (starts, 1) where there is no
    bump, and (starts, bins) each. `held` are the `held_rows` of the data, which no parameter
    changes.
    """
    gains, _ = _shape(theta, kinds, data, slopes=False)
    gains, _ = _notched(theta, kinds, data, gains, slopes=False)
    slots = _slots(theta, kinds)
    added = [
        noise_density(name, slots[:, i], data) * (gains[1] if _passes(name, kinds) else 1.0)
        for i, name in enumerate(kinds.added)
    ]
    return _rows(gains, kinds, held), gains[2], added


def summed(
    power: Float[np.ndarray, "starts terms"], every, alien: float | Float[np.ndarray, " bins"]
) -> Float[np.ndarray, "starts bins"]:
    """All `parts` of a density together, terms of such powers; `alien` is what is `foreign`."""
    rows, bump, added = every
    total = (power[:, None] @ rows)[:, 0] + alien * bump
    for density in added:
        total = total + density * bump
    return total


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
    asked = name, threes, data.bins.nodes, data.samples
    # Of few, by the program for slopes: a climb has compiled it, or soon will.
    few = len(threes) <= TOGETHER
    if few:
        return _evaluated(_slopes_of(data), *asked)[1]
    return _evaluated(_density_of(data), *asked)


def noise_at(
    name: str,
    three: Float[np.ndarray, " three"],
    frequency: Float[np.ndarray, " frequencies"],
    data: Data,
) -> Float[np.ndarray, " frequencies"]:
    """What an added noise puts into single ordinates [u^2], at frequencies in cycles per sample."""
    nodes = _filled_up(frequency)
    three = np.asarray(three)[None]
    found = _evaluated(_density_of(data), name, three, nodes, data.samples, room=1)
    return found[0, : len(frequency)]


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
    four = with_order(kinds.shaping, theta[None, SHAPE])
    asked = without_droop(kinds.shaping), four, nodes, data.samples
    return _evaluated(_gains, *asked, room=1)[1][0, : len(frequency)]


def powers(
    logs: Float[np.ndarray, "starts sizes"], present: Any
) -> Float[np.ndarray, "starts sizes"]:
    """Those of sizes given by their logarithms, zero where they are not present."""
    return np.where(present, np.exp(np.minimum(np.maximum(logs, FLOOR), 60)), 0.0)


def _filled_up(frequency: Float[np.ndarray, " frequencies"]) -> Any:
    """Nodes at single frequencies, of a length that is one of few, so that few are compiled."""
    return points(np.pad(frequency, (0, -len(frequency) % _LENGTH), mode="edge"))


def _passes(name: str, kinds: Kinds) -> bool:
    """Whether the filter changes an added noise: a line is as large as it is among the samples."""
    return kinds.last and name != "drifting_line"


def _density_of(data: Data) -> Callable[..., Any]:
    return partial(_density, data.sampling)


def _slopes_of(data: Data) -> Callable[..., Any]:
    return partial(_density_slopes, data.sampling)


def _slots(theta: Starts, kinds: Kinds) -> Float[np.ndarray, "starts added three"]:
    return theta[:, kinds.first_slot :].reshape(len(theta), -1, EACH)


def _rows(gains, kinds: Kinds, held) -> Float[np.ndarray, "starts terms bins"]:
    folded, passed, bump = gains
    if kinds.shaping is None:
        return held * bump[:, None]
    angle = passed if kinds.angle_filtered else np.ones_like(folded)
    return held * np.stack([angle, folded, passed, passed], axis=1) * bump[:, None]


def _shape(theta: Starts, kinds: Kinds, data: Data, *, slopes: bool):
    """Filter, aliases and all or not, and bump of each start; their derivatives if asked for."""
    if kinds.shaping is None:
        one = np.ones((len(theta), 1))
        return (one, one, one), None
    four = with_order(kinds.shaping, theta[:, SHAPE])
    # A filter that droops is the same program as one that does not, and one of any ripple.
    asked = without_droop(kinds.shaping), four, data.bins.nodes, data.samples
    if kinds.shaping in MEANS:
        gains = _held(_evaluated(_gains, *asked), data)
        # Of whole numbers there is nothing to climb along.
        return gains, tuple(np.zeros((len(each), SHAPING, each.shape[1])) for each in gains)
    if not slopes and len(theta) > TOGETHER:
        return _held(_evaluated(_gains, *asked), data), None
    derivatives, gains = _evaluated(_gain_slopes, *asked)
    # The order of one that has ripple is no free parameter.
    derivatives = tuple(each[:, :SHAPING] for each in derivatives)
    return _held(gains, data), _held(derivatives, data)


def _notched(theta: Starts, kinds: Kinds, data: Data, gains, *, slopes: bool):
    """The gains with those of notches in the bump's; derivatives of the logarithm if asked for."""
    found = []
    for place in range(kinds.first_notch, kinds.first_slot, EACH):
        asked = NOTCH, theta[:, place : place + EACH], data.bins.nodes, data.samples
        if not slopes and len(theta) > TOGETHER:
            notch = _evaluated(_notch, *asked)
        else:
            slope, notch = _evaluated(_notch_slopes, *asked)
            found.append(slope / notch[:, None])
        gains = (*gains[:2], gains[2] * notch)
    return gains, found


def _held(gains, data: Data):
    """What filters do to white noise that is held after them, over what is held of all of it.

    It is late as `held_rows` has it, and what changes meanwhile is less than of white noise.
    """
    if data.repeat == 1:
        return gains
    white, *others = gains
    late = late_part(data) * white
    return (late + np.sum(white * changing(data), axis=-1, keepdims=True), *others)


def _evaluated(
    program: Callable[..., Any],
    name: str,
    threes: Starts,
    nodes: Any,
    samples: Any,
    room: int = TOGETHER,
):
    """What a program gives for all starts, as NumPy arrays.

    It has `room` for so many, of which fewer may come. Of single ordinates there may be millions.
    """
    # Filled up to what is compiled; walkers of a posterior come in many, always as many.
    count = len(threes)
    places = np.minimum(np.arange(room), count - 1)
    filled = threes[places] if count < room else threes
    found = program(name, count, filled, nodes, samples)
    return jax.tree.map(lambda each: np.asarray(each)[:count], found)


@_quick_noise
def _density(sampling, name, count, threes, nodes, samples):
    return _each(lambda t: added_density(name, t, nodes, samples, sampling), count, threes)


@_quick_noise
def _density_slopes(sampling, name, count, threes, nodes, samples):
    def along_all(three):
        def of_shape(shape):
            return added_density(name, jnp.append(three[0], shape), nodes, samples, sampling)

        slopes, density = _with_slopes(of_shape)(three[1:])
        # Along the log of its scale a density is its own slope.
        own = jnp.where(three[0] > FLOOR, density, 0.0)
        return jnp.concatenate([own[None], slopes]), density

    return _each(along_all, count, threes)


@_quick
def _notch(_name, count, threes, nodes, samples):
    return _each(lambda t: notched(t, nodes, samples), count, threes)


@_quick
def _notch_slopes(_name, count, threes, nodes, samples):
    return _each(_with_slopes(lambda t: notched(t, nodes, samples)), count, threes)


@_quick
def _gains(name, count, fours, nodes, samples):
    return _each(lambda t: shaped(name, t, nodes, samples), count, fours)


@_quick
def _gain_slopes(name, count, fours, nodes, samples):
    return _each(_with_slopes(lambda t: shaped(name, t, nodes, samples)), count, fours)


def _with_slopes(values):
    """What gives derivatives along all parameters beside the values, which cost nothing more.

    Of each array of values, (bins,), derivatives of shape (parameters, bins).
    """

    def twice(parameters):
        found = values(parameters)
        return found, found

    def both(parameters):
        slopes, found = jax.jacfwd(twice, has_aux=True)(parameters)
        return jax.tree.map(jnp.transpose, slopes), found

    return both


def _each(values, count, along):
    """What a function gives for the first so many of some starts, and zero for the rest.

    One start after another: of all at once each bin would compute again what depends on a start
    alone, and what only fills up the starts would cost as much as they do.
    """
    one = jax.eval_shape(values, along[0])
    nothing = jax.tree.map(lambda each: jnp.zeros((len(along), *each.shape), each.dtype), one)

    def put(place, found):
        here = values(along[place])
        return jax.tree.map(lambda every, each: every.at[place].set(each), found, here)

    return jax.lax.fori_loop(0, count, put, nothing)
