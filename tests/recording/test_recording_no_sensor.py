"""Counters, flags and time stamps among the columns, each beside noise that is none of them."""

import numpy as np
import pytest

from allanfit.recording import RecordingError, load, read_in_blocks
from allanfit.recording._no_sensor import why_counter, why_flag

SIZE = 20_000
RNG = np.random.default_rng(11)
NOISE = RNG.standard_normal(SIZE)
INDEX = np.arange(SIZE, dtype=float)
COUNTERS = {
    **{f"of {length}": INDEX % length for length in (2, 3, 8, 16, 256, 1000, 15_000)},
    "down": -(INDEX % 256),
    "in tens": 7 + 10 * (INDEX % 256),
    "losing messages": (INDEX + np.cumsum(RNG.random(SIZE) < 0.2)) % 256,
    "held": np.repeat(INDEX % 16, 3)[:SIZE],
    "held and never back": INDEX // 5,
    "damaged": np.where(RNG.random(SIZE) < 0.02, 0.0, INDEX % 16),
    "an angle": (0.7 * INDEX + 0.1 * NOISE) % 360,
}
PRESSED = (INDEX > 9000).astype(float)
PULSES = (INDEX % 100 == 0).astype(float)


def table(path, **columns):
    """A CSV file of noise in deg/s and other columns."""
    columns = {"time [s]": INDEX / 100, "gyro_x [deg/s]": NOISE.round(4), **columns}
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, rows, "%.6g", ",", header=",".join(columns), comments="")
    return path


@pytest.mark.parametrize("kind", COUNTERS)
def test_a_counter_is_left_out_and_said_once(kind, tmp_path):
    path = table(tmp_path / "a.csv", seq=COUNTERS[kind])
    for recording in (load(path), read_in_blocks(path, block_samples=8192)):
        assert [channel.name for channel in recording.channels] == ["gyro_x"]
        (finding,) = recording.findings
        assert finding.startswith("The channel seq is left out: it changes ")
        assert "as a counter or time stamps do" in finding
    with pytest.raises(RecordingError, match="seq cannot be analysed: it changes"):
        load(path, channels=["seq"])


@pytest.mark.parametrize("flag", [PRESSED, PULSES, 3 * PRESSED + PULSES])
def test_a_flag_is_left_out_unless_asked_for(flag, tmp_path):
    path = table(tmp_path / "a.csv", button=flag)
    for recording in (load(path), read_in_blocks(path, block_samples=16_384)):
        assert [channel.name for channel in recording.channels] == ["gyro_x"]
        (finding,) = recording.findings
        assert finding.startswith("The channel button is left out: it has ")
        assert "as a button or a flag does" in finding
    if flag is not PRESSED:
        assert load(path, channels=["button"]).channels[0].name == "button"


@pytest.mark.parametrize("name", ["gyro_y", "button [deg/s]", "accX"])
def test_what_is_said_to_be_a_sensor_is_no_flag(name, tmp_path):
    recording = load(table(tmp_path / "a.csv", **{name: PULSES}))
    assert len(recording.channels) == 2


@pytest.mark.parametrize("width", [1e-9, 0.1, 0.5, 1.0, 2.0, 3.0, 4.4])
def test_noise_is_neither(width):
    for seed in range(20):
        x = np.random.default_rng(seed).standard_normal(SIZE)
        drift = 1e-4 * INDEX
        for noise in (x, x + drift, np.cumsum(x), np.convolve(x, np.full(20, 0.2), "same")):
            codes = np.round(noise / width)
            assert why_counter(codes) == ""
            assert why_counter(codes[:256]) == ""
            if np.mean(np.diff(codes) == 0) < 0.9:
                assert why_flag(codes) == ""


def test_no_unit_is_asked_for_what_is_left_out(tmp_path):
    path = table(tmp_path / "a.csv", frame=INDEX % 256, status=0 * INDEX, wy=NOISE)
    for recording in (load(path), read_in_blocks(path, block_samples=8192)):
        (finding,) = (each for each in recording.findings if "No unit" in each)
        assert finding.startswith("No unit is known for wy: ")
