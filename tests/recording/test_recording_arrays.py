"""Recordings of arrays, which are read as those of files are."""

from inspect import unwrap

import numpy as np
import polars as pl
import pytest

from allanfit.recording import RecordingError, load, recording_of


def test_columns_are_read_as_those_of_a_file(tmp_path, noise):
    columns = {"time": np.arange(400) / 50, "gyro_x": noise[:, 0], "temperature_degC": noise[:, 1]}
    np.savez(tmp_path / "a.npz", units='{"gyro_x": "deg/s"}', **columns)
    file = load(tmp_path / "a.npz")
    for data in (columns, pl.DataFrame(columns)):
        made = recording_of(data, units={"gyro_x": "deg/s"})
        assert (made.rate_hz, made.findings) == (file.rate_hz, file.findings)
        assert made.checksum == file.checksum
        assert [each.name for each in made.auxiliary] == ["temperature_degC"]
    assert recording_of(columns, unit="deg/s").checksum == file.checksum


def test_arrays_have_the_shapes_that_curves_take(noise):
    assert [each.name for each in recording_of(noise[:, 0], rate_hz=10.0).channels] == ["data"]
    several = recording_of(noise.T, rate_hz=10.0)
    assert [each.name for each in several.channels] == ["channel_1", "channel_2", "channel_3"]
    np.testing.assert_array_equal(several.channels[1].samples, noise[:, 1])


def test_dates_are_time_stamps(noise):
    when = np.datetime64("2026-01-01") + np.arange(400) * np.timedelta64(5, "ms")
    made = recording_of({"time": when, "gyro_x": noise[:, 0]}, unit="deg/s")
    assert made.rate_hz == pytest.approx(200)


@pytest.mark.parametrize(
    ("data", "options", "message"),
    [
        (np.zeros((400, 3)), {}, r"or \(channels, samples\); got one of shape \(400, 3\)"),
        ({"a": ["x", "y"]}, {}, "The column a must be a series of real numbers"),
        ({"a": np.zeros(400)}, {"units": {"b": "g"}}, "units names 'b', and the columns are a"),
        ({"a": np.zeros(400), "b": np.zeros(399)}, {}, "but a has 400 and b has 399"),
        (np.zeros(400), {}, "cannot be analysed"),
    ],
)
def test_what_is_no_recording_is_refused(data, options, message):
    with pytest.raises(RecordingError, match=message):
        recording_of(data, rate_hz=10.0, **options)


def test_one_unit_for_all_is_not_units():
    # Past the check of types that only tests have.
    with pytest.raises(RecordingError, match="one for all is unit='deg/s'"):
        unwrap(recording_of)({"a": np.zeros(400)}, rate_hz=10.0, units="deg/s")
