"""A sensor at rest, from its analog front end to its log.

    white noise, lines, resonances, ... at SUB times the output rate
      -> low-pass, if any -> converter: mean over an interval, or the value at its end
      -> + flicker, walk, ramp, thermal and mechanical offsets at the output rate
      -> angle rounding -> rails, rounding -> logger: repeats, losses, stamps

Slow parts join after the filter: below any corner drawn here it passes them untouched, and above
it they are a thousandth of the white noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .. import generators

if TYPE_CHECKING:
    from ._effect import Effect

SUB = 4
"""Front-end samples per output sample."""

# Short numbers are used where their steps are no larger beside what changes between samples.
_FINE = 0.01

# unit, rate [Hz], samples, coefficients [u = unit: Q u s, N u/sqrt(Hz), B u, K u/sqrt(s), R u/s];
# magnitudes of data sheets (consumer 0.3 deg/sqrt(h), industrial 0.15, tactical 0.05, ring laser
# 0.005 with counts of an arc second, which rule its samples).
PROFILES = {
    "consumer gyro": ("rad/s", 100.0, 360_000, {"N": 9e-5, "B": 3e-5, "K": 1.8e-6}),
    "consumer accelerometer": ("m/s^2", 100.0, 360_000, {"N": 1.5e-3, "B": 5e-4, "K": 3e-5}),
    "old MEMS gyro": (
        "rad/s", 50.0, 250_000, {"Q": 2.5e-4, "N": 1e-3, "B": 5e-4, "K": 6e-5, "R": 2e-8},
    ),
    "industrial gyro": ("rad/s", 200.0, 360_000, {"Q": 2e-7, "N": 4e-5, "B": 8e-6, "K": 7e-7}),
    "tactical gyro": ("rad/s", 200.0, 360_000, {"Q": 2e-8, "N": 1.5e-5, "B": 2e-6, "K": 5e-8}),
    "ring laser gyro": ("rad/s", 100.0, 300_000, {"Q": 1.5e-6, "N": 1.6e-6, "B": 3e-7, "K": 3e-8}),
}  # fmt: skip
ANY = "any sensor"
"""A profile by itself: whatever rate, length and corners between the five terms."""


@dataclass(frozen=True)
class Device:
    """What the five terms say of a sensor, and how it samples."""

    profile: str
    unit: str
    rate_hz: float
    samples: int
    averaged: bool
    """Whether each sample is a mean over its interval, or a value at its end."""
    flicker: str
    """`fractional` differencing of white noise, or a sum of `relaxations`."""
    angle: str
    """`white` angle error, or a `rounded` accumulated angle."""
    coefficients: dict[str, float]
    offset: float
    """Constant rate [u]."""

    @property
    def dt(self) -> float:
        return 1 / self.rate_hz

    @property
    def duration(self) -> float:
        return self.samples / self.rate_hz

    def term(self, symbol: str) -> float:
        return self.coefficients.get(symbol, 0.0)


def draw_device(rng: np.random.Generator, profile: str | None = None) -> Device:
    """A device of a profile, each coefficient within about 30 % of the profile's."""
    profile = profile or str(rng.choice([*PROFILES, ANY]))
    unit, rate_hz, samples, usual = _any_sensor(rng) if profile == ANY else PROFILES[profile]
    coefficients = {s: float(c * np.exp(0.25 * rng.standard_normal())) for s, c in usual.items()}
    # One in eight is odd but legal: a term absent, or four times the usual.
    if rng.random() < 0.125 and len(coefficients) > 1:
        odd = str(rng.choice([s for s in coefficients if s != "N"]))
        coefficients[odd] *= float(rng.choice([0.0, 4.0]))
    # One in eight has a ramp, from none to a plain one: up to six deviations of what a walk feigns.
    if rng.random() < 0.125:
        feigned = coefficients.get("K", 0.0) * np.sqrt(1.2 * rate_hz / samples)
        coefficients["R"] = float(rng.uniform(0, 6) * feigned)
    rounded = rng.random() < 0.1 and _rounding_is_white(coefficients, rate_hz)
    deviation = coefficients["N"] * np.sqrt(rate_hz)
    on_the_vertical = unit == "m/s^2" and rng.random() < 0.5
    return Device(
        profile=profile,
        unit=unit,
        rate_hz=rate_hz,
        samples=samples,
        averaged=bool(rng.random() < 0.5),
        flicker=str(rng.choice(["fractional", "relaxations"])),
        angle="rounded" if rounded else "white",
        coefficients=coefficients,
        offset=9.81 if on_the_vertical else float(3 * deviation * rng.standard_normal()),
    )


def _any_sensor(rng: np.random.Generator) -> tuple[str, float, int, dict[str, float]]:
    """A sensor of no data sheet, by where each term is as strong as the white noise.

    Rates from 5 to 1000 Hz, 50,000 to 600,000 samples; Q from a hundredth of the white noise to
    thirty times that at half the rate; flicker from three cycles of the record up, a walk from one,
    to a thirtieth of the rate; each term absent now and then.
    """

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    rate_hz = float(np.round(between(5, 1000)))
    samples = int(between(50_000, 600_000))
    white = between(1e-7, 1e-2)
    usual = {"N": white}
    if rng.random() < 0.5:  # 8 Q^2/dt = share x 2 N^2 at half the rate.
        usual["Q"] = white * np.sqrt(between(0.01, 30) / (4 * rate_hz))
    if rng.random() < 0.75:  # B^2/(pi f) = 2 N^2, densities of an unscaled B.
        usual["B"] = white * np.sqrt(2 * np.pi * between(3 * rate_hz / samples, rate_hz / 30))
    if rng.random() < 0.75:  # K^2/(2 pi^2 f^2) = 2 N^2.
        usual["K"] = white * 2 * np.pi * between(rate_hz / samples, rate_hz / 30)
    return str(rng.choice(["rad/s", "m/s^2"])), rate_hz, samples, usual


