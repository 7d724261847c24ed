"""One effect that a recording holds, with its parameters in SI units and seconds."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

_TOLD_APART = {
    "temperature": "log the temperature beside the data and record again",
    "sinusoid": "log the temperature beside the data and record again",
    "gauss_markov": "a longer recording: exponents and corners differ over more decades",
    "random_telegraph": "a longer recording: two levels show in the histogram of block means",
    "resonance": "a longer recording, or another mounting: a resonance moves with it",
    "power_law": "a longer recording: exponents and corners differ over more decades",
    "low_pass": "record with another filter setting or output rate",
    "drifting_line": "a longer recording: a line keeps its amplitude, a resonance does not",
    "step": "a longer recording: a step stays, a walk returns",
    "warm_up": "record again with the sensor warm: a warm-up is gone",
    "output_rounding": "record in a finer range",
    "sample_hold": "read the sensor at its own output rate",
    "variance_modulation": "log what runs beside the sensor",
    "vibration_rectification": "switch the vibration on and off",
    "bump": "record with another filter setting, mounting or rate and see what moves",
}

# What else may follow from a change of temperature.
_TEMPERED = ("temperature", "sinusoid", "warm_up")


# Told apart by identity: draws are arrays, which `==` compares one by one.
@dataclass(frozen=True, eq=False)
class Effect:
    """One effect that the recording holds."""

    name: str
    probability: float
    #: Rivals with their probabilities.
    alternatives: dict[str, float]
    #: Draws of each parameter in SI units and seconds, shape (draws,), or a list without spread.
    parameters: dict[str, Float[np.ndarray, " draws"]]
    lists: dict[str, list[Any]] = field(default_factory=dict)
    #: Where it shows [Hz], for the figures.
    band_hz: tuple[float, float] | None = None
    #: What is known of it beside its parameters.
    note: str = ""
    #: Whether it shows in time alone.
    in_time: bool = False
    #: What is told of parameters in place of the medians of their draws.
    told: dict[str, float] = field(default_factory=dict)
    #: How many times as large N is at low frequency, of values that are held.
    held: float = 1.0
    #: Whether the temperature beside the sensor is known.
    felt: bool = False

    @property
    def unmodelled(self) -> bool:
        """Whether it has no name, and the better model does nothing about it."""
        idle = self.name == "bump" and "high_pass" not in self.parameters
        return idle and not np.any(self.parameters["height"])

    @property
    def unmeasured(self) -> bool:
        """Whether it is a swing of temperature that nobody has measured."""
        return "time_scale" in self.parameters and not self.felt

    def value(self, name: str) -> float:
        """What is told of a parameter, mostly its median."""
        return self.told.get(name, float(np.median(self.parameters[name])))

    def told_apart(self, rival: str) -> str:
        """What would tell it from a rival."""
        if {self.name, rival} == {"gauss_markov", "random_telegraph"}:
            # They share a spectrum.
            return _TOLD_APART["random_telegraph"]
        if self.felt and rival in _TEMPERED:
            return "change the temperature on purpose, up and down, and record again"
        return _TOLD_APART.get(rival, _TOLD_APART.get(self.name, "a longer recording"))
