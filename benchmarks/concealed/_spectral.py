"""Causes that a spectrum shows: relaxations, resonances, filters, lines."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import butter, freqz, lfilter

from ._device import SUB, Device
from ._effect import LINE_LEVELS, Effect
from ._strength import five_terms, folded, line_strength, passes


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def relaxation_density(device: Device, variance: float, time: float, frequency):
    """Of a first-order recursion at the front end, converted."""
    step = device.dt / SUB
    decay = np.exp(-step / time)

    def fine(f):
        turn = np.exp(-2j * np.pi * f * step)
        return 2 * step * variance * (1 - decay**2) / abs(1 - decay * turn) ** 2

    return folded(device, fine, frequency)


@dataclass(frozen=True)
class GaussMarkov(Effect):
    name: ClassVar[str] = "gauss_markov"
    sigma: float
    correlation_time: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, log_uniform(rng, 5 * device.dt, device.duration / 80))

    def sized(self, size):
        return replace(self, sigma=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-4 * white, 10 * white

    def signal(self, rng, device, fine):
        decay = np.exp(-device.dt / SUB / self.correlation_time)
        kick = self.sigma * np.sqrt(1 - decay**2) * rng.standard_normal(fine.size)
        kick[0] = self.sigma * rng.standard_normal()
        return fine + lfilter([1], [1, -decay], kick)

    def density(self, device, frequency):
        about = (self.sigma**2, self.correlation_time, frequency)
        return five_terms(device)(frequency) + relaxation_density(device, *about)

    def scored(self, device):
        return {"sigma": self.sigma, "correlation_time": self.correlation_time}

    def accepted(self, device):
        return {"gauss_markov", "random_telegraph"}

    def member_strength(self, device):
        # What a two-level signal of this variance and correlation time would give away.
        return RandomTelegraph(2 * self.sigma, 2 * self.correlation_time).member_strength(device)


@dataclass(frozen=True)
class RandomTelegraph(Effect):
    name: ClassVar[str] = "random_telegraph"
    amplitude: float
    dwell_time: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, log_uniform(rng, 10 * device.dt, device.duration / 80))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 2e-4 * white, 20 * white

    def signal(self, rng, device, fine):
        dwells = rng.exponential(self.dwell_time, int(2 * device.duration / self.dwell_time) + 100)
        time = (np.arange(fine.size) + 1) * device.dt / SUB
        switches = np.searchsorted(np.cumsum(dwells), time) + rng.integers(2)
        return fine + self.amplitude * (switches % 2 - 0.5)

    def density(self, device, frequency):
        about = (self.amplitude**2 / 4, self.dwell_time / 2, frequency)
        return five_terms(device)(frequency) + relaxation_density(device, *about)

    def scored(self, device):
        return {"amplitude": self.amplitude, "dwell_time": self.dwell_time}

    def accepted(self, device):
        return {"gauss_markov", "random_telegraph"}

    def member_strength(self, device):
        """Twice the log Bayes factor of two levels over a normal relaxation of equal spectrum.

        Per switch, by amplitude over the noise of one dwell; simulated once with both exact
        likelihoods: 0.003, 0.023, 0.075, 0.33 at 2, 3, 4, 6.
        """
        ratio = self.amplitude * np.sqrt(self.dwell_time) / device.term("N")
        known = np.log([2, 3, 4, 6]), np.log([0.003, 0.023, 0.075, 0.33])
        slope = np.log(0.33 / 0.075) / np.log(6 / 4)
        nats = np.interp(np.log(ratio), *known, left=-np.inf)
        nats = nats if ratio < 6 else known[1][-1] + slope * np.log(ratio / 6)
        return 2 * device.duration / self.dwell_time * float(np.exp(min(nats, 0.0)))


@dataclass(frozen=True)
class Resonance(Effect):
    """A damped oscillator driven by white noise: two poles at the front end."""

    name: ClassVar[str] = "resonance"
    sigma: float
    """Deviation before the converter."""
    frequency: float
    quality_factor: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, log_uniform(rng, 1.0, 0.4 * device.rate_hz), log_uniform(rng, 3, 60))

    def sized(self, size):
        return replace(self, sigma=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-4 * white, 10 * white

    def _recursion(self, device):
        turn = 2 * np.pi * self.frequency * device.dt / SUB
        damping = 1 / (2 * self.quality_factor)
        radius, angle = np.exp(-damping * turn), turn * np.sqrt(1 - damping**2)
        first, second = 2 * radius * np.cos(angle), -(radius**2)
        # Yule and Walker: variance of the recursion for a unit kick.
        variance = (1 - second) / ((1 + second) * ((1 - second) ** 2 - first**2))
        return np.array([1, -first, -second]), self.sigma / np.sqrt(variance)

    def signal(self, rng, device, fine):
        poles, kick = self._recursion(device)
        return fine + lfilter([kick], poles, rng.standard_normal(fine.size))

    def density(self, device, frequency):
        poles, kick = self._recursion(device)
        step = device.dt / SUB

        def fine(f):
            turn = np.exp(-2j * np.pi * np.asarray(f)[..., None] * step * np.arange(3))
            return 2 * step * kick**2 / abs(turn @ poles) ** 2

        return five_terms(device)(frequency) + folded(device, fine, frequency)

    def features(self, device):
        return [(self.frequency, self.frequency / self.quality_factor)]

    def scored(self, device):
        gain = float(passes(device, self.frequency))
        return {
            "sigma": self.sigma * np.sqrt(gain),
            "frequency": self.frequency,
            "quality_factor": self.quality_factor,
        }


@dataclass(frozen=True)
class LowPass(Effect):
    """Butterworth, by a recursion at the front end; what it lets through folds."""

    name: ClassVar[str] = "low_pass"
    filters: ClassVar[bool] = True
    cutoff_frequency: float
    order: int

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0, int(rng.integers(1, 3)))

    def sized(self, size):
        """Size is the inverse of the cut-off."""
        return replace(self, cutoff_frequency=1 / size)

    def bracket(self, device):
        return 1 / (0.45 * SUB * device.rate_hz), 1 / (0.02 * device.rate_hz)

    def _filter(self, device, cutoff):
        return butter(self.order, cutoff, fs=SUB * device.rate_hz)

    def gain(self, device, cutoff, frequency):
        """Of white noise, converted; the floor at low frequency stays that of N."""
        numerator, denominator = self._filter(device, cutoff)

        def fine(f):
            turn = 2 * np.pi * np.atleast_1d(f) * device.dt / SUB
            return abs(freqz(numerator, denominator, worN=turn)[1]) ** 2

        floor = folded(device, fine, np.array([1e-6 * device.rate_hz]))
        return folded(device, fine, frequency) / floor, float(floor[0])

    def low_pass(self, rng, device, fine):
        _, floor = self.gain(device, self.cutoff_frequency, np.ones(1))
        return lfilter(*self._filter(device, self.cutoff_frequency), fine) / np.sqrt(floor)

    def density(self, device, frequency):
        gain, _ = self.gain(device, self.cutoff_frequency, frequency)
        white = 2 * device.term("N") ** 2
        return five_terms(device)(frequency) + white * (gain - 1)

    def scored(self, device):
        return {"cutoff_frequency": self.cutoff_frequency}

    def accepted(self, device):
        # White noise through one pole, sampled, is a relaxation exactly.
        return {"low_pass", "gauss_markov"} if self.order == 1 else {"low_pass"}


@dataclass(frozen=True)
class PowerLaw(Effect):
    """Fractionally summed white noise."""

    name: ClassVar[str] = "power_law"
    density_at_1_hz: float
    exponent: float

    @classmethod
    def draw(cls, rng, device):
        shallow = rng.random() < 0.5
        return cls(1.0, float(rng.uniform(0.35, 0.6) if shallow else rng.uniform(1.4, 1.7)))

    def sized(self, size):
        return replace(self, density_at_1_hz=size)

    def bracket(self, device):
        white = 2 * device.term("N") ** 2
        return 1e-6 * white, 1e2 * white

    def _kick(self, device):
        """Deviation of the white noise that is summed."""
        size = self.density_at_1_hz / (2 * device.dt)
        return np.sqrt(size * (2 * np.pi * device.dt) ** self.exponent)

    def slow(self, rng, device, x):
        # Three records long, so that its start is forgotten.
        count, half = 3 * x.size, self.exponent / 2
        size = next_fast_len(2 * count, real=True)
        ratio = (np.arange(1, count) - 1 + half) / np.arange(1, count)
        weights = np.concatenate([[1.0], np.cumprod(ratio)])
        noise = irfft(rfft(rng.standard_normal(count), size) * rfft(weights, size), size)
        return x + self._kick(device) * noise[2 * x.size : count]

    def density(self, device, frequency):
        sine = 2 * np.sin(np.pi * frequency * device.dt)
        added = 2 * device.dt * self._kick(device) ** 2 * sine**-self.exponent
        return five_terms(device)(frequency) + added

    def scored(self, device):
        return {"exponent": self.exponent, "density": self.density_at_1_hz}


@dataclass(frozen=True)
class Sinusoid(Effect):
    name: ClassVar[str] = "sinusoid"
    levels: ClassVar[tuple[int, ...]] = LINE_LEVELS
    line: ClassVar[bool] = True
    amplitude: float
    """Before the converter."""
    frequency: float
    phase: float

    @classmethod
    def draw(cls, rng, device):
        frequency = log_uniform(rng, 100 / device.duration, 0.45 * device.rate_hz)
        return cls(1.0, frequency, float(rng.uniform(0, 2 * np.pi)))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-4 * white, 1e3 * white

    def signal(self, rng, device, fine):
        time = (np.arange(fine.size) + 1) * device.dt / SUB
        return fine + self.amplitude * np.sin(2 * np.pi * self.frequency * time + self.phase)

    def _seen(self, device):
        return self.amplitude * float(np.sqrt(passes(device, self.frequency)))

    def strength(self, device):
        return line_strength(device, self._seen(device), self.frequency)

    def band(self, device):
        half = 0.5 / device.duration
        return self.frequency - half, self.frequency + half

    def scored(self, device):
        return {"amplitude": self._seen(device), "frequency": self.frequency}


@dataclass(frozen=True)
class DriftingLine(Effect):
    """A line whose frequency follows a slow normal process: a line of normal shape."""

    name: ClassVar[str] = "drifting_line"
    levels: ClassVar[tuple[int, ...]] = LINE_LEVELS
    line: ClassVar[bool] = True
    amplitude: float
    frequency: float
    """Mean over the recording."""
    spread: float
    """Standard deviation of the frequency over the recording [Hz]."""

    @classmethod
    def draw(cls, rng, device):
        narrowest = 10 / device.duration
        frequency = log_uniform(rng, max(1.0, 100 * narrowest), 0.4 * device.rate_hz)
        return cls(1.0, frequency, log_uniform(rng, narrowest, 0.02 * frequency))

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        white = device.term("N") / np.sqrt(device.dt)
        return 1e-4 * white, 1e3 * white

    def signal(self, rng, device, fine):
        # Slow against 1/spread, or the line would narrow; smooth enough to interpolate.
        knots = np.arange(0, device.duration + 2, 1.0)
        memory = np.exp(-1 / max(device.duration / 60, 3 / self.spread))
        drift = lfilter([1], [1, -memory], rng.standard_normal(knots.size + 2000))[2000:]
        drift = (drift - drift.mean()) / drift.std() * self.spread
        time = (np.arange(fine.size) + 1) * device.dt / SUB
        cycles = np.cumsum(np.interp(time, knots, drift) + self.frequency) * device.dt / SUB
        phase = rng.uniform(0, 2 * np.pi)
        return fine + self.amplitude * np.sin(2 * np.pi * cycles + phase)

    def density(self, device, frequency):
        about = (frequency - self.frequency) / self.spread
        shape = np.exp(-(about**2) / 2) / np.sqrt(2 * np.pi) / self.spread
        power = self.amplitude**2 / 2 * float(passes(device, self.frequency))
        return five_terms(device)(frequency) + power * shape

    def features(self, device):
        return [(self.frequency, 2 * self.spread)]

    def scored(self, device):
        seen = self.amplitude * float(np.sqrt(passes(device, self.frequency)))
        return {"amplitude": seen, "frequency": self.frequency}


def white_share(device: Device, gain, frequency):
    """Density when the white noise alone is changed by a power gain."""
    return five_terms(device)(frequency) + 2 * device.term("N") ** 2 * (gain - 1)
