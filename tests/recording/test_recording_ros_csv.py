"""Messages of ROS as text: `rostopic echo -p`, and stamps in two columns."""

import numpy as np
import pytest

from allanfit.recording import load, read_in_blocks

SAMPLES = 600
START_NS = 1_700_000_000_000_000_000
STAMPS = START_NS + 10_000_000 * np.arange(SAMPLES)
AXES = "xyz"


@pytest.fixture(scope="module")
def rates() -> np.ndarray:
    return 1e-3 * np.random.default_rng(3).standard_normal((SAMPLES, 3))


@pytest.fixture
def echoed(tmp_path, rates):
    """A table with its header behind %, which arrived unevenly, with a text among the columns."""
    names = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    names += [f"field.orientation.{axis}" for axis in "xyzw"]
    names += [f"field.angular_velocity.{axis}" for axis in AXES]
    names += [f"field.angular_velocity_covariance{k}" for k in range(9)]
    late = np.random.default_rng(4).integers(0, 8_000_000, SAMPLES)
    lines = [
        f"{stamp + wait},{k},{stamp},imu,0.1,0.2,0.3,{0.9 + 1e-4 * row[0]},"
        + ",".join(map(repr, map(float, row)))
        + 9 * ",0.0"
        for k, (stamp, wait, row) in enumerate(zip(STAMPS, late, rates, strict=True))
    ]
    path = tmp_path / "echoed.csv"
    path.write_text("\n".join([",".join(names), *lines]))
    return path


def test_it_is_read_by_the_stamps_of_the_messages(echoed, rates):
    recording = load(echoed)
    assert recording.rate_hz == pytest.approx(100, rel=1e-9)
    assert [(each.name, each.unit, each.kind) for each in recording.channels] == [
        (f"field.angular_velocity.{axis}", "rad/s", "gyro") for axis in AXES
    ]
    assert np.array_equal(np.stack([each.samples for each in recording.channels], axis=1), rates)
    # One sentence for all that are constant, and none on intervals that are uneven.
    assert sum("is constant" in finding for finding in recording.findings) == 1
    assert not any("uneven" in finding for finding in recording.findings)


@pytest.mark.parametrize(
    "names", ["sec,nanosec", "secs,nsecs", "header.stamp.sec,header.stamp.nanosec"]
)
def test_two_columns_are_one_stamp(tmp_path, rates, names):
    path = tmp_path / "two.csv"
    rows = [
        f"{stamp // 10**9},{stamp % 10**9},{float(row[0])!r}"
        for stamp, row in zip(STAMPS, rates, strict=True)
    ]
    path.write_text("\n".join([f"{names},gyro_x [rad/s]", *rows]))
    recording = load(path)
    assert recording.rate_hz == pytest.approx(100, rel=1e-9)
    assert [each.name for each in recording.channels] == ["gyro_x"]
    assert not recording.findings
    (run, *_) = read_in_blocks(path, block_samples=1024)
    assert run.samples.size == SAMPLES


def test_seconds_beside_what_is_no_part_of_them_stay(tmp_path, rates):
    """Nanoseconds beyond a second are none of whole seconds."""
    path = tmp_path / "two.csv"
    rows = [f"{k / 100},{2_000_000_000 + k},{float(row[0])!r}" for k, row in enumerate(rates)]
    path.write_text("\n".join(["sec,nsec,gyro_x [rad/s]", *rows]))
    recording = load(path, rate_hz=100.0)
    assert [each.name for each in recording.channels] == ["gyro_x"]
    assert recording.rate_hz == 100.0
