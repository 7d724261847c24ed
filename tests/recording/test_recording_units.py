"""Units of a data sheet, as people write them, and to which channels they apply."""

import math

import numpy as np
import pytest

from allanfit.recording import RecordingError, contents, load, read_in_blocks
from allanfit.recording._units import parse_unit

DEGREE = math.pi / 180
GRAVITY = 9.80665


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("rad/s", 1.0),
        ("Rad/S", 1.0),
        ("rad s^-1", 1.0),
        ("rad*s-1", 1.0),
        ("mrad/s", 1e-3),
        ("deg/s", DEGREE),
        ("degrees/sec", DEGREE),
        ("deg per s", DEGREE),
        ("°/s", DEGREE),
        ("º/s", DEGREE),
        ("dps", DEGREE),
        ("DPS", DEGREE),
        ("mdps", 1e-3 * DEGREE),
        ("deg/h", DEGREE / 3600),
        ("°/hr", DEGREE / 3600),
        ("degree/hour", DEGREE / 3600),
        ("deg/min", DEGREE / 60),
        ("arcsec/s", DEGREE / 3600),
        ("rpm", 2 * math.pi / 60),
    ],
)
def test_angular_rates(name, factor):
    unit = parse_unit(name)
    assert (unit.name, unit.kind, unit.si_unit) == (name, "gyro", "rad/s")
    assert unit.factor == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        *((name, 1.0) for name in ("m/s^2", "m/s2", "m/s²", "m/s**2", "m/s/s", "m s^-2")),
        *((name, 1.0) for name in ("m·s-2", "m.s^-2", "ms-2", "ms^-2")),
        ("g", GRAVITY),
        ("G", GRAVITY),
        ("mg", 1e-3 * GRAVITY),
        ("ug", 1e-6 * GRAVITY),
        ("\N{MICRO SIGN}g", 1e-6 * GRAVITY),
        ("\N{GREEK SMALL LETTER MU}g", 1e-6 * GRAVITY),
        ("cm/s^2", 1e-2),
        ("Gal", 1e-2),
        ("mGal", 1e-5),
        ("ft/s^2", 0.3048),
    ],
)
def test_accelerations(name, factor):
    unit = parse_unit(name)
    assert (unit.name, unit.kind, unit.si_unit) == (name, "accelerometer", "m/s^2")
    assert unit.factor == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    "name",
    ["", "1", "counts", "LSB", "V", "mV", "u", "au", "Hz", "m/s", "deg", "deg/s^2", "uT", "degC"],
)
def test_all_else_passes_through(name):
    unit = parse_unit(name)
    assert (unit.name, unit.kind, unit.si_unit, unit.factor) == (name, "other", name, 1.0)


@pytest.mark.parametrize(
    "name",
    ["furlong", "2*m", "9**9**9", "m^9^9", "m^99999999", "mg/", "(((", "x" * 100, "m/s; rm", "__a"],
)
def test_unknown_units_list_the_known_ones(name):
    with pytest.raises(RecordingError, match=r"is not known: give rad/s, deg/s.*m/s\^2.*counts"):
        parse_unit(name)


def mixed(noise: np.ndarray, units: str | None) -> dict[str, object]:
    return {"gyro_x": noise[:, 0], "accel_x": noise[:, 1], "data": noise[:, 2], "units": units}


def units_of(recording) -> list[str]:
    return [channel.unit for channel in recording.channels]


def test_a_unit_given_goes_where_its_kind_fits(archive, noise):
    bare = archive(**mixed(noise, None))
    assert units_of(load(bare, unit="deg/s")) == ["deg/s", "", "deg/s"]
    assert units_of(load(bare, unit="mg")) == ["", "mg", "mg"]
    assert units_of(load(bare, unit="counts")) == ["counts", "counts", "counts"]
    stated = archive(**mixed(noise, '{"gyro_x": "rad/s", "accel_x": "g", "data": "V"}'))
    assert units_of(load(stated, unit="deg/s")) == ["deg/s", "g", "V"]
    with pytest.raises(RecordingError, match="unit deg/s fits none of the channels: accel_x is"):
        load(stated, unit="deg/s", channels=["accel_x"])


