"""HDF5, written by h5py: arrays, attributes, groups, and what is refused."""

import h5py
import numpy as np
import pytest

from allanfit.recording import RecordingError, contents, load, read_in_blocks


@pytest.fixture
def store(tmp_path):
    """Write arrays by their place, with attributes by the place of what they belong to."""

    def write(arrays, attributes=()):
        path = tmp_path / "a.h5"
        with h5py.File(path, "w") as file:
            for place, values in arrays.items():
                file[place] = values
            for place, name, value in attributes:
                file[place].attrs[name] = value
        return path

    return write


def names(recording):
    return [channel.name for channel in recording.channels]


def test_arrays_with_attributes(store, noise):
    path = store(
        {"gyro_x": noise[:, 0], "gyro_y": noise[:, 1].astype(">f4")},
        [("/", "rate_hz", 80.0), ("gyro_x", "units", "deg/s"), ("gyro_y", "units", b"rad/s")],
    )
    recording = load(path)
    assert (recording.rate_hz, names(recording)) == (80.0, ["gyro_x", "gyro_y"])
    x, y = recording.channels
    assert (x.unit, y.unit) == ("deg/s", "rad/s")
    np.testing.assert_array_equal(x.samples, noise[:, 0] * (np.pi / 180))
    np.testing.assert_array_equal(y.samples, noise[:, 1].astype(np.float32))


@pytest.mark.parametrize("turned", [False, True])
def test_matrices_in_a_group(store, noise, turned):
    felt = 0.01 * noise + [0, 0, 1]
    gyro, accel = (noise.T, felt.T) if turned else (noise, felt)
    path = store(
        {"imu/gyro": gyro, "imu/accel [g]": accel, "imu/time": np.arange(400) / 25},
        [("imu/gyro", "units", "dps")],
    )
    recording = load(path)
    assert names(recording) == [f"{name}_{axis}" for name in ("accel", "gyro") for axis in "xyz"]
    assert (recording.rate_hz, recording.findings) == (25.0, ())
    assert [channel.unit for channel in recording.channels] == 3 * ["g"] + 3 * ["dps"]
    np.testing.assert_allclose(
        recording.channels[5].samples / recording.channels[5].factor, noise[:, 2], rtol=1e-14
    )


def test_fields_of_a_compound_array(store, noise):
    table = np.zeros(400, [("time_s", "f8"), ("gyro", "f4", 3), ("n", "i4")])
    table["time_s"], table["gyro"] = np.arange(400) / 10, noise
    recording = load(store({"run/samples": table}))
    assert (recording.rate_hz, names(recording)) == (10.0, ["gyro_x", "gyro_y", "gyro_z"])
    np.testing.assert_array_equal(recording.channels[1].samples, noise[:, 1].astype(np.float32))
    assert "The channel n is left out: it is constant." in recording.findings


def test_groups_of_their_own_time(store, noise):
    slow, fast = np.arange(400) / 10, np.arange(400) / 100
    path = store({"a/gyro_x": noise[:, 0], "a/time": slow, "b/gyro_x": noise[:, 1], "b/time": fast})
    with pytest.raises(
        RecordingError, match=r"choose one of a \(400 samples\), b \(400 sam.*topic"
    ):
        load(path)
    recording = load(path, topic="/b")
    assert recording.rate_hz == 100.0
    np.testing.assert_array_equal(recording.channels[0].samples, noise[:, 1])
    assert [(topic.name, topic.rate_hz) for topic in contents(path)] == [("a", 10.0), ("b", 100.0)]
    with pytest.raises(RecordingError, match=r"no topic c; it has a \(400 samples\), b"):
        load(path, topic="c")
    # One clock written twice is one clock.
    path = store(
        {"a/gyro_x": noise[:, 0], "a/time": slow, "b/accel_x": noise[:, 1], "b/time": slow}
    )
    assert names(load(path)) == ["a_gyro_x", "b_accel_x"]


