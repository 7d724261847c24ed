"""Recordings of ROS 1 and ROS 2, written by rosbags: samples, topics, times and refusals."""

import struct
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from recording_files import (
    ROS1,
    ROS2,
    SECOND,
    imu,
    magnetic,
    temperature,
    write_bag,
)
from rosbags.rosbag2 import StoragePlugin, Writer, storage_mcap

from allanfit.recording import RecordingError, contents, is_recording, load

START = 1_700_000_000 * SECOND
STEP = SECOND // 100
AXES = [f"{name}_{axis}" for name in ("gyro", "accel") for axis in "xyz"]
KINDS = ("bag", "sqlite3", "mcap")
EXTENSION = {"bag": "still.bag", "sqlite3": "still", "mcap": "still"}


@pytest.fixture
def rows() -> np.ndarray:
    """Gyros and accelerometers at rest."""
    noise = 0.01 * np.random.default_rng(3).standard_normal((400, 6))
    return noise + np.array([0, 0, 0, 0, 0, 9.81])


def of_imu(kind, rows, topic="/imu/data", frame="imu_link", stamps=None):
    store = ROS1 if kind == "bag" else ROS2
    times = START + STEP * np.arange(len(rows))
    stamps = times if stamps is None else stamps
    return [
        (topic, int(time) + 1, imu(store, int(stamp), row, frame))
        for time, stamp, row in zip(times, stamps, rows, strict=True)
    ]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("frame", ["", "imu", "imu_link"])
def test_an_imu_as_its_messages_say(kind, frame, rows, tmp_path):
    path = write_bag(tmp_path / EXTENSION[kind], kind, of_imu(kind, rows, frame=frame))
    recording = load(path)
    assert recording.rate_hz == pytest.approx(100.0, rel=1e-9)
    assert recording.findings == ()
    assert [channel.name for channel in recording.channels] == AXES
    assert [channel.unit for channel in recording.channels] == 3 * ["rad/s"] + 3 * ["m/s^2"]
    for channel, column in zip(recording.channels, rows.T, strict=True):
        np.testing.assert_array_equal(channel.samples, column)


@pytest.mark.parametrize("name", ["still.db3", "still.mcap"])
def test_the_file_in_the_folder_will_do(name, rows, tmp_path):
    kind = "mcap" if name.endswith("mcap") else "sqlite3"
    whole = load(write_bag(tmp_path / "still", kind, of_imu(kind, rows)))
    assert load(tmp_path / "still" / name).checksum == whole.checksum


@pytest.mark.parametrize("kind", KINDS)
def test_frames_of_several_lengths_and_many_blocks(kind, rows, tmp_path, monkeypatch):
    monkeypatch.setattr("allanfit.recording._ros._BLOCK", 150)
    messages = of_imu(kind, rows[:200], frame="a") + of_imu(kind, rows, frame="longer_name")[200:]
    told = []
    path = write_bag(tmp_path / EXTENSION[kind], kind, messages)
    recording = load(path, progress=lambda read, total: told.append((read, total)))
    np.testing.assert_array_equal(recording.channels[5].samples, rows[:, 5])
    assert told == [(150, 400), (300, 400)]


@pytest.mark.parametrize("kind", KINDS)
def test_temperature_and_magnetometer_beside_it(kind, rows, tmp_path):
    store = ROS1 if kind == "bag" else ROS2
    messages = of_imu(kind, rows)
    # Ten times more rarely, each just before a sample of the IMU.
    for k in range(0, 400, 10):
        time = START + STEP * k - 1000
        messages.append(("/imu/temperature", time, temperature(store, time, 20 + k / 100)))
        messages.append(("/imu/mag", time, magnetic(store, time, (k, 2.0, 3.0))))
    messages.sort(key=lambda message: message[1])
    recording = load(write_bag(tmp_path / EXTENSION[kind], kind, messages))
    warm, mag_x, _, mag_z = recording.auxiliary
    assert (warm.name, warm.unit, mag_x.unit) == ("temperature", "degC", "T")
    np.testing.assert_array_equal(warm.samples, np.repeat(20 + np.arange(0, 400, 10) / 100, 10))
    np.testing.assert_array_equal(mag_x.samples, np.repeat(np.arange(0.0, 400, 10), 10))
    assert set(mag_z.samples) == {3.0}
    named = {topic.name: topic for topic in contents(tmp_path / EXTENSION[kind])}
    assert (named["/imu/mag"].kind, named["/imu/mag"].samples) == (
        "sensor_msgs/msg/MagneticField",
        40,
    )
    assert named["/imu/data"].rate_hz == pytest.approx(100.0, rel=0.01)
    assert list(named["/imu/data"].units) == AXES