def test_a_unit_given_mends_an_unknown_one_of_the_file(archive, noise):
    path = archive(gyro_x=noise[:, 0], units='{"gyro_x": "furlong"}')
    with pytest.raises(RecordingError, match="'furlong' is not known"):
        load(path)
    assert units_of(load(path, unit="deg/s")) == ["deg/s"]


def test_a_unit_given_for_channels_that_are_not_asked_for_is_no_mistake(archive, noise):
    path = archive(Gyr_X=noise[:, 0], Acc_X=noise[:, 1], rate_hz=100.0, units=None)
    for read in (load, read_in_blocks):
        (channel,) = read(path, unit="rad/s, m/s^2", channels=["Gyr_X"]).channels
        assert channel.unit == "rad/s"
        with pytest.raises(RecordingError, match="fits none of the channels: Gyr_X is in"):
            read(path, unit="m/s^2", channels=["Gyr_X"])
    stated = archive(Gyr_X=noise[:, 0], Acc_X=noise[:, 1], units='{"Gyr_X": "dps", "Acc_X": "g"}')
    assert units_of(load(stated, unit="rad/s, m/s^2", channels=["Gyr_X"])) == ["rad/s"]
    with pytest.raises(RecordingError, match="The unit V fits none of the channels: Gyr_X is in"):
        load(stated, unit="rad/s, V", channels=["Gyr_X"])
    # A clock and a thermometer are no channels that it could be for.
    clock = archive(
        Gyr_X=noise[:, 0], time=np.arange(400) / 100, temperature=25 + noise[:, 1], units=None
    )
    with pytest.raises(RecordingError, match=r"m/s\^2 fits none of the channels"):
        load(clock, unit="rad/s, m/s^2", channels=["Gyr_X"])


@pytest.mark.parametrize(
    ("stated", "given", "used"),
    [
        ("rad/s", "deg/s", "deg/s"),
        ("deg/s", "mdps, g", "mdps"),
        ("deg/s", "1/131 deg/s", "0.007634 deg/s"),
        ("m/s^2", "g", "g"),
        ("V", "mV", "mV"),
    ],
)
def test_a_unit_that_is_not_the_files_is_said(stated, given, used, archive, write, noise):
    rows = "".join(f"{a:.9f},{b:.9f},1\n" for a, b in 1e-3 * noise[:, :2])
    text = write("mix.csv", f"wx [{stated}],wy [{stated}],ax [g]\n{rows}".encode())
    units = f'{{"wx": "{stated}", "wy": "{stated}"}}'
    packed = archive(wx=1e-3 * noise[:, 0], wy=1e-3 * noise[:, 1], units=units)
    told = f"The file says {stated} for wx, wy; --unit {used} was used instead."
    for path in (text, packed):
        given_here = given if path is text else given.split(",")[0]
        for read in (load, read_in_blocks):
            asked = {"rate_hz": 100.0, "channels": ["wx", "wy"]}
            assert told in read(path, unit=given_here, **asked).findings
            assert not any("was used instead" in each for each in read(path, **asked).findings)


@pytest.mark.parametrize(
    ("stated", "given"),
    [
        ("deg/s", "dps"),
        ("°/s", "deg/s"),
        ("dps", "1000 mdps"),
        ("m/s2", "m/s^2"),
        ("counts", "LSB"),
    ],
)
def test_the_same_unit_spelled_otherwise_and_none_are_not_said(stated, given, archive, noise):
    for units in (f'{{"x": "{stated}"}}', None, '{"x": "furlong"}'):
        found = load(archive(x=1e-3 * noise[:, 0], units=units), unit=given).findings
        assert not any("was used instead" in each for each in found)


