"""Effects as parts of a state-space model, where they have one."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..formatting import listed, significant
from ..physics import AbstractAddedNoise, AbstractEffect, parameter_unit, parameter_values
from ._read import FitChannel
from ._state_space import Part, State


def effect_parts(channel: FitChannel) -> tuple[list[Part], list[str]]:
    """The parts of a channel's effects, and a sentence for each effect that says how it entered."""
    parts, how = [], []
    for index, effect in enumerate(channel.effects, 1):
        make = _MAKERS.get(effect.name)
        if make is None:
            why = (
                "no finite number of states has its spectrum"
                if isinstance(effect, AbstractAddedNoise)
                else "it is no stationary noise beside the others"
            )
            how.append(f"not in these matrices: {why}")
            continue
        suffix = "" if len(channel.effects) == 1 else f"_{index}"
        values = {name: float(value) for name, value in parameter_values(effect).items()}
        part, sentence = make(f"{effect.name}{suffix}", channel.unit, values)
        parts.append(part)
        how.append(sentence)
    return parts, how


def effect_entries(channel: FitChannel, how: Sequence[str]) -> list[dict[str, Any]]:
    """The effects of a channel for a JSON, as explain writes them, and how each entered."""
    return [
        {
            "name": effect.name,
            "parameters": {
                parameter.name: {
                    "value": parameter_values(effect)[parameter.name].tolist(),
                    "unit": parameter_unit(parameter, channel.unit),
                }
                for parameter in effect.parameters
                if parameter.name in parameter_values(effect)
            },
            "how": sentence,
        }
        for effect, sentence in zip(channel.effects, how, strict=True)
    ]


def left_out(channels: Sequence[FitChannel], what: str, held: frozenset[str]) -> list[str]:
    """A sentence for each effect that `what` cannot hold, with all channels that have it alike.

    Lost samples, for one, are the recording's, and each of its channels has as many.
    """
    # Names in their order, each once.
    found: dict[str, dict[str, None]] = {}
    for channel in channels:
        for effect in channel.effects:
            if effect.name not in held:
                said = f"{effect.what}{_description(effect, channel.unit)}"
                found.setdefault(said, {})[channel.name] = None
    return [
        f"{what} has no place for what explain found in {listed(alike)}: {said}."
        for said, alike in found.items()
    ]


def _description(effect: AbstractEffect, unit: str) -> str:
    values = parameter_values(effect)
    numbers = [
        f"{each.name} {significant(float(values[each.name]))} {parameter_unit(each, unit)}".strip()
        for each in effect.parameters
        if each.name in values and values[each.name].ndim == 0
    ]
    return f" ({', '.join(numbers)})" if numbers else ""


def gauss_markov(term: str, name: str, unit: str, time_s: float, variance: float) -> Part:
    """A stationary relaxation: b' = -b/T + w, Qc = 2 sigma^2/T."""
    one = np.ones((1, 1))
    state = State(name, unit, variance)
    return Part(term, (state,), -one / time_s, one, 2 * variance / time_s * one, one)


def _gauss_markov(name: str, unit: str, values: Mapping[str, float]) -> tuple[Part, str]:
    variance = values["sigma"] ** 2
    part = gauss_markov("gauss_markov", name, unit, values["correlation_time"], variance)
    return (
        part,
        "an exact first-order Gauss-Markov state: Phi = exp(-dt/T), Qd = sigma^2 (1 - Phi^2)",
    )


def _telegraph(name: str, unit: str, values: Mapping[str, float]) -> tuple[Part, str]:
    share = values.get("upper_share", 0.5)
    spread = share * (1 - share)
    variance, time_s = values["amplitude"] ** 2 * spread, values["dwell_time"] * 2 * spread
    part = gauss_markov("random_telegraph", name, unit, time_s, variance)
    return part, "a Gauss-Markov state of the same autocovariance; its two levels are not in it"


def _resonance(name: str, unit: str, values: Mapping[str, float]) -> tuple[Part, str]:
    """X'' + (w/Q) x' + w^2 x = w^2 n, of displacement x and x'/w, each of variance sigma^2."""
    omega, variance = 2 * np.pi * values["frequency"], values["sigma"] ** 2
    damping = omega / values["quality_factor"]
    part = Part(
        "resonance",
        (State(name, unit, variance), State(f"{name}_rate", unit, variance)),
        np.array([[0.0, omega], [-omega, -damping]]),
        np.array([[0.0], [1.0]]),
        np.array([[2 * damping * variance]]),
        np.array([[1.0, 0.0]]),
    )
    return part, "two exact states: the displacement, and its rate over 2 pi times the frequency"


_MAKERS: dict[str, Callable[[str, str, Mapping[str, float]], tuple[Part, str]]] = {
    "gauss_markov": _gauss_markov,
    "random_telegraph": _telegraph,
    "resonance": _resonance,
}
#: Effects that have states.
STATES = frozenset(_MAKERS)