@pytest.mark.parametrize("kind", KINDS)
def test_which_of_two_imus(kind, rows, tmp_path):
    messages = of_imu(kind, rows, "/imu0") + of_imu(kind, rows + 1, "/imu1")
    path = write_bag(tmp_path / EXTENSION[kind], kind, messages)
    with pytest.raises(RecordingError, match=r"holds 2 topics, choose one with --topic: /imu0 \("):
        load(path)
    np.testing.assert_array_equal(load(path, topic="imu1").channels[0].samples, rows[:, 0] + 1)
    with pytest.raises(RecordingError, match=r"no topic /imu2; it has /imu0 \(sensor_msgs/msg/Imu"):
        load(path, topic="/imu2")


def test_no_imu(tmp_path):
    text = ROS2.types["std_msgs/msg/String"]
    path = write_bag(tmp_path / "talk", "mcap", [("/chat", START, text("hello"))])
    with pytest.raises(RecordingError, match=r"no messages of sensor_msgs/Imu: it has /chat \(std"):
        load(path)
    with pytest.raises(RecordingError, match="/chat holds std_msgs/msg/String, which is not read"):
        load(path, topic="/chat")
    (topic,) = contents(path)
    assert (topic.samples, topic.units) == (1, {})


def test_an_imu_without_messages(tmp_path):
    for kind in ("bag", "mcap"):
        path = write_bag(tmp_path / EXTENSION[kind], kind, [])
        with pytest.raises(RecordingError, match=r"it has no topics|can be read"):
            load(path)


@pytest.mark.parametrize("kind", KINDS)
def test_headers_without_stamps(kind, rows, tmp_path):
    messages = of_imu(kind, rows, stamps=np.zeros(400, int))
    recording = load(write_bag(tmp_path / EXTENSION[kind], kind, messages))
    assert recording.rate_hz == pytest.approx(100.0)
    assert recording.findings == (
        "The headers carry no time stamps, so the times at which the messages were recorded are "
        "used.",
    )


def test_messages_out_of_order_are_put_in_order(rows, tmp_path):
    order = np.arange(400)
    order[[100, 101, 102]] = [102, 100, 101]
    stamps = START + STEP * order
    messages = of_imu("mcap", rows[order], stamps=stamps)
    recording = load(write_bag(tmp_path / "late", "mcap", messages))
    np.testing.assert_array_equal(recording.channels[0].samples, rows[:, 0])
    assert recording.findings == (
        "Messages that came after later ones: 1 time; they are put in the order of their time "
        "stamps.",
    )


def test_threads_leave_everything_as_it_was(rows, tmp_path, monkeypatch):
    """One begins while the other reads, and would end after it."""
    monkeypatch.setattr("allanfit.recording._ros._BLOCK", 150)
    path = write_bag(tmp_path / "still", "mcap", of_imu("mcap", rows))
    before = dict(storage_mcap.DECOMPRESSORS), sys.stdout, list(warnings.filters)
    inside, left, others = threading.Event(), threading.Event(), []

    def while_other_reads(read, total):
        inside.set()
        left.wait(5)

    def while_one_reads(read, total):
        if not others:
            others.append(pool.submit(load, path, progress=while_other_reads))
            inside.wait(0.5)

    with ThreadPoolExecutor(1) as pool:
        one = load(path, progress=while_one_reads)
        left.set()
        assert others[0].result(60).checksum == one.checksum
    assert (dict(storage_mcap.DECOMPRESSORS), sys.stdout, list(warnings.filters)) == before


