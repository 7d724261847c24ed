"""Causes with a place in time: temperature, warm-up, steps, knocks."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from ._effect import Effect
from ._strength import five_terms, information, modulation_strength


@dataclass(frozen=True)
class Temperature(Effect):
    """A room that swings and wanders, a lag, and a sensitivity."""

    name: ClassVar[str] = "temperature"
    sensitivity: float
    swing: float
    """Amplitude of the room's cycle [K]."""
    period: float
    wander: float
    """Random walk of the room [K over the recording]."""
    lag: float
    """Thermal time constant of the sensor [s]."""
    seed: int
    logged: bool
    """Whether the thermometer is in the log."""

    @classmethod
    def draw(cls, rng, device):
        return cls(
            sensitivity=1.0,
            swing=float(rng.uniform(0.2, 2)),
            period=float(device.duration * rng.uniform(0.12, 0.45)),
            wander=float(rng.uniform(0.2, 1)),
            lag=float(device.duration * rng.uniform(0.01, 0.04)),
            seed=int(rng.integers(2**31)),
            logged=bool(rng.random() < 0.6),
        )

    def sized(self, size):
        return replace(self, sensitivity=size)

    def bracket(self, device):
        return 1e-3 * device.term("N"), 1e3 * device.term("N")

    def temperature(self, device):
        rng = np.random.default_rng(self.seed)
        time = np.arange(device.samples) * device.dt
        phase = rng.uniform(0, 2 * np.pi)
        room = self.swing * np.sin(2 * np.pi * time / self.period + phase)
        step = self.wander * np.sqrt(device.dt / device.duration)
        room = room + np.cumsum(step * rng.standard_normal(time.size))
        share = -np.expm1(-device.dt / self.lag)
        return lfilter([share], [1, share - 1], room, zi=[(1 - share) * room[0]])[0]

    def mean(self, device):
        return self.sensitivity * self.temperature(device) if self.logged else None

    def density(self, device, frequency):
        """What nobody measured is known by its spectrum: the cycle within 1/T, and the walk."""
        if self.logged:
            return None
        cycle = np.abs(frequency - 1 / self.period) < 0.5 / device.duration
        room = cycle * self.swing**2 / 2 * device.duration
        room = room + 2 * self.wander**2 / device.duration / (2 * np.pi * frequency) ** 2
        passed = 1 / (1 + (2 * np.pi * frequency * self.lag) ** 2)
        return five_terms(device)(frequency) + self.sensitivity**2 * room * passed

    def features(self, device):
        return () if self.logged else ((1 / self.period, 1 / device.duration),)

    def slow(self, rng, device, x):
        return x + self.sensitivity * self.temperature(device)

    def scored(self, device):
        return {"sensitivity": self.sensitivity} if self.logged else {}

    def accepted(self, device):
        # Without the thermometer it is a slow term, whatever its cause.
        return {self.name} | (set() if self.logged else {"gauss_markov", "random_telegraph"})


@dataclass(frozen=True)
class WarmUp(Effect):
    name: ClassVar[str] = "warm_up"
    amplitude: float
    time_constant: float
    sign: int

    @classmethod
    def draw(cls, rng, device):
        constant = device.duration * rng.uniform(0.02, 0.12)
        return cls(1.0, float(constant), int(rng.choice([-1, 1])))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-4 * white, 1e2 * white

    def mean(self, device):
        time = np.arange(device.samples) * device.dt
        return self.sign * self.amplitude * np.exp(-time / self.time_constant)

    def slow(self, rng, device, x):
        return x + self.mean(device)

    def times(self, device):
        return [(0.0, 2 * self.time_constant)]

    def scored(self, device):
        return {"amplitude": self.amplitude, "time_constant": self.time_constant}


@dataclass(frozen=True)
class Step(Effect):
    """A jump of the bias; or there and back."""

    name: ClassVar[str] = "step"
    amplitude: float
    moments: tuple[float, ...]
    sign: int

    @classmethod
    def draw(cls, rng, device):
        first = rng.uniform(0.12, 0.6)
        moments = [first] if rng.random() < 0.6 else [first, first + rng.uniform(0.1, 0.3)]
        times = tuple(float(device.duration * m) for m in moments)
        return cls(1.0, times, int(rng.choice([-1, 1])))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-4 * white, 1e2 * white

    def mean(self, device):
        time = np.arange(device.samples) * device.dt
        passed = np.searchsorted(self.moments, time, side="right")
        return self.sign * self.amplitude * (passed % 2)

    def slow(self, rng, device, x):
        return x + self.mean(device)

    def times(self, device):
        return [(t, t) for t in self.moments]

    def scored(self, device):
        return {"amplitude": self.amplitude}


