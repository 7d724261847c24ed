"""Recordings for the tests of fleets, all of one length, which is compiled for once."""

import json

import numpy as np

SAMPLES = 2048


def write_recording(path, seed, **more):
    """White noise of variance one at 50 Hz, and more channels beside it."""
    columns = {"gyro_x": np.random.default_rng(seed).standard_normal(SAMPLES), **more}
    units = json.dumps(dict.fromkeys(columns, "deg/s"))
    with path.open("wb") as file:
        np.savez(file, rate_hz=50.0, units=units, **columns)
    return path
