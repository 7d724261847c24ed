"""Which columns are temperatures, in which unit, and what the checksum is of."""

import hashlib

import numpy as np
import pytest

from allanfit.recording import load, save

SAMPLES = 400


@pytest.fixture
def table(tmp_path):
    """Writes a gyro beside another column, whose header is given."""
    rng = np.random.default_rng(0)
    noise = rng.normal(size=SAMPLES)

    def write(header, values, name="still.csv"):
        rows = [f"{k / 10},{noise[k]},{values[k]}" for k in range(SAMPLES)]
        path = tmp_path / name
        path.write_text("\n".join([f"time_s,gyro_x [deg/s],{header}", *rows]))
        return path

    return write


@pytest.mark.parametrize(
    ("header", "degree", "zero"),
    [
        ("temperature [degC]", 1, 0),
        ("temp [°C]", 1, 0),
        ("imu_temp [deg C]", 1, 0),
        ("T [C]", 1, 0),
        ("die [K]", 1, 273.15),
        ("imu/temperature [kelvin]", 1, 273.15),
        ("Temperature [degF]", 1.8, 32),
        ("T [°F]", 1.8, 32),
    ],
)
def test_a_temperature_is_known_by_its_name_or_unit(table, header, degree, zero):
    truth = np.linspace(20, 25, SAMPLES)
    recording = load(table(header, truth * degree + zero))
    assert [channel.name for channel in recording.channels] == ["gyro_x"]
    (temperature,) = recording.auxiliary
    assert (temperature.kind, temperature.si_unit) == ("temperature", "degC")
    np.testing.assert_allclose(temperature.samples, truth)
    assert recording.findings == ()


def test_a_bare_capital_t_beside_the_time_is_a_temperature(table):
    recording = load(table("T", np.linspace(20, 25, SAMPLES)))
    assert recording.auxiliary[0].kind == "temperature"
    assert "T is taken to be in degC" in recording.findings[0]
    assert recording.rate_hz == pytest.approx(10)


def test_a_temperature_without_a_unit_above_200_is_in_kelvin(table):
    recording = load(table("temperature", np.linspace(293.15, 295.15, SAMPLES)))
    assert recording.auxiliary[0].samples[0] == pytest.approx(20)
    assert "taken to be in K" in recording.findings[0]


def test_a_temperature_logged_more_rarely_is_interpolated(table):
    truth = np.linspace(20, 25, SAMPLES)
    values = [f"{truth[k]}" if k % 10 == 0 else "" for k in range(SAMPLES)]
    (temperature,) = load(table("temp [degC]", values)).auxiliary
    np.testing.assert_allclose(temperature.samples[:390], truth[:390], atol=1e-9)


@pytest.mark.parametrize(
    ("header", "values", "why"),
    [
        ("temp [V]", np.linspace(1, 2, SAMPLES), "its unit 'V' is none of degC, K and degF"),
        ("temp [degC]", [""] * 60 + ["20.5"] * 340, "15 % of the recording on end has none"),
    ],
)
def test_a_temperature_that_cannot_be_used_is_said(table, header, values, why):
    recording = load(table(header, values))
    assert [channel.kind for channel in recording.auxiliary] == ["other"]
    assert why in recording.findings[0]


def test_a_temperature_of_another_length_is_said(tmp_path):
    noise = np.random.default_rng(0).normal(size=SAMPLES)
    np.savez(tmp_path / "a.npz", gyro_x=noise, temperature=np.arange(40.0), rate_hz=10.0)
    recording = load(tmp_path / "a.npz", unit="deg/s")
    assert recording.auxiliary == ()
    assert "it has 40 values and the channels 400 samples" in recording.findings[0]


def test_the_checksum_is_of_samples_units_and_temperature(tmp_path):
    noise = np.random.default_rng(0).normal(size=(2, SAMPLES))

    def checksum(samples=noise[0], unit="deg/s", temperature=20 + noise[1], name="a.npz"):
        columns = {"gyro_x": samples, "temperature": temperature}
        save(tmp_path / name, columns, {"gyro_x": unit, "temperature": "degC"}, 10.0)
        return load(tmp_path / name).checksum

    usual = checksum()
    by_hand = hashlib.sha256()
    factor = load(tmp_path / "a.npz").channels[0].factor
    for values, unit in ((noise[0] * factor, "rad/s"), (20 + noise[1], "degC")):
        by_hand.update(values.tobytes())
        by_hand.update(unit.encode())
    assert usual == by_hand.hexdigest()
    assert usual == checksum(name="b.csv")
    changed = noise[0].copy()
    changed[7] += 1e-12
    assert len({usual, checksum(changed), checksum(unit="rad/s"), checksum(unit="mg"),
                checksum(temperature=noise[1])}) == 5  # fmt: skip
    assert checksum(unit="counts") != checksum(unit="V")