@dataclass(frozen=True)
class Disturbance(Effect):
    """Knocks: damped ringing of the mount, each starting at its own moment."""

    name: ClassVar[str] = "disturbance"
    # As many places to look as samples: no weaker one can be told from chance.
    levels: ClassVar[tuple[int, ...]] = (50, 60, 100, 400)
    amplitude: float
    moments: tuple[float, ...]
    frequency: float
    decay: float

    @classmethod
    def draw(cls, rng, device):
        moments = np.sort(device.duration * rng.uniform(0.1, 0.9, rng.integers(1, 3)))
        frequency = rng.uniform(0.03, 0.2) * device.rate_hz
        return cls(1.0, tuple(moments.tolist()), float(frequency), float(rng.uniform(0.3, 2)))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-2 * white, 1e3 * white

    def mean(self, device):
        time, total = np.arange(device.samples) * device.dt, np.zeros(device.samples)
        for moment in self.moments:
            after = np.maximum(time - moment, 0)
            ring = np.exp(-after / self.decay) * np.sin(2 * np.pi * self.frequency * after)
            total += self.amplitude * ring
        return total

    def slow(self, rng, device, x):
        return x + self.mean(device)

    def times(self, device):
        return [(t, t + 2 * self.decay) for t in self.moments]


@dataclass(frozen=True)
class VarianceModulation(Effect):
    """Stretches in which the white noise is larger."""

    name: ClassVar[str] = "variance_modulation"
    inexact: ClassVar[tuple[str, ...]] = ("N",)
    excess: float
    """Power in the loud stretches over that in the quiet ones, less one."""
    loud: tuple[tuple[float, float], ...]

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, stretches(rng, device.duration))

    def sized(self, size):
        return replace(self, excess=size)

    def bracket(self, device):
        return 1e-4, 1e3

    def _power(self, device, count):
        time = (np.arange(count) + 0.5) * device.duration / count
        return 1 + self.excess * inside(time, self.loud)

    def white(self, rng, device, fine):
        power = self._power(device, fine.size)
        return fine * np.sqrt(power / power.mean())

    def strength(self, device):
        return modulation_strength(device, self._power(device, 2000))

    def times(self, device):
        return list(self.loud)


@dataclass(frozen=True)
class VibrationRectification(Effect):
    """Stretches of vibration, and a shift of the mean in proportion to its power."""

    name: ClassVar[str] = "vibration_rectification"
    levels: ClassVar[tuple[int, ...]] = (60, 100, 400)
    inexact: ClassVar[tuple[str, ...]] = ("N",)
    coefficient: float
    loud: tuple[tuple[float, float], ...]
    excess: ClassVar[float] = 1.0

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, stretches(rng, device.duration))

    def sized(self, size):
        return replace(self, coefficient=size)

    def bracket(self, device):
        power = device.term("N") ** 2 / device.dt
        return 1e-4 / np.sqrt(power), 1e2 / np.sqrt(power)

    def _loud(self, device):
        return inside(np.arange(device.samples) * device.dt, self.loud)

    def white(self, rng, device, fine):
        return fine * np.sqrt(
            1 + self.excess * np.repeat(self._loud(device), fine.size // device.samples)
        )

    def mean(self, device):
        power = self.excess * device.term("N") ** 2 / device.dt
        return self.coefficient * power * self._loud(device)

    def slow(self, rng, device, x):
        return x + self.mean(device)

    def strength(self, device):
        """Of the shift alone: the vibration is plain to see."""
        return float(information(device, mean=self.mean(device))[1].sum())

    def times(self, device):
        return list(self.loud)

    def scored(self, device):
        return {"coefficient": self.coefficient}

    def accepted(self, device):
        return {"vibration_rectification", "variance_modulation"}

    def member_strength(self, device):
        return self.strength(device)


def stretches(rng, duration):
    """Two to five, of which the loudest half of the recording consists."""
    count = int(rng.integers(2, 6))
    edges = np.sort(rng.uniform(0.04, 0.96, 2 * count)) * duration
    if np.diff(edges).min() < 0.01 * duration:
        return stretches(rng, duration)
    return tuple((float(a), float(b)) for a, b in edges.reshape(-1, 2))


def inside(time, intervals):
    edges = np.ravel(intervals)
    return (np.searchsorted(edges, time, side="right") % 2).astype(float)
