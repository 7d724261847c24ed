"""MAT-files: version 5 written by SciPy, version 7.3 as MATLAB lays it out in HDF5."""

import h5py
import numpy as np
import pytest
import scipy.io

from allanfit.recording import RecordingError, contents, load


def write73(path, variables, opaque=()):
    """As MATLAB writes it: a block of text first, matrices turned, classes as attributes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in variables.items():
            if isinstance(values, str):
                file[name] = np.array([[ord(letter)] for letter in values], np.uint16)
                kind = "char"
            else:
                file[name] = np.atleast_2d(values).T
                kind = "double"
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
        for name, kind in opaque:
            file[name] = np.array([[0xDD000000], [2], [1], [1], [1], [1]], np.uint32)
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
            file[name].attrs["MATLAB_object_decode"] = 3
        file["#refs#/a"] = np.arange(500.0)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(10) + b"\2IM")
    return path


@pytest.fixture(params=["5", "7.3"])
def write(request, tmp_path):
    def save(variables):
        path = tmp_path / "a.mat"
        if request.param == "7.3":
            flat = {}
            for name, value in variables.items():
                inner = value.items() if isinstance(value, dict) else [("", value)]
                flat |= {f"{name}/{field}".rstrip("/"): each for field, each in inner}
            return write73(path, flat)
        scipy.io.savemat(path, variables, do_compression=True)
        return path

    return save


@pytest.mark.parametrize("rate", ["fs", "Fs", "rate_hz", "sampling_rate", "SampleRate"])
def test_matrices_and_a_rate(rate, write, noise):
    path = write({"gyro": noise, "accel_x": noise[:, :1], rate: 125.0, "note": "on the bench"})
    recording = load(path, unit="deg/s")
    assert recording.rate_hz == 125.0
    named = {channel.name: channel for channel in recording.channels}
    assert sorted(named) == ["accel_x", "gyro_x", "gyro_y", "gyro_z"]
    np.testing.assert_allclose(named["gyro_z"].samples, np.deg2rad(noise[:, 2]), rtol=1e-14)
    np.testing.assert_array_equal(named["accel_x"].samples, noise[:, 0])


def test_a_structure_with_time_and_units(write, noise):
    units = {"gyro": "deg/s", "accel": "mg"}
    imu = {"gyro": noise, "accel": noise + 1, "time": np.arange(400.0) / 20}
    recording = load(write({"imu": imu, "units": units}))
    assert recording.rate_hz == 20.0
    assert {channel.name: channel.unit for channel in recording.channels} == {
        f"{name}_{axis}": unit for name, unit in units.items() for axis in "xyz"
    }


def test_structures_of_several_devices(write, noise):
    one, two = {"gyro": noise, "fs": 10.0}, {"gyro": noise[:300], "fs": 20.0}
    path = write({"a": one, "b": two})
    with pytest.raises(RecordingError, match=r"choose one of a \(400 samples\), b \(300 samples\)"):
        load(path)
    assert load(path, topic="b").rate_hz == 20.0
    assert [(topic.name, topic.rate_hz) for topic in contents(path)] == [("a", 10.0), ("b", 20.0)]


def test_what_only_matlab_can_read(tmp_path, noise):
    path = write73(tmp_path / "a.mat", {"fs": 10.0}, [("log", "timetable")])
    with pytest.raises(
        RecordingError, match=r"log is a MATLAB timetable, .* table2struct\(timetab"
    ):
        load(path)
    path = write73(path, {"fs": 10.0, "gyro_x": noise[:, 0]}, [("log", "timetable"), ("c", "cell")])
    first, second, *_ = load(path).findings
    assert "c is a MATLAB cell" in first
    assert "log is a MATLAB timetable" in second


@pytest.mark.parametrize("shapes", [[(3,), (4,)], [(2, 3), (2, 4)], [(3,), (3,)]])
def test_a_cell_with_a_structure_is_left_out_and_said(shapes, tmp_path, noise):
    path, cell = tmp_path / "a.mat", np.empty(3, object)
    cell[:] = [{"a": 1.0}, *map(np.ones, shapes)]
    scipy.io.savemat(path, {"gyro_x": noise[:, 0], "fs": 10.0, "odd": cell})
    recording = load(path, unit="deg/s")
    assert recording.findings == ("odd is left out: it is no array of real numbers.",)
    np.testing.assert_allclose(recording.channels[0].samples, np.deg2rad(noise[:, 0]), rtol=1e-14)


def test_damage(tmp_path, noise):
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"gyro_x": noise[:, 0], "fs": 10.0}, do_compression=True)
    whole = path.read_bytes()
    for data in (whole[:-300], whole[:200], b"gyro\n1\n" * 30, whole[:140] + bytes(200)):
        path.write_bytes(data)
        with pytest.raises(RecordingError, match=r"a\.mat "):
            load(path)
    path.write_bytes(write73(tmp_path / "b.mat", {"gyro_x": noise[:, 0]}).read_bytes()[:-900])
    with pytest.raises(RecordingError, match=r"a\.mat is not an HDF5 file that can be read"):
        load(path)
    scipy.io.savemat(path, {"words": np.array(["a", 1], object), "z": noise[:, 0] * 1j})
    with pytest.raises(RecordingError, match=r"holds no channel.* words is left out"):
        load(path)
