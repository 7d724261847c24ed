"""What holds for every format: equal samples, lists of contents, extras that are missing."""

import json
import sys

import h5py
import numpy as np
import polars as pl
import pytest
import scipy.io
from recording_files import ROS1, ROS2, imu, write_bag, write_ulog

from allanfit.recording import RecordingError, contents, is_recording, load
from allanfit.recording._formats import _FORMATS

AXES = [f"{name}_{axis}" for name in ("gyro", "accel") for axis in "xyz"]
COMBINED = "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;"


def written(folder, columns, units, rate_hz):
    """The same channels in every table format."""
    stem = folder / "a"
    np.savez(stem, **columns, rate_hz=rate_hz, units=json.dumps(units))
    bracketed = {f"{name} [{units[name]}]": values for name, values in columns.items()}
    time = np.arange(len(next(iter(columns.values())))) / rate_hz
    pl.DataFrame({"time_s": time} | bracketed).write_parquet(folder / "a.parquet")
    scipy.io.savemat(folder / "a.mat", {"imu": columns, "units": units, "fs": rate_hz})
    with h5py.File(folder / "a.h5", "w") as file:
        file.attrs["rate_hz"] = rate_hz
        for name, values in columns.items():
            file[f"imu/{name}"] = values
            file[f"imu/{name}"].attrs["units"] = units[name]
    return [folder / f"a.{ending}" for ending in ("npz", "parquet", "mat", "h5")]


@pytest.mark.parametrize("name", ["bmi270", "vn100", "xsens_tstick", "adis16405_a"])
def test_a_real_recording_is_the_same_in_every_table(name, shared, tmp_path):
    with np.load(shared / "recordings" / f"{name}.npz") as content:
        rate_hz, units = float(content["rate_hz"]), json.loads(content["units"].item())
        columns = {
            each: content[each]
            for each in content.files
            if each in units and content[each].ndim == 1 and not each.startswith(("time", "mag"))
        }
    # Only in this order do all formats keep it: HDF5 sorts by name.
    columns = dict(sorted(columns.items()))
    first, *others = [
        load(path, rate_hz=rate_hz) for path in written(tmp_path, columns, units, rate_hz)
    ]
    assert len(first.channels) >= 3
    for other in others:
        assert (other.checksum, other.rate_hz) == (first.checksum, first.rate_hz)


def test_a_real_recording_is_the_same_in_every_bag_and_log(shared, tmp_path):
    with np.load(shared / "recordings" / "vn100.npz") as content:
        units = json.loads(content["units"].item())
        rows = np.stack([content[name] for name in AXES], axis=1)[:5000].astype(float)
    rows *= [load_factor(units[name]) for name in AXES]
    stamps = 25_000_000 * np.arange(1, len(rows) + 1)
    np.savez(
        tmp_path / "a.npz",
        **dict(zip(AXES, rows.T, strict=True)),
        rate_hz=40.0,
        units=json.dumps({name: "rad/s" if "g" in name else "m/s^2" for name in AXES}),
    )
    first = load(tmp_path / "a.npz")
    for kind, path in {"bag": "a.bag", "sqlite3": "sqlite", "mcap": "mcap"}.items():
        store = ROS1 if kind == "bag" else ROS2
        messages = [
            ("/imu", int(time), imu(store, int(time), row))
            for time, row in zip(stamps, rows, strict=True)
        ]
        found = load(write_bag(tmp_path / path, kind, messages))
        assert (found.checksum, found.rate_hz) == (first.checksum, 40.0)
    log = [(int(time) // 1000, *row) for time, row in zip(stamps, rows, strict=True)]
    found = load(write_ulog(tmp_path / "a.ulg", {"sensor_combined": (COMBINED, log)}))
    for channel, column in zip(found.channels, rows.T, strict=True):
        np.testing.assert_array_equal(channel.samples, column.astype(np.float32))


def load_factor(unit: str) -> float:
    return {"rad/s": 1.0, "m/s^2": 1.0, "deg/s": np.pi / 180, "g": 9.80665}[unit]


def test_a_list_of_contents(tmp_path, noise):
    columns = {"gyro_x": noise[:, 0], "accel_x": noise[:, 1]}
    units = {"gyro_x": "deg/s", "accel_x": "g"}
    for path in written(tmp_path, columns, units, 50.0):
        (topic,) = contents(path)
        assert (topic.name, topic.kind, topic.samples, topic.units) == ("", "", 400, units)
        assert topic.rate_hz == pytest.approx(50.0)
    with pytest.raises(RecordingError, match="There is no file"):
        contents(tmp_path / "none.bag")


@pytest.mark.parametrize("ending", list(_FORMATS))
def test_every_ending_is_known_in_any_case_and_refused_empty(ending, write):
    path = write(f"empty{ending.upper()}", b"")
    assert is_recording(path)
    with pytest.raises(RecordingError, match=r"is empty\."):
        load(path)


def test_an_ending_that_is_not_known_is_told_all_that_are(write):
    with pytest.raises(RecordingError, match=r"'\.doc' is not known") as error:
        load(write("a.doc", b"text"))
    assert all(f"{ending}, " in str(error.value) for ending in set(_FORMATS) - {".db3", ".ulg"})


@pytest.mark.parametrize(
    ("name", "package"),
    [
        ("a.parquet", "pyarrow"),
        ("a.h5", "h5py"),
        ("a.bag", "rosbags"),
        ("a.mcap", "rosbags"),
        ("a.ulg", "pyulog"),
    ],
)
def test_a_missing_extra_is_named(name, package, write, monkeypatch):
    for loaded in list(sys.modules):
        if loaded.partition(".")[0] == package:
            monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(RecordingError, match=rf"need {package}.*`pip install allanfit\[io\]`"):
        load(write(name, b"some bytes"))
