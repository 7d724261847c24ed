"""Temperature beside one channel of a recording: which one, its effect, its part of the JSON."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..formatting import finite, p_value, percent, reading, upper_limit
from ..identify._fit import Fit
from ..recording import Channel, Recording
from ._sensitivity import RESOLVED_P, TemperatureEffect, temperature_sensitivity

Treatment = Literal["show", "remove", "ignore"]
"""Whether temperature is shown beside the plain fit, taken out of it, or left alone."""

# An effect is said aloud below this, as a ramp is: whatever drifts slowly looks like one.
_CLAIMED_P = 0.005
_CONFOUNDED = 0.9
_CURVE_POINTS = 41
_MOST_PIECES = 120
_SAMPLES_A_PIECE = 16
_NAMES = ("linear", "quadratic")


@dataclass(frozen=True)
class ChannelTemperature:
    """The temperature beside a channel, and both fits of the channel."""

    channel: Channel
    """The temperature, in degC."""
    effect: TemperatureEffect
    """Its effect, with the fit from which it is taken out."""
    plain: Fit
    """The fit of the channel as it is."""
    removed: bool
    """Whether the main numbers of the channel are those of the fit without the effect."""

    @property
    def claimed(self) -> bool:
        """Whether the effect is beyond what a drift of the sensor's own makes by chance."""
        return float(self.effect.p_value) < _CLAIMED_P

    @property
    def confounded(self) -> bool:
        """Whether temperature rose or fell too evenly to be told from a rate ramp."""
        return float(self.effect.share_of_ramp) > _CONFOUNDED

    @property
    def beside_ramp(self) -> bool:
        """Whether the effect is drawn beside a rate ramp.

        A ramp that is not resolved is not drawn, here as in every figure: left free, it and the
        effect may each run far off and against the other.
        """
        return bool(self.effect.removed.resolved["R"])


def beside(channel: Channel, recording: Recording) -> Channel | None:
    """The temperature that goes with a channel: of the same axis if there are several."""
    temperatures = [each for each in recording.auxiliary if each.kind == "temperature"]
    axis = channel.name.rpartition("_")[2]
    same = [each for each in temperatures if each.name.rpartition("_")[2] == axis]
    return next(iter((*same, *temperatures)), None)


def effect_beside(
    channel: Channel, temperature: Channel, fit: Fit, removed: bool, seed: int
) -> ChannelTemperature:
    """The effect of a temperature on a channel.

    **Raises:** `ValueError`, as `temperature_sensitivity` does.
    """
    effect = temperature_sensitivity(
        fit, channel.samples, temperature.samples, channel.stretches, seed=seed
    )
    return ChannelTemperature(temperature, effect, fit, removed)


def temperature_document(
    found: ChannelTemperature, channel: Channel, kept: Mapping[str, Any], removed: Mapping[str, Any]
) -> dict[str, Any]:
    """The `temperature` of a channel in the fit JSON, in the unit that the user gave.

    `kept` and `removed` are the coefficients of the plain fit and of that without the effect.
    """
    effect = found.effect
    return {
        "channel": found.channel.name,
        "removed": found.removed,
        "mean_degC": effect.mean_degC,
        "range_degC": [effect.low_degC, effect.high_degC],
        **{name: _sensitivity(found, channel, index) for index, name in enumerate(_NAMES)},
        "p_value": finite(effect.p_value),
        "share_of_ramp": finite(effect.share_of_ramp),
        "confounded_with_ramp": found.confounded,
        "explained": {
            "fraction": finite(effect.explained),
            "by_chance_95": finite(effect.explained_by_chance),
        },
        "shortest_period_s": effect.shortest_period_s,
        "coefficients_kept": dict(kept),
        "coefficients_removed": dict(removed),
        "goodness_of_fit_removed": finite(effect.removed.goodness_of_fit),
        "curve": _curve(found, channel.factor),
        "slow": _slow(found, channel),
        "sentences": sentences(found, channel, kept, removed),
    }