def test_no_unit_is_said_once(archive, noise):
    recording = load(archive(**mixed(noise, None)))
    assert [channel.kind for channel in recording.channels] == ["other"] * 3
    assert [channel.factor for channel in recording.channels] == [1.0] * 3
    (finding,) = recording.findings
    assert finding.startswith("No unit is known for gyro_x, accel_x, data: ")
    assert "--unit deg/s" in finding


def test_a_unit_of_the_wrong_kind_is_said(archive, noise):
    recording = load(archive(gyro_x=noise[:, 0], units='{"gyro_x": "g"}'))
    assert recording.findings == ("The unit g of gyro_x is not one of a gyro.",)


@pytest.mark.parametrize(
    ("level", "unit", "says"), [(1.0, "m/s^2", "g"), (9.81, "g", "m/s^2"), (1000.0, "g", "mg")]
)
def test_gravity_in_another_unit_is_said(level, unit, says, archive, noise):
    axes = {f"accel_{axis}": 1e-3 * noise[:, k] for k, axis in enumerate("xyz")}
    axes["accel_z"] += level
    units = dict.fromkeys(axes, unit)
    path = archive(**axes, units=str(units).replace("'", '"'))
    (finding,) = load(path).findings
    assert f"would be gravity in {says}: if so, give --unit {says}." in finding
    told = f"The file says {unit} for accel_x, accel_y, accel_z; --unit {says} was used instead."
    assert load(path, unit=says).findings == (told,)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("wx_dps", "deg/s"),
        ("Gyro X dps", "deg/s"),
        ("wz_deg_s", "deg/s"),
        ("wz_deg_per_sec", "deg/s"),
        ("rate_dph", "deg/h"),
        ("wx_mdps", "mdps"),
        ("gyro_x_rad_s", "rad/s"),
        ("gyro_x_radps", "rad/s"),
        ("accel_x_mps2", "m/s^2"),
        ("ay_ms2", "m/s^2"),
        ("ay_m_s2", "m/s^2"),
        ("wx_deg/s", "deg/s"),
        ("gyro_x °/h", "deg/h"),
        ("gyro_x_rad/s", "rad/s"),
        ("az_m/s^2", "m/s^2"),
        ("ax_g", "g"),
        ("imu0_accel_x_mg", "mg"),
        ("wx_counts", "counts"),
    ],
)
def test_the_unit_at_the_end_of_a_name(name, unit, archive, noise):
    path = archive(**{name: 1e-3 * noise[:, 0]}, units=None)
    recording = load(path)
    assert units_of(recording) == [unit]
    assert recording.channels[0].factor == parse_unit(unit).factor
    assert recording.findings == (f"Units are taken from the names: {name} in {unit}.",)
    (listed,) = contents(path)
    assert listed.units == {name: unit}
    assert read_in_blocks(path).findings == recording.findings


@pytest.mark.parametrize(
    "name",
    ["dps", "wx", "theta_rads", "roll_degs", "vel_m_s_2", "sum_g", "gyro_g", "x_C", "img", "ax_kg"],
)
def test_an_ending_that_may_be_something_else_is_no_unit(name, archive, noise):
    recording = load(archive(**{name: noise[:, 0]}, units=None))
    assert units_of(recording) == [""]
    assert recording.findings[0].startswith("No unit is known")


def test_a_unit_in_a_name_gives_way(archive, noise, write):
    path = archive(wx_dps=1e-3 * noise[:, 0], wy_dps=noise[:, 1], units='{"wx_dps": "rad/s"}')
    recording = load(path)
    assert units_of(recording) == ["rad/s", "deg/s"]
    assert recording.findings == ("Units are taken from the names: wy_dps in deg/s.",)
    bare = archive(wx_dps=noise[:, 0], ax_g=noise[:, 1], units=None)
    assert units_of(load(bare, unit="rad/s")) == ["rad/s", "g"]
    assert units_of(load(bare, unit="mg")) == ["deg/s", "mg"]
    assert units_of(load(bare, unit="counts")) == ["counts", "counts"]
    assert load(bare, unit="counts").findings == ()
    counted = archive(wx_counts=noise[:, 0], units=None)
    assert units_of(load(counted, unit="deg/s")) == ["deg/s"]


