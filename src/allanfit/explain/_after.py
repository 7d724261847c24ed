"""The coefficients with what was left out in the model: a fit like any other."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.fft import dct

from ..curves import unit_scale
from ..curves._design import RAMP_MODES
from ..curves._spectrum import ramp_coefficients
from ..identify import Fit
from ..identify._ramp import RampData, draw_ramps
from ._effect import Effect
from ._state import Investigation
from .spectrum._model import rise_without
from .spectrum._posterior import Draws
from .values._clipped import rails

# What goes through so many times the codes that hide it is seen beside their staircase.
_CLEAR = 10.0


def fit_after(
    fit: Fit, state: Investigation, draws: Draws, effects: Sequence[Effect], seed: int
) -> Fit:
    """The five-term `fit` with the coefficients of the better model in place of its own."""
    dt = state.stride / float(fit.rate_hz)
    scale = np.array(unit_scale(dt), float)
    # N is told for values at the rate of the log, before they are held.
    scale[1] /= np.sqrt(state.stride)
    terms = np.asarray(state.data.terms)
    best = np.where(terms, np.exp(state.model.theta[:4]), 0.0)
    power = draws.power.copy()
    for each in (power, best):
        each[..., 1] *= 1 - state.loud_part
    _unclip(state, power, best)
    _unround(state, power, best, seed)
    if state.unseen is not None:
        power[:, 1] -= np.random.default_rng(seed).choice(state.unseen, len(power))
        power[:, 1] = np.maximum(power[:, 1], 0.0)
    ramps, chance = _ramps(state, draws, seed)
    rises = np.array(
        [rise_without(k, state.model, state.data) if terms[k] else 0.0 for k in range(4)]
    )
    rises[best < _CLEAR**2 * _hidden(state)] = 0.0
    if any(effect.unmeasured for effect in effects):
        # What swings wanders as well, which nobody can tell from a walk of the sensor's own.
        rises[3] = 0.0
    dtype = fit.estimate.draws.dtype
    joined = np.concatenate([np.sqrt(power), ramps[:, None]], axis=1) * scale
    least = np.append(np.sqrt(best), np.median(ramps)) * scale
    return eqx.tree_at(
        lambda tree: (
            tree.estimate.draws,
            tree.estimate.least_squares,
            tree.estimate.deviance_rise,
            tree.estimate.ramp_p_value,
        ),
        fit,
        tuple(jnp.asarray(each, dtype) for each in (joined, least, rises, chance)),
    )


def _ramps(
    state: Investigation, draws: Draws, seed: int
) -> tuple[Float[np.ndarray, " draws"], float]:
    """A ramp for each draw of the noise, and the chance of none, with the effects as noise too."""
    odd, ramp, variance = [], [], []
    total, calm = state.variance, state.calm
    frequency = state.left.frequency
    own = state.left.expected @ np.where(state.data.terms, np.exp(state.model.theta[:4]), 0.0)
    # Filters hardly matter to the slowest modes; what is added does.
    extra = np.maximum(total - own, 0.0)
    for start, stop in state.pieces:
        length = stop - start
        values = calm[start:stop]
        coefficients = dct(values - values.mean(), norm="ortho")[1:]
        modes = min(RAMP_MODES, (length - 1) // 2)
        order = 1 + 2 * np.arange(modes)
        odd.append(coefficients[order - 1])
        ramp.append(ramp_coefficients(length)[order - 1])
        at = order / (2 * length)
        columns = [np.interp(at, frequency, column) for column in state.left.expected.T]
        # Below the first ordinate a random walk goes on as a power law.
        slow = np.maximum(frequency[0] / at, 1.0)
        columns[3] = columns[3] * slow**2
        columns[2] = columns[2] * slow
        variance.append(np.stack([*columns, np.interp(at, frequency, extra)], axis=1) / 2)
    data = RampData(
        jnp.asarray(np.concatenate(odd)),
        jnp.asarray(np.concatenate(ramp)),
        jnp.asarray(np.concatenate(variance)),
    )
    powers = np.concatenate([draws.power, np.ones((len(draws.power), 1))], axis=1)
    ramps, chance = draw_ramps(jax.random.key(seed), data, jnp.asarray(powers))
    return np.asarray(ramps), float(chance)


def _unclip(state: Investigation, power: Float[np.ndarray, "draws terms"], best) -> None:
    """Undo what rails do: they cut the spread of fast noise, and pass part of what is slow."""
    cut = rails(state)
    if cut is None:
        return
    factor = 1 / np.array([cut.variance, cut.variance, cut.gain**2, cut.gain**2])
    power *= factor
    best *= factor


def _unround(
    state: Investigation, power: Float[np.ndarray, "draws terms"], best, seed: int
) -> None:
    """Undo what coarse codes hide, and let N be as uncertain as that is.

    What they add was in the model, unless the samples were held.
    """
    added, deviation, logged, _ = state.rounding
    if state.format.repeat is not None:
        for each in (power, best):
            each[..., 1] = np.maximum(each[..., 1] - added, 0.0)
        return
    if added < 0:
        for each in (power, best):
            each[..., :2] *= (logged - added) / logged
    rng = np.random.default_rng(seed)
    scatter = deviation * rng.standard_normal(len(power))
    power[:, 1] = np.maximum(power[:, 1] + scatter, 0.0)
    if state.in_codes:
        # Of what is fast nothing is known, and any term may be all that hides, each by itself.
        power[:, :2] = 0.0
        power += _hidden(state) * rng.random(power.shape) ** 2


def _hidden(state: Investigation) -> Float[np.ndarray, " terms"]:
    """The power that each term may have and hide within a code."""
    return state.rounding.hidden / (state.left.expected.mean(axis=0) / 2)