def sentences(
    found: ChannelTemperature, channel: Channel, kept: Mapping[str, Any], removed: Mapping[str, Any]
) -> list[str]:
    """What temperature does to the channel, in words."""
    effect = found.effect
    span = f"{effect.low_degC:.4g} to {effect.high_degC:.4g} degC"
    numbers = " and ".join(_told(_sensitivity(found, channel, i)) for i in range(2))
    chance = p_value(float(effect.p_value))
    # The p-value alone decides: it allows for what is not known of the noise, and shares do not.
    if found.claimed:
        share = percent(float(effect.explained))
        said = [
            f"Temperature ({span}) moves the output by {numbers} ({chance}); it explains {share} "
            "of the slow variance that no straight line in time explains."
        ]
    elif float(effect.p_value) < RESOLVED_P:
        said = [
            f"Temperature ({span}) may move the output, by {numbers}; slow noise of the sensor's "
            f"own looks as much like it in {percent(float(effect.p_value))} of recordings "
            f"({chance}): record for longer, while the temperature rises and falls."
        ]
    else:
        said = [f"No effect of temperature ({span}) stands out of the noise ({chance}): {numbers}."]
    if found.claimed or found.removed:
        changes = [
            f"{symbol} goes from {_coefficient(kept[symbol])} to {_coefficient(removed[symbol])}"
            for symbol in ("B", "K", "R")
            if kept[symbol]["resolved"] or removed[symbol]["resolved"]
        ]
        state = "are without" if found.removed else "still hold"
        said.append(
            f"With that taken out, {', '.join(changes) or 'B, K and R stay unresolved'}; the main "
            f"coefficients {state} the effect."
        )
    if found.confounded:
        alone = _sensitivity(found, channel, 0)["without_ramp"]
        said.append(
            "The temperature changed so evenly with time that its effect can hardly be told from a "
            f"rate ramp: if the sensor has no ramp of its own, the linear sensitivity is "
            f"{_told(alone)}. Record while the temperature rises and falls."
        )
    return said


def _sensitivity(found: ChannelTemperature, channel: Channel, index: int) -> dict[str, Any]:
    effect, factor = found.effect, channel.factor
    unit = f"{channel.unit or '1'}/degC" + ("^2" if index else "")

    def quoted(ramp: bool) -> dict[str, Any]:
        draws = np.asarray(effect.draws if ramp else effect.draws_without_ramp)[:, index]
        return {
            "value": float(np.median(draws)) / factor,
            "unit": unit,
            "intervals": {
                str(level): (np.asarray(effect.interval(level, ramp=ramp))[index] / factor).tolist()
                for level in (0.68, 0.95)
            },
        }

    return {
        **quoted(ramp=True),
        "p_value": finite(effect.p_values[index]),
        "resolved": bool(effect.resolved[index]),
        "without_ramp": quoted(ramp=False),
    }


def _curve(found: ChannelTemperature, factor: float) -> dict[str, Any]:
    effect = found.effect
    points = np.linspace(effect.low_degC, effect.high_degC, _CURVE_POINTS)
    middle, band = effect.curve(points, ramp=found.beside_ramp)
    return {
        "temperature_degC": points.tolist(),
        "effect": (np.asarray(middle) / factor).tolist(),
        "band_95": (np.asarray(band).T / factor).tolist(),
        "beside_ramp": found.beside_ramp,
    }


def _slow(found: ChannelTemperature, channel: Channel) -> dict[str, list[float]]:
    """Means over pieces: of the samples less what is no effect of temperature, and of the effect.

    A ramp that is resolved beside temperature is no effect of it, nor is the mean.
    """
    effect, rate_hz = found.effect, float(found.plain.rate_hz)
    used = np.concatenate([np.arange(start, stop) for start, stop in channel.stretches])
    time, rest = used / rate_hz, channel.samples[used]
    if found.beside_ramp:
        rest = rest - float(effect.removed.estimate.least_squares[-1]) * time
    pieces = min(_MOST_PIECES, used.size // _SAMPLES_A_PIECE)
    edges = np.linspace(0, used.size, pieces + 1).astype(int)[:-1]
    size = np.diff(np.append(edges, used.size))

    def means(values: np.ndarray) -> np.ndarray:
        return np.add.reduceat(values, edges) / size

    temperature = means(found.channel.samples[used])
    moved = np.asarray(effect.curve(temperature, ramp=found.beside_ramp)[0])
    left = means(rest)
    return {
        "time_s": means(time).tolist(),
        "temperature_degC": temperature.tolist(),
        "residual": ((left - left.mean() + moved.mean()) / channel.factor).tolist(),
        "effect": (moved / channel.factor).tolist(),
    }


def _told(entry: Mapping[str, Any]) -> str:
    return str(reading(entry["value"], entry["intervals"]["0.95"], entry["unit"], signed=True))


def _coefficient(entry: Mapping[str, Any]) -> str:
    if entry["resolved"]:
        shown = reading(entry["value"], entry["intervals"].get("0.95"), entry["unit"])
        return f"{shown.value} {shown.unit}".rstrip()
    limit = upper_limit(entry["upper_limit_95"], entry["unit"])
    return str(limit).replace("<", "below").rstrip() if limit.value != "no limit" else limit.value