def test_codes_take_what_one_of_them_is_worth(archive, noise):
    """By the user, in place of the file's counts, and by the name of the channel."""
    path = archive(
        gyro_x=np.round(131 * noise[:, 0]),
        ax=np.round(100 * noise[:, 1]),
        units='{"gyro_x": "LSB", "ax": "counts"}',
    )
    recording = load(path, unit="1/131 deg/s, 0.01 g")
    assert units_of(recording) == ["deg/s", "g"]
    assert not any("instead" in finding for finding in recording.findings)
    expected = np.radians(np.round(131 * noise[:, 0]) / 131)
    np.testing.assert_allclose(recording.channels[0].samples, expected)
    with pytest.raises(RecordingError, match="fits none of the channels"):
        load(path, unit="deg/s")


@pytest.mark.parametrize(
    ("name", "offset"),
    [("temp_degC", 0), ("temp_C", 0), ("imu_temp_C", 0), ("T_K", 273.15), ("board_celsius", 0)],
)
def test_temperatures_by_the_end_of_their_names(name, offset, archive, noise):
    arrays = {"wx_dps": noise[:, 0], "time": np.arange(400) / 100}
    warm = 25 + 0.1 * noise[:, 1]
    recording = load(archive(**arrays, **{name: warm + offset}, units=None))
    (temperature,) = recording.auxiliary
    assert (temperature.kind, temperature.findings) == ("temperature", ())
    np.testing.assert_allclose(temperature.samples, warm, atol=1e-9)
    assert len(recording.findings) == 1


def six_axes(noise: np.ndarray) -> dict[str, object]:
    return dict.fromkeys(("gx", "gy", "gz", "ax", "ay", "az"), noise[:, 0]) | {"rate_hz": 100.0}


def test_units_of_two_kinds_go_by_names(archive, noise):
    recording = load(archive(**six_axes(noise)), unit="deg/s, m/s^2")
    assert units_of(recording) == ["deg/s"] * 3 + ["m/s^2"] * 3
    # Of one alone the others have none, and are no gyros.
    recording = load(archive(**six_axes(noise)), unit="deg/s")
    assert units_of(recording) == ["deg/s"] * 3 + [""] * 3
    assert "No unit is known for ax, ay, az" in recording.findings[0]


@pytest.mark.parametrize("given", ["1/131 deg/s", "0.0076335877862595419 deg/s", "1 / 131 * deg/s"])
def test_raw_codes_have_a_scale_factor(given, archive, noise):
    codes = np.round(noise[:, 0] * 1000)
    (channel,) = load(archive(gyro_x=codes, rate_hz=100.0), unit=given).channels
    assert channel.unit == "deg/s"
    np.testing.assert_allclose(channel.samples, codes / 131 * np.pi / 180, rtol=1e-14)
    (run, *_) = read_in_blocks(archive(gyro_x=codes, rate_hz=100.0), unit=given)
    np.testing.assert_allclose(run.samples, codes / 131 * np.pi / 180, rtol=1e-14)


@pytest.mark.parametrize("given", ["0/131 deg/s", "1/0 deg/s", "1e400 deg/s", "1.2.3 deg/s"])
def test_a_scale_factor_is_a_positive_number(given, archive, noise):
    with pytest.raises(RecordingError, match="scale factor"):
        load(archive(gyro_x=noise[:, 0], rate_hz=100.0), unit=given)


def test_a_column_in_an_unknown_unit_is_named(archive, noise):
    units = '{"gyro_x": "deg/s", "flow": "sccm"}'
    path = archive(gyro_x=noise[:, 0], flow=noise[:, 1], rate_hz=100.0, units=units)
    with pytest.raises(RecordingError, match=r"The column flow: .*'sccm'.* --channel"):
        load(path)
    assert load(path, channels="gyro_x").channels[0].name == "gyro_x"
