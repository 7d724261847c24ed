"""A fit document written by hand, from textbook curves with seeded scatter."""

import copy
import math
from typing import Any

import numpy as np
import pytest

SYMBOLS = ("Q", "N", "B", "K", "R")
GYRO_NAMES = (
    "quantization",
    "angle random walk",
    "bias instability",
    "rate random walk",
    "rate ramp",
)
ACCELEROMETER_NAMES = (
    "quantization",
    "velocity random walk",
    "bias instability",
    "acceleration random walk",
    "acceleration ramp",
)
SUFFIXES = {"Q": "*s", "N": "/sqrt(Hz)", "B": "", "K": "/sqrt(s)", "R": "/s"}


def allan_terms(values: dict[str, float], tau: np.ndarray) -> dict[str, np.ndarray]:
    """The Allan deviation of each term alone."""
    squares = {
        "Q": 3 / tau**2,
        "N": 1 / tau,
        "B": np.full_like(tau, 2 * math.log(2) / math.pi),
        "K": tau / 3,
        "R": tau**2 / 2,
    }
    return {symbol: values[symbol] * np.sqrt(squares[symbol]) for symbol in SYMBOLS}


def psd_terms(values: dict[str, float], frequency: np.ndarray, dt: float) -> dict[str, np.ndarray]:
    """The one-sided density of each term alone; a ramp has none."""
    shapes = {
        "Q": 8 * np.sin(math.pi * frequency * dt) ** 2 / dt,
        "N": np.full_like(frequency, 2.0),
        "B": 1 / (math.pi * frequency),
        "K": 1 / (2 * math.pi**2 * frequency**2),
        "R": np.zeros_like(frequency),
    }
    return {symbol: values[symbol] ** 2 * shapes[symbol] for symbol in SYMBOLS}


def _curve(
    terms: dict[str, np.ndarray],
    model: np.ndarray,
    scatter: np.ndarray,
    rng: np.random.Generator,
) -> tuple[list[float], dict[str, Any]]:
    data = model * np.exp(scatter * rng.standard_normal(model.size))
    width = np.exp(1.96 * scatter)
    return data.tolist(), {
        "model": model.tolist(),
        "band_95": [(data / width).tolist(), (data * width).tolist()],
        "terms": {symbol: values.tolist() for symbol, values in terms.items()},
    }


def _coefficient(name: str, unit: str, value: float, limit: float, width: float) -> dict[str, Any]:
    resolved = value > 0
    bounds = {
        level: [value * (1 - share * width), value * (1 + share * width)]
        if resolved
        else [0.0, limit * share]
        for level, share in (("0.68", 0.5), ("0.95", 1.0))
    }
    return {
        "name": name,
        "unit": unit,
        "value": value,
        "resolved": resolved,
        "upper_limit_95": None if resolved else limit,
        "intervals": bounds,
    }


def make_channel(
    name: str,
    unit: str,
    kind: str,
    values: dict[str, float],
    *,
    names: tuple[str, ...] = GYRO_NAMES,
    si_unit: str = "",
    rate_hz: float = 100.0,
    duration_s: float = 3600.0,
    seed: int = 0,
) -> dict[str, Any]:
    """One channel with the coefficients `values`, zero for a term that is not resolved."""
    rng = np.random.default_rng(seed)
    dt = 1 / rate_hz
    samples = int(duration_s * rate_hz)
    largest = int(math.log2(samples / 3))
    tau = dt * np.unique(np.round(2.0 ** np.arange(0, largest + 0.01, 1 / 4)))
    frequency = np.geomspace(2 / duration_s, rate_hz / 2, 70)
    allan = allan_terms(values, tau)
    psd = psd_terms(values, frequency, dt)
    adev = np.sqrt(sum(term**2 for term in allan.values()))
    density = np.asarray(sum(psd.values()))
    deviation, allan_entry = _curve(allan, adev, np.sqrt(0.4 * tau / duration_s), rng)
    averages = np.maximum(2.0, np.gradient(frequency) * duration_s)
    levels, psd_entry = _curve(psd, density, 1 / np.sqrt(averages), rng)
    typical = values["N"]
    limits = {"Q": 2e-3 * typical, "N": typical, "B": typical, "K": typical, "R": 3e-5 * typical}
    widths = {"Q": 0.1, "N": 0.0024, "B": 0.21, "K": 0.34, "R": 0.3}
    return {
        "channel": name,
        "unit": unit,
        "si_unit": si_unit,
        "kind": kind,
        "sampling": "point",
        "rate_hz": rate_hz,
        "samples": samples,
        "duration_s": duration_s,
        "mean": 0.012345678,
        "status": "converged",
        "coefficients": {
            symbol: _coefficient(
                full_name,
                (unit or "1") + SUFFIXES[symbol],
                values[symbol],
                limits[symbol],
                widths[symbol],
            )
            for symbol, full_name in zip(SYMBOLS, names, strict=True)
        },
        "goodness_of_fit": {"p_value": 0.41, "consistent": True},
        "posterior": {
            "sampler": "emcee",
            "draws": 8000,
            "effective_sample_size": {"N": 2100.0, "B": 1730.4, "K": 1811.0},
            "r_hat": {"N": 1.003, "B": 1.0071, "K": 1.001},
            "seed": 0,
            "acceptance_fraction": 0.43,
            "converged": True,
        },
        "curves": {
            "allan": {"tau_s": tau.tolist(), "deviation": deviation, **allan_entry},
            "psd": {"frequency_hz": frequency.tolist(), "density": levels, **psd_entry},
        },
        "findings": [],
    }


