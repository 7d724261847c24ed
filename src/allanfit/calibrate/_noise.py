"""The noise of an axis, as draws of Q^2, N^2, B^2, K^2, R^2 that intervals are averaged over."""

import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..coefficients import read_coefficients
from ..curves import unit_scale
from ..identify import Fit, fit_series
from ..identify._goodness import MISFIT
from ..physics import SYMBOLS, Sampling
from ..recording import Channel
from ..recording._units import parse_unit

#: Coefficients by symbol in the unit of the channel, or a file of them.
StatedNoise = Mapping[str, float] | str | os.PathLike[str]


class Noise(NamedTuple):
    """What is known of the noise, in SI."""

    #: Squares of Q, N, B, K, R, shape (draws, 5); one draw when they are stated.
    powers: Float[np.ndarray, "draws terms"]
    weights: Float[np.ndarray, " draws"]
    findings: tuple[str, ...]


def stated_noise(given: StatedNoise, channel: Channel) -> Noise:
    """Noise that the user knows from elsewhere: one draw, without doubt.

    **Raises:** `ValueError` for a file or mapping without this channel, or in another unit.
    """
    if isinstance(given, Mapping):
        values, factor = given, channel.factor
    else:
        entries = read_coefficients(os.fspath(given))
        # A data sheet speaks of kinds of sensors.
        named = [entry for entry in entries if entry.channel in (channel.name, channel.kind)]
        if not named and len(entries) > 1:
            raise ValueError(
                f"{os.fspath(given)} has no channel {channel.name}; it has "
                f"{', '.join(entry.channel for entry in entries)}."
            )
        entry = (named or entries)[0]
        unit = parse_unit(entry.unit)
        if entry.unit and unit.kind != channel.kind:
            raise ValueError(
                f"The noise in {os.fspath(given)} is in {entry.unit}, which is not a unit of "
                f"{channel.name} ({channel.unit})."
            )
        values, factor = entry.medians, unit.factor if entry.unit else channel.factor
    for symbol, value in values.items():
        if symbol not in SYMBOLS or not 0 <= value < np.inf:
            raise ValueError(
                f"noise holds {symbol} = {value}; give zero or more for {', '.join(SYMBOLS)}."
            )
    powers = np.array([[(values.get(symbol, 0.0) * factor) ** 2 for symbol in SYMBOLS]])
    if not powers.any():
        raise ValueError("noise is all zero, and no sensor is; leave it out to have it fitted.")
    return Noise(powers, np.ones(1), ())


def fitted_noise(
    channels: Sequence[Channel], rate_hz: float, sampling: Sampling, seed: int
) -> Noise:
    """The posterior of one fit to all recordings of an axis, each without its mean.

    The fit gives the slope of each stretch away, lest a ramp pass for noise. Where it finds no
    ramp the slopes are what tells most about slow drift, and draws are weighted by them.

    **Raises:** `ValueError` when the fit does not converge.
    """
    pieces, stretches, start = [], [], 0
    for channel in channels:
        middle = mean(channel)
        for first, last in channel.stretches:
            pieces.append(channel.samples[first:last] - middle)
            stretches.append((start, start + last - first))
            start += last - first
    fit = fit_series(
        np.concatenate(pieces), rate_hz, sampling=sampling, seed=seed, stretches=tuple(stretches)
    )
    name = channels[0].name
    if not bool(fit.converged):
        raise ValueError(
            f"The noise of {name} cannot be fitted; give its coefficients with --noise."
        )
    findings = ()
    if float(fit.goodness_of_fit) < MISFIT:
        findings += (
            f"{name}: something is left out of the five-term noise model, and the intervals are "
            "only as good as that; allanfit fit shows where.",
        )
    ramp = bool(fit.resolved["R"])
    if ramp:
        findings += (
            f"{name}: the readings drift at a steady rate, which moves the scale factor by an "
            "unknown amount: wait until the sensor is warm, or record up, down and up again.",
        )
    powers = np.asarray(fit.estimate.draws, np.float64) ** 2
    if not ramp:
        powers[:, -1] = 0.0
    weights = np.ones(len(powers)) if ramp else _slope_weights(fit, powers)
    return Noise(powers, weights / weights.sum(), findings)


def mean(channel: Channel) -> float:
    """Of the usable samples [SI]."""
    used = [channel.samples[first:last] for first, last in channel.stretches]
    return float(np.mean(np.concatenate(used)))


def _slope_weights(
    fit: Fit, powers: Float[np.ndarray, "draws terms"]
) -> Float[np.ndarray, " draws"]:
    """Likelihood of the slope of each stretch under each draw, up to a factor.

    The slope is the one combination of odd cosine coefficients that the fit's spectrum drops, so
    that both together hold the information of all of them.
    """
    design, modes = fit.design, np.asarray(fit.estimate.statistics.odd_modes, np.float64)
    scale = np.asarray(unit_scale(1 / float(fit.rate_hz)), np.float64)
    per_sample = powers[:, :-1] / scale[:-1] ** 2
    log = np.zeros(len(powers))
    for odd, variance, projection in zip(
        modes, np.asarray(design.ramp_variance), design.projection, strict=True
    ):
        along = (np.asarray(projection.direction) * np.asarray(projection.weight))[::2][: len(odd)]
        along = np.pad(along, (0, len(odd) - len(along)))
        spread = per_sample @ (along**2 @ variance)
        log -= (np.log(spread) + (along @ odd) ** 2 / spread) / 2
    return np.exp(log - log.max())
