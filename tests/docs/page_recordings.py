"""The recordings that pages of the docs are about, short, and of one length.

One length is one compilation for all pages.
"""

from pathlib import Path

import numpy as np

import allanfit
from allanfit.recording import save

_RATE_HZ = 100.0
_SAMPLES = 16_384
# Flicker that so short a record shows.
_GYRO = {"N": 5e-3, "B": 5e-3}
_ACCELEROMETER = {"N": 1e-3, "B": 3e-4}


def make(name: str, folder: Path) -> None:
    """Write a recording of this name, or the noise of the accelerometers."""
    path = folder / name
    if name == "noise.yaml":
        path.write_text(f"unit: m/s^2\nN: {_ACCELEROMETER['N']}\nB: {_ACCELEROMETER['B']}\n")
    elif name in ("up.csv", "down.csv"):
        sense = 1 if name == "up.csv" else -1
        axis = 0.05 + sense * 9.85 + _drawn(_ACCELEROMETER, 5 + sense)
        save(path, {"accel_z": axis}, {"accel_z": "m/s^2"}, _RATE_HZ)
    elif name == "imu.npz":
        columns = {"gyro_x": _drawn(_GYRO, 3), "accel_z": 9.81 + _drawn(_ACCELEROMETER, 9)}
        save(path, columns, {"gyro_x": "deg/s", "accel_z": "m/s^2"}, _RATE_HZ)
    else:
        save(path, {"gyro_x": _drawn(_GYRO, 0)}, {"gyro_x": "deg/s"}, _RATE_HZ)


def _drawn(coefficients: dict[str, float], seed: int) -> np.ndarray:
    duration = _SAMPLES / _RATE_HZ
    return np.asarray(
        allanfit.simulate(coefficients, duration_s=duration, rate_hz=_RATE_HZ, seed=seed)
    )