def make_influence(symbols: str, duration_s: float, marked: int) -> dict[str, Any]:
    """Even shares of 20 pieces, but for a marked one that holds half of the last term."""
    even, heavy = [1 / 20] * 20, [0.5 / 19] * 20
    heavy[marked] = 0.5
    return {
        "time_s": np.linspace(0, duration_s, 21).tolist(),
        "share": {symbol: heavy if symbol == symbols[-1] else even for symbol in symbols},
        "expected": dict.fromkeys(symbols, even),
        "stands_out": {
            symbol: [symbol == symbols[-1] and piece == marked for piece in range(20)]
            for symbol in symbols
        },
    }


def make_document() -> dict[str, Any]:
    """A gyro, an accelerometer and a channel of no known unit with a hostile name."""
    gyro = make_channel(
        "gyro_x",
        "deg/s",
        "gyro",
        {"Q": 0.0, "N": 5e-3, "B": 1e-3, "K": 1e-4, "R": 0.0},
        si_unit="rad/s",
    )
    gyro["slope_reading"] = {"Q": None, "N": 5.1e-3, "B": 1.63e-3, "K": 1.42e-4, "R": None}
    gyro["advice"] = ["To halve the interval of K record 6.2 h more (7.2 h in all)."]
    gyro["influence"] = make_influence("NBK", 3600.0, 13)
    gyro["findings"] = ["The code width is 0.8 of the noise; see `output_rounding`."]
    accelerometer = make_channel(
        "accel_z",
        "g",
        "accelerometer",
        {"Q": 4e-6, "N": 1.2e-4, "B": 3e-5, "K": 2e-6, "R": 0.0},
        names=ACCELEROMETER_NAMES,
        si_unit="m/s^2",
        seed=1,
    )
    accelerometer["posterior"] = None
    accelerometer["goodness_of_fit"] = {"p_value": 3.2e-7, "consistent": False}
    other = make_channel(
        "<script>alert('$x_1$')</script>",
        "",
        "other",
        {"Q": 0.0, "N": 0.02, "B": 0.0, "K": 1e-3, "R": 0.0},
        rate_hz=200.0,
        duration_s=600.0,
        seed=2,
    )
    other["status"] = "the least squares stopped after 200 steps"
    other["sampling"] = "averaged"
    return {
        "schema": "allanfit.fit/1",
        "recording": "bench <b>3</b>.csv",
        "allanfit_version": "0.1.0",
        "checksum": "sha256:3f1c9a",
        "findings": ["The time stamps repeat 2 times; <img src=x> was in the header."],
        "channels": [gyro, accelerometer, other],
    }


@pytest.fixture(scope="session")
def example() -> dict[str, Any]:
    """The document itself, for tests that only read it."""
    return make_document()


@pytest.fixture
def document(example: dict[str, Any]) -> dict[str, Any]:
    """A fresh copy, so that a test may change it."""
    return copy.deepcopy(example)
