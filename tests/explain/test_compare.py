"""A recording beside a simulation of the same, of something else, or of another strength."""

import json

import numpy as np
import pytest

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain._compare import compared, references
from allanfit.identify import fit_series

RATE, SAMPLES = 100.0, 4096


def written(path, values, unit, name="gyro_x"):
    units = {"units": json.dumps({name: unit})} if unit else {}
    np.savez(path, rate_hz=RATE, **{name: values}, **units)
    return path


def test_a_simulation_of_the_same_sensor_differs_by_chance_only(tmp_path):
    """Of 60 pairs each below .005 with that chance: four or more happen once in 3000."""
    rng = np.random.default_rng(1)

    def noise():
        walk = np.cumsum(rng.standard_normal(SAMPLES))
        return 0.01 * walk + rng.standard_normal(SAMPLES)

    differing = 0
    for _ in range(60):
        recording = allanfit.load(written(tmp_path / "a.npz", noise(), "deg/s"))
        simulation = written(tmp_path / "b.npz", noise(), "deg/s")
        fit = fit_series(recording.channels[0].samples, RATE)
        (reference,) = references(simulation, recording, "point").values()
        differing += bool(compared(fit, reference, []))
    assert differing < 4


def test_what_measures_something_else_is_refused(tmp_path):
    values = np.random.default_rng(2).standard_normal(SAMPLES)
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    for name in ("gyro_x", "accel_x"):
        other = written(tmp_path / "b.npz", values, "m/s^2", name)
        with pytest.raises(ValueError, match=r"in m/s\^2, the recording in deg/s"):
            explain_recording(recording, simulation=other)


def test_what_has_no_unit_is_in_the_recordings(tmp_path):
    values = np.random.default_rng(3).standard_normal(SAMPLES)
    recording = allanfit.load(written(tmp_path / "a.npz", values, "deg/s"))
    bare = written(tmp_path / "b.npz", values, "")
    lines = tmp_path / "c.yaml"
    lines.write_text("N: 0.1\n")
    for simulation in (bare, lines):
        (reference,) = references(simulation, recording, "point").values()
        # N of unit variance at 100 Hz is 0.1 deg/s/sqrt(Hz).
        assert reference.coefficients[1] == pytest.approx(0.1 * np.pi / 180, rel=0.1)
