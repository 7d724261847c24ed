"""Recordings of real sensors, whose flaws are known; skipped where they are not at hand."""

from pathlib import Path

import numpy as np
import pytest

from allanfit.recording import load

SHARED = Path(__file__).parents[2].parent / "shared"

pytestmark = pytest.mark.skipif(
    not (SHARED / "recordings").is_dir(), reason="the recordings may not be copied into the project"
)


def read(name: str, **options):
    return load(SHARED / "recordings" / name, **options)


def about(recording, kind: str) -> list[str]:
    return [
        finding
        for channel in recording.channels
        if channel.kind == kind
        for finding in channel.findings
    ]


@pytest.mark.parametrize("run", ["adis16405_a.npz", "adis16405_b.npz"])
def test_accelerometer_noise_one_code_wide(run):
    recording = read(run)
    assert about(recording, "gyro") == []
    told = about(recording, "accelerometer")
    assert len(told) == 3
    assert all("The code width, 0.00333 g, is as large as the noise" in line for line in told)


def test_a_phone_with_a_gap_and_repeated_stamps():
    recording = read("phone_accelerometer.npz")
    assert recording.channels[0].stretches == ((0, 1582), (1582, 40159))
    gap, uneven = recording.findings
    assert "a gap of 295 s at 316 s" in gap
    assert "80 % repeat the one before" in uneven
    assert "98 % of the samples repeat the one before" in recording.channels[0].findings[0]
    gyro = read("phone_gyro.npz")
    assert gyro.channels[0].stretches == ((0, 37904),)
    assert all("as large as the noise" in line for line in about(gyro, "gyro"))


@pytest.mark.parametrize("name", ["vn100.npz", "mpu6050.npz"])
def test_bursts_and_jitter_are_no_gaps(name):
    recording = read(name)
    (finding,) = recording.findings
    assert finding.startswith("The time stamps are uneven")
    assert about(recording, "gyro") == about(recording, "accelerometer") == []
    assert len(recording.channels[0].stretches) == 1


def test_an_accelerometer_polled_faster_than_it_converts():
    recording = read("bmi270.npz")
    assert recording.findings == ()
    assert about(recording, "gyro") == []
    told = about(recording, "accelerometer")
    assert told[0].startswith("63 % of the samples repeat the one before")
    assert len(told) == 3
    assert recording.auxiliary[0].name == "temperature"


@pytest.mark.parametrize(
    ("name", "rate_hz"),
    [
        ("gyro_warmup.csv", 95.2),
        ("memsense_11_power_cycles.npz", None),
        ("xsens_dot_10_units.npz", None),
        ("xsens_tstick.npz", None),
        ("seismometer.npz", None),
        ("clock_ocxo.npz", None),
        ("clock_gps1pps.npz", None),
    ],
)
def test_recordings_without_a_flaw_of_this_kind_are_silent(name, rate_hz):
    recording = read(name, rate_hz=rate_hz)
    assert recording.findings == ()
    assert [line for channel in recording.channels for line in channel.findings] == []
    assert all(np.isfinite(channel.samples).all() for channel in recording.channels)


def test_spikes_of_a_real_sensor_are_told_and_nothing_else():
    recording = read("xsens_mtig_outliers.npz")
    told = [line for channel in recording.channels for line in channel.findings]
    assert told
    assert all("stand alone, more than 8 standard deviations" in line for line in told)
