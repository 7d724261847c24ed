"""`load`: which file, which channels, and what is refused with one clear sentence."""

import dataclasses
import json
import os
import re

import numpy as np
import pytest

import allanfit
from allanfit.recording import RecordingError, load, read_in_blocks


def test_the_result_is_plain_and_frozen(archive, noise):
    recording = load(archive(gyro_x=noise[:, 0]))
    with pytest.raises(dataclasses.FrozenInstanceError):
        recording.rate_hz = 1.0
    assert allanfit.load is load


def test_the_checksum_is_of_the_samples_alone(archive, noise, write):
    one = load(archive(gyro_x=noise[:, 0], units=None), unit="rad/s")
    text = "\n".join(["whatever", *map(str, noise[:, 0])])
    other = load(write("same.csv", text), rate_hz=50.0, unit="rad/s")
    assert len(one.checksum) == 64
    assert one.checksum == other.checksum
    changed = load(archive(gyro_x=noise[:, 1], units=None), unit="rad/s")
    assert changed.checksum != one.checksum


def test_a_channel_is_found_in_another_case_where_it_is_the_only_one(archive, noise):
    path = archive(Gyro_X=noise[:, 0], gyro_y=noise[:, 1], GYRO_Y=noise[:, 2])
    recording = load(path, channels=["gyro_x", "GYRO_X", "GYRO_Y"])
    assert [channel.name for channel in recording.channels] == ["Gyro_X", "GYRO_Y"]
    with pytest.raises(RecordingError, match="no channel Gyro_y; it has Gyro_X, gyro_y, GYRO_Y"):
        load(path, channels=["Gyro_y"])


def test_channels_are_chosen_by_name_in_the_order_asked(archive, noise):
    path = archive(gyro_x=noise[:, 0], gyro_y=noise[:, 1], gyro_z=noise[:, 2])
    recording = load(path, channels=["gyro_z", "gyro_x", "gyro_z"])
    assert [channel.name for channel in recording.channels] == ["gyro_z", "gyro_x"]
    assert len(load(path, channels=[]).channels) == 3
    assert len(load(path, channels="gyro_y").channels) == 1
    with pytest.raises(RecordingError, match="no channel gyro_w; it has gyro_x, gyro_y, gyro_z"):
        load(path, channels=["gyro_w"])


@pytest.mark.parametrize("name", ["temperature", "Temp_1", "imu_temp", "mag_x", "magnetometer_y"])
def test_auxiliary_channels_are_channels_only_when_asked_for(name, archive, noise):
    path = archive(gyro_x=noise[:, 0], **{name: noise[:, 1]}, units=f'{{"{name}": "au"}}')
    usual = load(path, unit="deg/s")
    assert [channel.name for channel in usual.channels] == ["gyro_x"]
    assert [channel.name for channel in usual.auxiliary] == [name]
    asked = load(path, channels=[name])
    assert [channel.name for channel in asked.channels] == [name]
    assert (asked.channels[0].unit, asked.channels[0].kind) == ("au", "other")
    assert asked.auxiliary == ()
    with pytest.raises(RecordingError, match=f"no inertial channel: it holds {name}, which --chan"):
        load(archive(**{name: noise[:, 1]}))


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("pressure", "hPa"),
        ("baro", ""),
        ("p", "mbar"),
        ("humidity", "%"),
        ("rh_1", ""),
        ("battery", "V"),
        ("BatteryVoltage", "mV"),
        ("vbat", ""),
        ("altitude", "m"),
        ("gps.alt", "m"),
        ("light", "lx"),
    ],
)
def test_other_sensors_are_set_aside_and_said(name, unit, archive, noise):
    units = {"gyro_x": "deg/s"} | ({name: unit} if unit else {})
    path = archive(**{name: noise[:, 1] + 900, "gyro_x": noise[:, 0]}, units=json.dumps(units))
    for recording in (load(path), read_in_blocks(path)):
        assert [channel.name for channel in recording.channels] == ["gyro_x"]
        told = f"Not analysed, as of other sensors: {name}; --channel asks for one."
        assert told in recording.findings
    assert [(each.name, each.unit) for each in load(path).auxiliary] == [(name, unit)]
    (asked,) = load(path, channels=[name]).channels
    assert (asked.name, asked.unit, asked.kind) == (name, unit, "other")
    assert load(path, channels=["gyro_x", name]).findings == load(path, channels=[name]).findings


def test_other_sensors_alone_are_the_channels(archive, noise):
    units = '{"battery_voltage": "V", "pressure": "hPa"}'
    path = archive(battery_voltage=noise[:, 0], pressure=noise[:, 1], units=units)
    recording = load(path)
    assert [channel.name for channel in recording.channels] == ["battery_voltage", "pressure"]
    assert not any("other sensors" in each for each in recording.findings)
    assert load(archive(voltage=noise[:, 0]), unit="mV").channels[0].unit == "mV"


