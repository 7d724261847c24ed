"""PX4 logs, written byte by byte as the format is published."""

import numpy as np
import pytest
from recording_files import write_ulog

from allanfit.recording import RecordingError, contents, load

COMBINED = (
    "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
    "float[3] accelerometer_m_s2;uint8_t clipping;"
)
RAW = "uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z;float temperature;"
INTEGRALS = (
    "uint64_t timestamp;uint64_t timestamp_sample;float[3] delta_angle;float[3] delta_velocity;"
    "uint32_t delta_angle_dt;uint32_t delta_velocity_dt;"
)
FIFO = (
    "uint64_t timestamp;uint64_t timestamp_sample;float dt;float scale;uint8_t samples;"
    "int16_t[4] x;int16_t[4] y;int16_t[4] z;"
)
AXES = [f"{name}_{axis}" for name in ("gyro", "accel") for axis in "xyz"]


@pytest.fixture
def rows() -> np.ndarray:
    """Gyros and accelerometers at rest."""
    noise = 0.01 * np.random.default_rng(6).standard_normal((400, 6))
    return (noise + np.array([0, 0, 0, 0, 0, 9.81])).astype(np.float32).astype(float)


def combined(rows):
    return [(1000 + 4000 * k, *row[:3], 4000, *row[3:], 0) for k, row in enumerate(rows)]


def raw(rows):
    return [
        (1000 + 4000 * k + (k * 7919) % 900, 1000 + 4000 * k, *row[:3], 31.5)
        for k, row in enumerate(rows)
    ]


def test_sensor_combined(rows, tmp_path):
    path = write_ulog(tmp_path / "log.ulg", {"sensor_combined": (COMBINED, combined(rows))})
    recording = load(path)
    assert recording.rate_hz == pytest.approx(250.0)
    assert recording.findings == ()
    assert [channel.name for channel in recording.channels] == AXES
    assert [channel.unit for channel in recording.channels] == 3 * ["rad/s"] + 3 * ["m/s^2"]
    for channel, column in zip(recording.channels, rows.T, strict=True):
        np.testing.assert_array_equal(channel.samples, column)


def test_a_raw_sensor_is_timed_by_its_own_stamps(rows, tmp_path):
    rows = rows[:, 3:]
    path = write_ulog(tmp_path / "log.ulg", {"sensor_accel": (RAW, raw(rows))})
    recording = load(path)
    assert (recording.rate_hz, recording.findings) == (250.0, ())
    assert [channel.name for channel in recording.channels] == AXES[3:]
    np.testing.assert_array_equal(recording.channels[1].samples, rows[:, 1])
    (warm,) = recording.auxiliary
    assert set(warm.samples) == {31.5}


def test_increments_become_rates(rows, tmp_path):
    log = [(0, 1000 + 5000 * k, *row, 5000, 2500) for k, row in enumerate(rows)]
    recording = load(write_ulog(tmp_path / "log.ulg", {"vehicle_imu": (INTEGRALS, log)}))
    assert recording.rate_hz == pytest.approx(200.0)
    np.testing.assert_allclose(recording.channels[0].samples, rows[:, 0] / 0.005, rtol=1e-12)
    np.testing.assert_allclose(recording.channels[5].samples, rows[:, 5] / 0.0025, rtol=1e-12)


def test_raw_samples_by_the_handful(tmp_path):
    """Three samples in each message, 1 ms apart, and a fourth place that holds none."""
    codes = np.random.default_rng(7).integers(-900, 900, (150, 3, 3))
    log = [
        (9, 10_000 + 3000 * k, 1000.0, 2**-14, 3, *(v for axis in some.T for v in (*axis, 12345)))
        for k, some in enumerate(codes)
    ]
    path = write_ulog(tmp_path / "log.ulg", {"sensor_gyro_fifo": (FIFO, log)})
    recording = load(path)
    assert (recording.rate_hz, recording.findings) == (1000.0, ())
    for axis, channel in enumerate(recording.channels):
        np.testing.assert_array_equal(channel.samples, 2**-14 * codes[:, :, axis].ravel())
    assert contents(path)[0].samples == 450


def test_which_topic(rows, tmp_path):
    both = {"sensor_gyro/0": (RAW, raw(rows)), "sensor_gyro/1": (RAW, raw(rows + 1))}
    path = write_ulog(tmp_path / "log.ulg", both)
    with pytest.raises(
        RecordingError, match=r"2 topics, choose one with --topic: sensor_gyro/0 \("
    ):
        load(path)
    second = load(path, topic="sensor_gyro/1").channels[0]
    np.testing.assert_array_equal(second.samples, (rows[:, 0] + 1).astype(np.float32))
    first = load(path, topic="sensor_gyro").channels[0]
    np.testing.assert_array_equal(first.samples, rows[:, 0])
    with pytest.raises(RecordingError, match=r"no topic vehicle_imu/0; it has sensor_gyro/0 \("):
        load(path, topic="vehicle_imu")
    path = write_ulog(path, {"sensor_combined": (COMBINED, combined(rows))} | both)
    recording = load(path)
    assert recording.channels[3].name == "accel_x"
    assert recording.findings == (
        "Read from sensor_combined, the means that the autopilot uses; sensor_gyro/0, "
        "sensor_gyro/1 can be had with --topic.",
    )
    assert [(topic.name, round(topic.rate_hz)) for topic in contents(path)] == [
        ("sensor_combined/0", 251),
        ("sensor_gyro/0", 251),
        ("sensor_gyro/1", 251),
    ]


def test_logs_without_a_sensor(tmp_path):
    path = write_ulog(
        tmp_path / "log.ulg", {"battery": ("uint64_t timestamp;float v;", [(1, 2.0)])}
    )
    with pytest.raises(RecordingError, match=r"log\.ulg holds no messages of sensor_combined, veh"):
        load(path)
    assert contents(path) == ()


def test_a_log_cut_off_has_what_was_written(rows, tmp_path):
    topics = {"sensor_combined": (COMBINED, combined(rows))}
    path = write_ulog(tmp_path / "log.ulg", topics, cut=20)
    assert load(path).channels[0].samples.size == 399


def test_damage(rows, tmp_path, write, capfd):
    for name, data in {
        "text.ulg": b"gyro\n1\n",
        "short.ulg": b"ULog\x01\x12\x35",
        "a.ulg": b"\0",
    }.items():
        with pytest.raises(RecordingError, match=rf"{name} is not an ULog file that can be read"):
            load(write(name, data))
    path = write_ulog(tmp_path / "log.ulg", {"sensor_combined": (COMBINED, combined(rows))})
    content = bytearray(path.read_bytes())
    # The length of a message in the middle.
    at = content.index(b"D", 15_000) - 2
    content[at] ^= 0xFF
    path.write_bytes(content)
    with_damage = load(path)
    assert "Parts of the log are damaged and were skipped." in with_damage.findings
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ("uint64_t timestamp;sensor_combined inner;", "its type sensor_combined holds itself"),
        ("uint64_t timestamp;float[65535] gyro_rad;", "its type sensor_combined is too large"),
    ],
)
def test_types_made_to_fill_the_memory(fields, message, tmp_path):
    path = tmp_path / "log.ulg"
    data = f"sensor_combined:{fields}".encode()
    record = len(data).to_bytes(2, "little") + b"F" + data
    path.write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8) + record)
    with pytest.raises(RecordingError, match=message):
        load(path)
