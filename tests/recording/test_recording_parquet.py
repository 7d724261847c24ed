"""Parquet, written by polars and pyarrow."""

import datetime

import numpy as np
import polars as pl
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest

from allanfit.recording import RecordingError, contents, load


def test_polars_with_units_in_brackets(tmp_path, noise):
    path = tmp_path / "a.parquet"
    columns = {"gyro_x [deg/s]": noise[:, 0], "accel_x (g)": noise[:, 1].astype(np.float32)}
    pl.DataFrame({"time_s": np.arange(400) / 50} | columns).write_parquet(path)
    recording = load(path)
    assert (recording.rate_hz, recording.findings) == (50.0, ())
    gyro, accel = recording.channels
    assert (gyro.name, gyro.unit, accel.name, accel.unit) == ("gyro_x", "deg/s", "accel_x", "g")
    np.testing.assert_array_equal(
        gyro.samples / gyro.factor, noise[:, 0] * gyro.factor / gyro.factor
    )
    (topic,) = contents(path)
    assert (topic.samples, topic.rate_hz, topic.units) == (
        400,
        50.0,
        {"gyro_x": "deg/s", "accel_x": "g"},
    )


def test_units_and_rate_in_metadata(tmp_path, noise):
    fields = [
        arrow.field("gyro_x", arrow.float64(), metadata={"units": "deg/s"}),
        arrow.field("gyro_y", arrow.int32()),
    ]
    metadata = {"rate_hz": "200", "units": '{"gyro_y": "mdps"}'}
    table = arrow.table(
        [noise[:, 0], (100 * noise[:, 1]).astype(np.int32)],
        schema=arrow.schema(fields, metadata=metadata),
    )
    parquet.write_table(table, tmp_path / "a.parquet", compression="zstd")
    recording = load(tmp_path / "a.parquet")
    assert recording.rate_hz == 200.0
    assert [channel.unit for channel in recording.channels] == ["deg/s", "mdps"]
    for text, rate in (("100 Hz", 100.0), ("fast", 50.0)):
        again = table.replace_schema_metadata({"rate_hz": text})
        parquet.write_table(again, tmp_path / "b.parquet")
        found = load(tmp_path / "b.parquet", rate_hz=None if text == "100 Hz" else 50.0)
        assert found.rate_hz == rate
        assert any("'fast'" in each for each in found.findings) == (text == "fast")


def test_dates_are_time_stamps_and_nulls_are_missing(tmp_path, noise):
    start = datetime.datetime(2026, 1, 1)
    when = [start + datetime.timedelta(milliseconds=5 * k) for k in range(400)]
    values = [None if k == 100 else float(v) for k, v in enumerate(noise[:, 0])]
    frame = pl.DataFrame({"date": when, "gyro_x": values, "note": ["x"] * 400})
    frame.write_parquet(tmp_path / "a.parquet")
    recording = load(tmp_path / "a.parquet", unit="rad/s")
    assert recording.rate_hz == pytest.approx(200.0)
    assert recording.channels[0].stretches == ((0, 100), (101, 400))
    assert "The column note holds" in recording.findings[0]


def test_refusals(tmp_path, noise, write):
    path = tmp_path / "a.parquet"
    pl.DataFrame({"x [deg/s]": noise[:, 0], "x [g]": noise[:, 1]}).write_parquet(path)
    with pytest.raises(RecordingError, match="two columns named x: rename one"):
        load(path)
    pl.DataFrame({"x": ["a"] * 400}).write_parquet(path)
    with pytest.raises(RecordingError, match="holds no column of numbers"):
        load(path)
    pl.DataFrame({"x": noise[:, 0]}).write_parquet(path)
    with pytest.raises(RecordingError, match=r"one table without topics: leave --topic out"):
        load(path, topic="imu")
    whole = path.read_bytes()
    for name, data in {
        "cut.parquet": whole[:-9],
        "half.parquet": whole[:900],
        "t.parquet": b"x,y",
    }.items():
        with pytest.raises(RecordingError, match=rf"{name} is not a Parquet file that can be read"):
            load(write(name, data), rate_hz=1.0)


def test_a_table_beyond_memory(tmp_path, noise, monkeypatch):
    pl.DataFrame({"x": noise[:, 0]}).write_parquet(tmp_path / "a.parquet")
    monkeypatch.setattr("os.sysconf", lambda name: 30)
    with pytest.raises(RecordingError, match=r"needs more memory than this machine has"):
        load(tmp_path / "a.parquet", rate_hz=1.0)