@pytest.mark.parametrize(
    ("name", "unit"),
    [("gyro_voltage", "V"), ("acc_alt_x", "g"), ("light", "deg/s"), ("x", "V"), ("salt", "")],
)
def test_inertial_sensors_of_such_names_are_channels(name, unit, archive, noise):
    units = {"gyro_x": "deg/s"} | ({name: unit} if unit else {})
    path = archive(**{name: noise[:, 1], "gyro_x": noise[:, 0]}, units=json.dumps(units))
    assert [channel.name for channel in load(path).channels] == [name, "gyro_x"]


def test_a_name_that_only_begins_alike_is_a_channel(archive, noise):
    recording = load(archive(magnitude=noise[:, 0], units='{"magnitude": "g"}'))
    assert recording.channels[0].name == "magnitude"


@pytest.mark.parametrize(
    ("samples", "reason"),
    [
        (np.ones(400), "it is constant"),
        (np.arange(400.0), "it changes the same way at every sample, as a counter"),
        (np.append(np.zeros(200), np.full(200, np.nan)), "it has 200 usable samples, and at least"),
        (np.full(400, np.nan), "it has 0 usable samples"),
        (np.append(np.zeros(400), 1e300), r"it holds values as large as 1e\+300"),
    ],
)
def test_useless_channels(samples, reason, archive, noise):
    path = archive(gyro_x=np.resize(noise[:, 0], samples.size), gyro_y=samples)
    recording = load(path)
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    (finding,) = recording.findings
    assert re.match(f"The channel gyro_y is left out: {reason}", finding)
    with pytest.raises(RecordingError, match=f"channel gyro_y cannot be analysed: {reason}"):
        load(path, channels=["gyro_x", "gyro_y"])
    with pytest.raises(RecordingError, match=f"channel gyro_y cannot be analysed: {reason}"):
        load(archive(gyro_y=samples))
    with pytest.raises(RecordingError, match=f"has no channel to analyse. .* {reason}"):
        load(archive(gyro_y=samples, gyro_z=samples))


def test_too_short_says_how_many_are_needed(archive, noise):
    assert load(archive(gyro_x=noise[:256, 0])).channels
    with pytest.raises(RecordingError, match="255 usable samples, and at least 256 are needed"):
        load(archive(gyro_x=noise[:255, 0]))


def test_too_few_samples_are_no_fault_of_the_time_stamps(write):
    path = write("few.csv", "time,x\n" + "".join(f"{k / 100},{k % 3}\n" for k in range(9)))
    with pytest.raises(RecordingError, match=r"few\.csv cannot .* has 9 samples, and at least 256"):
        load(path)


@pytest.mark.parametrize("rate_hz", [0.0, -100.0, float("nan"), float("inf")])
def test_a_rate_is_positive(rate_hz, archive, noise):
    with pytest.raises(RecordingError, match=r"from 1e-06 to 1e\+09; the rate given is"):
        load(archive(gyro_x=noise[:, 0]), rate_hz=rate_hz)


def test_without_any_rate(archive, noise):
    with pytest.raises(RecordingError, match=r"tells no sampling rate, .* give it with --rate"):
        load(archive(gyro_x=noise[:, 0], rate_hz=None))


def test_the_rate_given_comes_first(archive, noise):
    assert load(archive(gyro_x=noise[:, 0]), rate_hz=250.0).rate_hz == 250.0


@pytest.mark.parametrize("name", ["recording.xml", "recording", "recording.npz.gz", "a.jpg"])
def test_unknown_endings(name, write):
    with pytest.raises(RecordingError, match=r"is not known; a recording is a \.csv, \.csv\.gz"):
        load(write(name, "1\n2\n"))


@pytest.mark.parametrize("ending", ["xlsx", "XLS", "ods"])
def test_a_spreadsheet_is_to_be_exported(ending, write):
    with pytest.raises(RecordingError, match=r"is a spreadsheet: export .* as CSV"):
        load(write(f"recording.{ending}", b"PK"))


def test_missing_files_folders_and_empty_files(tmp_path, write):
    with pytest.raises(RecordingError, match=r"There is no file .*none\.csv"):
        load(tmp_path / "none.csv")
    with pytest.raises(RecordingError, match="is a folder: give the file"):
        load(tmp_path)
    for name in ("empty.csv", "empty.npz", "empty.npy"):
        with pytest.raises(RecordingError, match=rf"{name} is empty"):
            load(write(name, b""))


def test_an_unreadable_file(write, monkeypatch):
    path = write("secret.csv", "1\n2\n")

    def refuse(*_):
        raise PermissionError(13, os.strerror(13))

    # The rights themselves would not stop a test run by root.
    monkeypatch.setattr("pathlib.Path.open", refuse)
    with pytest.raises(RecordingError, match=r"secret\.csv cannot be read: Permission denied"):
        load(path)
