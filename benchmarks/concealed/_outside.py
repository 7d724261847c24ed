"""Causes that no catalogue has: to be called unexplained, not forced into a name."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.signal import butter, freqz, iirnotch, lfilter, sosfilt, sosfreqz

from ._device import SUB
from ._effect import Effect
from ._spectral import LowPass, Sinusoid, log_uniform, white_share
from ._strength import five_terms, folded, line_strength, modulation_strength, passes

LEVELS = (60, 100, 400)


@dataclass(frozen=True)
class Chirp(Effect):
    """A line whose frequency rises evenly from one end of the recording to the other."""

    name: ClassVar[str] = "chirp"
    levels: ClassVar[tuple[int, ...]] = LEVELS
    outside: ClassVar[bool] = True
    amplitude: float
    start: float
    end: float

    @classmethod
    def draw(cls, rng, device):
        start = log_uniform(rng, 0.05, 0.2) * device.rate_hz
        return cls(1.0, start, float(start * rng.uniform(1.3, 2)))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        return Sinusoid(1.0, self.start, 0.0).bracket(device)

    def signal(self, rng, device, fine):
        time = (np.arange(fine.size) + 1) * device.dt / SUB
        sweep = (self.end - self.start) / device.duration
        return fine + self.amplitude * np.sin(2 * np.pi * (self.start + sweep * time / 2) * time)

    def density(self, device, frequency):
        swept = (frequency >= self.start) & (frequency <= self.end)
        power = self.amplitude**2 / 2 / (self.end - self.start) * swept
        return five_terms(device)(frequency) + power * passes(device, frequency)


@dataclass(frozen=True)
class ModulatedLine(Effect):
    """A line that comes in short bursts: a comb of some ten lines about its frequency."""

    name: ClassVar[str] = "modulated_line"
    levels: ClassVar[tuple[int, ...]] = (400,)
    outside: ClassVar[bool] = True
    amplitude: float
    frequency: float
    period: float
    duty: ClassVar[float] = 0.15

    @classmethod
    def draw(cls, rng, device):
        frequency = log_uniform(rng, 2.0, 0.35 * device.rate_hz)
        return cls(1.0, frequency, float(rng.uniform(15, 60)))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        return Sinusoid(1.0, self.frequency, 0.0).bracket(device)

    def signal(self, rng, device, fine):
        time = (np.arange(fine.size) + 1) * device.dt / SUB
        on = (time / self.period) % 1 < self.duty
        return fine + self.amplitude * on * np.sin(2 * np.pi * self.frequency * time)

    def strength(self, device):
        seen = self.amplitude * float(np.sqrt(passes(device, self.frequency) * self.duty))
        return line_strength(device, seen, self.frequency)

    def band(self, device):
        half = 1 / (self.duty * self.period)
        return self.frequency - half, self.frequency + half


@dataclass(frozen=True)
class Cyclostationary(Effect):
    """White noise whose power rises and falls every few seconds."""

    name: ClassVar[str] = "cyclostationary"
    levels: ClassVar[tuple[int, ...]] = LEVELS
    outside: ClassVar[bool] = True
    inexact: ClassVar[tuple[str, ...]] = ("N",)
    depth: float
    period: float

    @classmethod
    def draw(cls, rng, device):
        return cls(0.5, float(rng.uniform(2, 20)))

    def sized(self, size):
        return replace(self, depth=size)

    def bracket(self, device):
        return 1e-3, 0.99

    def white(self, rng, device, fine):
        time = np.arange(fine.size) * device.dt / SUB
        return fine * np.sqrt(1 + self.depth * np.sin(2 * np.pi * time / self.period))

    def strength(self, device):
        phase = 2 * np.pi * (np.arange(64) + 0.5) / 64
        return modulation_strength(device, 1 + self.depth * np.sin(phase))


@dataclass(frozen=True)
class Notch(Effect):
    """White noise with a dip in its spectrum."""

    name: ClassVar[str] = "notch"
    levels: ClassVar[tuple[int, ...]] = LEVELS
    outside: ClassVar[bool] = True
    depth: float
    """Share of the amplitude that is missing at the bottom."""
    frequency: float
    width: float

    @classmethod
    def draw(cls, rng, device):
        frequency = float(rng.uniform(0.08, 0.35) * device.rate_hz)
        return cls(0.5, frequency, frequency * float(rng.uniform(0.02, 0.2)))

    def sized(self, size):
        return replace(self, depth=size)

    def bracket(self, device):
        return 1e-4, 0.99

    def _filter(self, device):
        return iirnotch(self.frequency, self.frequency / self.width, fs=SUB * device.rate_hz)

    def white(self, rng, device, fine):
        return (1 - self.depth) * fine + self.depth * lfilter(*self._filter(device), fine)

    def density(self, device, frequency):
        # The white noise is averaged over each interval even where other signals are not.
        averaged = replace(device, averaged=True)

        def fine(f):
            turn = 2 * np.pi * np.asarray(f) * device.dt / SUB
            notched = freqz(*self._filter(device), worN=turn)[1]
            return abs(1 - self.depth + self.depth * notched) ** 2

        return white_share(device, folded(averaged, fine, frequency), frequency)

    def features(self, device):
        return [(self.frequency, self.width)]


@dataclass(frozen=True)
class BandOfNoise(Effect):
    """A flat octave of noise between steep flanks: no resonance, no relaxation."""

    name: ClassVar[str] = "band_of_noise"
    levels: ClassVar[tuple[int, ...]] = LEVELS
    outside: ClassVar[bool] = True
    density_ratio: float
    """Density over that of N."""
    low: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, float(log_uniform(rng, 0.02, 0.15) * device.rate_hz))

    def sized(self, size):
        return replace(self, density_ratio=size)

    def bracket(self, device):
        return 1e-4, 1e4

    def _filter(self, device):
        band = [self.low, 2 * self.low]
        return butter(6, band, btype="bandpass", fs=SUB * device.rate_hz, output="sos")

    def signal(self, rng, device, fine):
        root = device.term("N") * np.sqrt(self.density_ratio * SUB / device.dt)
        return fine + sosfilt(self._filter(device), root * rng.standard_normal(fine.size))

    def density(self, device, frequency):
        def fine(f):
            turn = 2 * np.pi * np.asarray(f) * device.dt / SUB
            gain = abs(sosfreqz(self._filter(device), worN=turn)[1]) ** 2
            return 2 * device.term("N") ** 2 * self.density_ratio * gain

        return five_terms(device)(frequency) + folded(device, fine, frequency)


@dataclass(frozen=True)
class WanderingCorner(Effect):
    """A second-order low-pass that goes to and fro between two corners, a factor of three apart."""

    name: ClassVar[str] = "wandering_corner"
    levels: ClassVar[tuple[int, ...]] = (400,)
    outside: ClassVar[bool] = True
    filters: ClassVar[bool] = True
    high: float
    period: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, float(device.duration * rng.uniform(0.1, 0.4)))

    def sized(self, size):
        return replace(self, high=1 / size)

    def bracket(self, device):
        return LowPass(1.0, 2).bracket(device)

    def _corners(self):
        return [(LowPass(cutoff, 2), cutoff) for cutoff in (self.high, self.high / 3)]

    def low_pass(self, rng, device, fine):
        time = np.arange(fine.size) * device.dt / SUB
        wide, narrow = (c.low_pass(rng, device, fine) for c, _ in self._corners())
        return np.where((time / self.period) % 1 < 0.5, wide, narrow)

    def density(self, device, frequency):
        gains = [c.gain(device, cutoff, frequency)[0] for c, cutoff in self._corners()]
        return white_share(device, np.mean(gains, axis=0), frequency)
