"""What a cause beyond the five terms must say of itself.

An effect is a frozen dataclass of its physical parameters. It acts at the stages of the device
that it names, and knows its strength; stages left alone pass their input on.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import inf, log
from typing import ClassVar, Self

import numpy as np
from scipy.optimize import brentq

from ._device import Device
from ._strength import holding_band, information

SMOOTH_LEVELS = (12, 25, 50, 60, 100, 400)
LINE_LEVELS = (36, 64, 100, 400)


@dataclass(frozen=True)
class Effect(ABC):
    """Base of all; sizes are drawn for a strength by `at_strength`."""

    name: ClassVar[str]
    levels: ClassVar[tuple[int, ...]] = SMOOTH_LEVELS
    filters: ClassVar[bool] = False
    """Whether it is a filter between the front end and the converter."""
    line: ClassVar[bool] = False
    """Whether it is one frequency, to be located within 1/T."""
    outside: ClassVar[bool] = False
    """Whether no catalogue has it."""
    inexact: ClassVar[tuple[str, ...]] = ()
    """Coefficients that have no single true value beside this effect."""

    # -- how it is drawn

    @classmethod
    @abstractmethod
    def draw(cls, rng: np.random.Generator, device: Device) -> Self:
        """All but its size."""

    @abstractmethod
    def sized(self, size: float) -> Self:
        """The same at this size."""

    @abstractmethod
    def bracket(self, device: Device) -> tuple[float, float]:
        """Sizes between which the strength rises."""

    # -- what it does, stage by stage

    def white(self, rng, device, fine):
        """The front end's white noise."""
        return fine

    def signal(self, rng, device, fine):
        """What rides on it in the front end."""
        return fine

    def low_pass(self, rng, device, fine):
        """Both, before the converter."""
        return fine

    def slow(self, rng, device, x):
        """The rate at the output rate."""
        return x

    def converter(self, rng, device, x):
        return x

    def hold(self, rng, device, index):
        """Which sample each log entry repeats."""
        return index

    def keep(self, rng, device, index):
        """Which entries reach the log."""
        return index

    def lost(self, device: Device) -> int:
        """How many do not."""
        return 0

    def temperature(self, device: Device) -> np.ndarray | None:
        """Temperature of the sensor about its mean [K], where it is the cause."""
        return None

    # -- what is true of it

    def density(self, device: Device, frequency: np.ndarray) -> np.ndarray | None:
        """Expected density of the whole recording, for effects that a spectrum shows."""
        return None

    def mean(self, device: Device) -> np.ndarray | None:
        """What it adds to every recording alike."""
        return None

    def features(self, device: Device) -> Sequence[tuple[float, float]]:
        """Frequency and width [Hz] of what a coarse grid would miss."""
        return ()

    def information(self, device: Device):
        shape = self.density(device, np.ones(1))
        density = None if shape is None else lambda f: self.density(device, f)
        return information(device, density, self.mean(device), self.features(device))

    def strength(self, device: Device) -> float:
        return float(self.information(device)[1].sum())

    def band(self, device: Device) -> tuple[float, float] | None:
        """Frequencies [Hz] that hold 80 % of the information, where it has a place there."""
        if self.density(device, np.ones(1)) is None and self.mean(device) is None:
            return None
        return holding_band(*self.information(device))

    def times(self, device: Device) -> list[tuple[float, float]]:
        """Intervals [s] that hold the information, where it has a place there."""
        return []

    def scored(self, device: Device) -> dict[str, float]:
        """Parameters whose true values need no convention."""
        return {}

    def coefficients(self, device: Device) -> dict[str, float]:
        """N, B, K that an ideal analysis finds, where they are not the device's own."""
        return {}

    def accepted(self, device: Device) -> set[str]:
        """Names that nothing in the recording tells apart from its own."""
        return {self.name}

    def member_strength(self, device: Device) -> float:
        """Lambda of the witness that singles it out among those names."""
        return inf if len(self.accepted(device)) == 1 else 0.0


def at_strength(effect: Effect, device: Device, asked: float) -> Effect | None:
    """The same effect, sized to the strength asked for; None where no size reaches it."""
    low, high = (log(size) for size in effect.bracket(device))

    def excess(logarithm):
        return log(max(effect.sized(np.exp(logarithm)).strength(device), 1e-9) / asked)

    if excess(high) < 0 or excess(low) > 0:
        return None
    return effect.sized(float(np.exp(brentq(excess, low, high, xtol=1e-6))))


def truth(effect: Effect, device: Device) -> dict:
    """The entry of the answer key."""
    return {
        "name": effect.name,
        "parameters": asdict(effect),
        "lambda": effect.strength(device),
        "line": effect.line,
        "outside": effect.outside,
        "accepted": sorted(effect.accepted(device)),
        "member_lambda": min(effect.member_strength(device), 1e6),
        "band_hz": effect.band(device),
        "times_s": effect.times(device),
        "scored": effect.scored(device),
    }