def test_a_clock_set_back_is_no_disorder(tmp_path):
    rows = np.random.default_rng(4).standard_normal((3000, 6))
    stamps = START + STEP * np.arange(3000)
    stamps[1500:] -= 1400 * STEP
    recording = load(write_bag(tmp_path / "set", "sqlite3", of_imu("sqlite3", rows, stamps=stamps)))
    np.testing.assert_array_equal(recording.channels[0].samples, rows[:, 0])
    assert recording.channels[0].stretches == ((0, 1500), (1500, 3000))


def test_values_that_are_not_finite(rows, tmp_path):
    rows[50, 1] = np.nan
    recording = load(write_bag(tmp_path / "nan", "mcap", of_imu("mcap", rows)))
    assert recording.channels[1].stretches == ((0, 50), (51, 400))
    assert recording.channels[0].stretches == ((0, 400),)


def test_big_endian_messages(rows, tmp_path):
    """As a computer of the other byte order writes them, built here from the standard."""
    path = tmp_path / "big"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=ROS2)
        for k, row in enumerate(rows):
            time = START + STEP * k
            numbers = [9.0] * 13 + [*row[:3]] + [9.0] * 9 + [*row[3:]] + [9.0] * 9
            message = struct.pack(
                ">BBHiII3sx37d", 0, 0, 0, *divmod(time, SECOND), 3, b"ab", *numbers
            )
            writer.write(connection, time, message)
    recording = load(path)
    np.testing.assert_array_equal(recording.channels[3].samples, rows[:, 3])
    assert recording.rate_hz == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda raw: raw[:-8], "a message of 316 bytes is not of the type"),
        (lambda raw: raw[:20], "a message of 20 bytes is not of the type"),
        (lambda raw: b"", "not in plain CDR"),
        (lambda raw: b"\0\3" + raw[2:], "not in plain CDR"),
        (lambda raw: raw[:12] + b"\xff\xff\xff\xff" + raw[16:], "324 bytes is not of the type"),
    ],
)
def test_messages_that_are_not_what_they_say(change, message, rows, tmp_path):
    with Writer(tmp_path / "odd", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=ROS2)
        for _, time, each in of_imu("sqlite3", rows):
            raw = bytes(ROS2.serialize_cdr(each, "sensor_msgs/msg/Imu"))
            writer.write(connection, time, change(raw))
    with pytest.raises(RecordingError, match=rf"odd, topic /imu: .*{message}.*\.$"):
        load(tmp_path / "odd")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("keep", [0, 8, 100, 5000, -1000])
def test_files_cut_off(kind, keep, rows, tmp_path):
    path = write_bag(tmp_path / EXTENSION[kind], kind, of_imu(kind, rows))
    ending = {"bag": None, "sqlite3": "still.db3", "mcap": "still.mcap"}[kind]
    file = path / ending if ending else path
    file.write_bytes(file.read_bytes()[:keep])
    with pytest.raises(RecordingError) as error:
        load(file)
    assert str(error.value).endswith(".")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["noise.bag", "noise.mcap", "noise.db3"])
def test_files_of_another_kind(name, write):
    noise = np.random.default_rng(5).bytes(10_000)
    with pytest.raises(RecordingError, match=rf"{name} is not a recording of ROS that can be read"):
        load(write(name, noise))


def test_a_folder_with_metadata_of_something_else_is_no_bag(tmp_path):
    (tmp_path / "metadata.yaml").write_text("title: my recordings\n")
    assert not is_recording(tmp_path)
    with pytest.raises(RecordingError, match="is a folder"):
        load(tmp_path)
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: [1, 2]\n")
    assert is_recording(tmp_path)
    with pytest.raises(RecordingError, match="is not a recording of ROS that can be read"):
        load(tmp_path)