def _rounding_is_white(coefficients: dict[str, float], rate_hz: float) -> bool:
    """The angle must move by about a code between samples, else its error is no white noise."""
    step = coefficients.get("Q", 0.0) * np.sqrt(12)
    return 0 < step < 2 * coefficients["N"] / np.sqrt(rate_hz)


@dataclass(frozen=True)
class Surroundings:
    """What belongs to a recording beside the device."""

    temperature: bool = False
    """Whether the log has a temperature channel."""
    stamps: bool = False
    """Whether the log has time stamps."""
    jitter: float = 0.0
    """Standard deviation of a time stamp, in sampling intervals."""
    code_width: float = 0.0
    """Width of the converter's codes in standard deviations, too fine to matter."""


def simulate(
    device: Device, effects: Sequence["Effect"], surroundings: Surroundings, seed: Sequence[int]
) -> dict[str, np.ndarray]:
    """The arrays of a log: `data`, and `temperature` [degC] and `time_s` where it has them."""
    lost = sum(effect.lost(device) for effect in effects)
    long = replace(device, samples=device.samples + lost)
    streams = iter(np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(40))
    x = _front_end(long, effects, streams) + _slow_noise(long, next(streams)) + device.offset
    for effect in effects:
        x = effect.slow(next(streams), long, x)
    x = _angle_rounding(long, x, next(streams))
    if surroundings.code_width:
        code = surroundings.code_width * device.term("N") * np.sqrt(device.rate_hz)
        x = np.round(x / code) * code
    for effect in effects:
        x = effect.converter(next(streams), long, x)
    index = kept = np.arange(long.samples)
    for effect in effects:
        index = effect.hold(next(streams), long, index)
        kept = effect.keep(next(streams), long, kept)
    data = x[index][kept]
    fine = np.spacing(np.float32(np.abs(data).max())) < _FINE * np.std(np.diff(data))
    log = {"data": data.astype(np.float32) if fine else data}
    if surroundings.temperature:
        log["temperature"] = _thermometer(long, effects, next(streams))[kept].astype(np.float32)
    if surroundings.stamps:
        noise = surroundings.jitter * next(streams).standard_normal(kept.size)
        log["time_s"] = np.sort((kept + noise) * device.dt)
    return log


def _front_end(device, effects, streams):
    """White noise and what rides on it, converted to the output rate."""
    fine = device.samples * SUB
    white = device.term("N") * np.sqrt(SUB / device.dt) * next(streams).standard_normal(fine)
    signal = np.zeros(fine)
    for effect in effects:
        white = effect.white(next(streams), device, white)
        signal = effect.signal(next(streams), device, signal)
    filtered = white + signal
    for effect in effects:
        filtered = effect.low_pass(next(streams), device, filtered)
    if any(effect.filters for effect in effects):
        return convert(device, filtered)
    # Without a filter of its own the white noise keeps its density only if it is averaged.
    return white.reshape(-1, SUB).mean(axis=1) + convert(device, signal)


def convert(device: Device, fine: np.ndarray) -> np.ndarray:
    """To the output rate: the mean of an interval, or its last value."""
    blocks = fine.reshape(-1, SUB)
    return blocks.mean(axis=1) if device.averaged else blocks[:, -1]


def _slow_noise(device, rng):
    """Flicker, walk and ramp."""
    ways = {
        "fractional": generators.flicker_by_fractional_filter,
        "relaxations": generators.flicker_by_relaxations,
    }
    about = (device.dt, device.averaged)
    total = device.term("R") * device.dt * np.arange(device.samples)
    if device.term("B"):
        total = total + ways[device.flicker](rng, device.samples, device.term("B"), *about)
    if device.term("K"):
        total = total + generators.walk(rng, device.samples, device.term("K"), *about)
    return total


def _angle_rounding(device, x, rng):
    quantum = device.term("Q") * np.sqrt(12)
    if not quantum:
        return x
    if device.angle == "white":
        return x + generators.quantization(rng, x.size, device.term("Q"), device.dt, False)
    angle = np.concatenate([[rng.uniform(0, quantum)], x * device.dt]).cumsum()
    return np.diff(np.round(angle / quantum) * quantum) / device.dt


def _thermometer(device, effects, rng):
    """The cause's temperature, or an unrelated one: a room that wanders and cycles."""
    causes = [t for effect in effects if (t := effect.temperature(device)) is not None]
    time = np.arange(device.samples) * device.dt
    if causes:
        temperature = causes[0]
    else:
        period, phase = device.duration * rng.uniform(0.1, 0.4), rng.uniform(0, 2 * np.pi)
        walk = np.cumsum(rng.standard_normal(time.size)) / np.sqrt(time.size)
        temperature = rng.uniform(0, 0.5) * np.sin(2 * np.pi * time / period + phase)
        temperature = temperature + rng.uniform(0.1, 0.5) * walk
    return 25 + temperature + 0.01 * rng.standard_normal(time.size)