def test_a_clock_of_another_length_is_said(store, noise):
    path = store({"imu/gyro_x": noise[:, 0], "imu/time": np.arange(399.0), "fs": 60.0})
    said = "The time stamps imu/time have 399 values and the channels 400 samples: they are not"
    for read in (load, read_in_blocks):
        assert read(path).findings[0] == f"{said} used."
    with pytest.raises(RecordingError, match=rf"tells no sampling rate.*{said} used"):
        load(store({"imu/gyro_x": noise[:, 0], "imu/time": np.arange(399.0)}))
    # Another clock has the samples, or this one belongs to something else.
    slow = {"oven/temp": noise[:40, 0], "oven/time": np.arange(40.0)}
    for arrays in (
        {"gyro_x": noise[:, 0], "time": np.arange(400) / 60, "gps_time": np.arange(40.0)},
        {"imu/gyro_x": noise[:, 0], "fs": 60.0} | slow,
    ):
        assert not any("time stamps" in said for said in load(store(arrays)).findings)


def test_arrays_of_several_lengths(store, noise):
    path = store({"gyro": noise, "accel": noise[:300], "fs": 60.0, "calibration": np.eye(3)})
    with pytest.raises(
        RecordingError, match=r"accel \(300 samples\), gyro \(400 samples\) with --t"
    ):
        load(path)
    recording = load(path, topic="accel")
    assert (recording.rate_hz, len(recording.channels[0].samples)) == (60.0, 300)
    assert [(topic.name, topic.samples) for topic in contents(path)] == [
        ("accel", 300),
        ("gyro", 400),
    ]
    whole = load(store({"gyro": noise, "fs": 60.0, "calibration": np.eye(3)}))
    assert "The array calibration is left out: a channel is a series" in whole.findings[0]


def test_rates_that_disagree(store, noise):
    path = store({"gyro_x": noise[:, 0], "fs": 60.0, "rate_hz": 50.0})
    with pytest.raises(RecordingError, match=r"tells no sampling rate.*50 Hz and 60 Hz, and none"):
        load(path)
    assert load(path, rate_hz=55.0).rate_hz == 55.0


def test_units_together(store, noise):
    units = '{"gyro_x": "deg/s", "accel": "g"}'
    path = store({"gyro_x": noise[:, 0], "accel": noise, "units": units, "rate_hz": 10})
    assert {channel.unit for channel in load(path).channels} == {"deg/s", "g"}
    path = store({"gyro_x": noise[:, 0], "units": "{broken", "rate_hz": 10})
    with pytest.raises(RecordingError, match="`units` must be a JSON string"):
        load(path)


def test_links_out_of_the_file_are_not_followed(tmp_path, store, noise):
    store({"gyro_x": noise[:, 0]})
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["stolen"] = h5py.ExternalLink("a.h5", "gyro_x")
        file["loop"] = h5py.SoftLink("/")
        layout = h5py.VirtualLayout((400,), float)
        layout[:] = h5py.VirtualSource(str(tmp_path / "a.h5"), "gyro_x", (400,))
        file.create_virtual_dataset("virtual", layout)
        raw = [(str(tmp_path / "raw"), 0, 3200)]
        file.create_dataset("external", (400,), float, external=raw)
    with pytest.raises(
        RecordingError, match=r"holds no channel.*external is left out: its numbers"
    ):
        load(tmp_path / "b.h5", rate_hz=1.0)


def test_an_array_beyond_memory(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("gyro_x", (2**50,), "f8", chunks=(1024,), compression="gzip")
    with pytest.raises(RecordingError, match=r"swells to more than 200 times its size"):
        load(tmp_path / "a.h5", rate_hz=1.0)


def test_damage(store, noise, write):
    whole = store({"gyro_x": noise[:, 0]}).read_bytes()
    for name, data in {
        "cut.h5": whole[:-700],
        "text.hdf5": b"gyro\n1\n",
        "head.h5": whole[:100],
    }.items():
        with pytest.raises(RecordingError, match=rf"{name} is not an HDF5 file that can be read"):
            load(write(name, data), rate_hz=1.0)
    with pytest.raises(RecordingError, match="holds no channel: store each as an array"):
        load(store({"text": "hello"}), rate_hz=1.0)
