"""Likely mistakes: each is told, and healthy sensors of every grade are not accused of any."""

import numpy as np
import pytest

from allanfit.recording import load
from allanfit.recording._gravity import about_gravity
from allanfit.recording._mistakes import about_mistakes

DEGREE = np.pi / 180
RATE_HZ = 100.0
#: N [rad/s/sqrt(Hz)], bias [rad/s] and code width [deg/s] of gyros, from a ring laser to a toy.
GYROS = {
    "navigation": (6e-7, 5e-8, 1e-7),
    "tactical": (3e-6, 1e-5, 1e-5),
    "tactical mems": (5e-5, 2e-3, 6.25e-3),
    "industrial mems": (1e-4, 5e-3, 0.02),
    "consumer": (2e-4, 0.05, 250 / 32768),
    "consumer, wide": (5e-4, 0.2, 2000 / 32768),
    "consumer, old": (9e-4, 0.35, 0.07),
}
#: N [m/s^2/sqrt(Hz)], bias [m/s^2] and code width [m/s^2] of accelerometers.
ACCELEROMETERS = {
    "navigation": (5e-5, 1e-4, 1e-6),
    "tactical": (3e-4, 5e-3, 1e-4),
    "consumer": (1.5e-3, 0.3, 9.80665 / 16384),
    "consumer, wide": (4e-3, 0.5, 9.80665 * 16 / 32768),
}


def sensor(noise, bias, code, seed, *, samples=6000, rate_hz=RATE_HZ, drift=0.02):
    """White noise, a random walk that passes it after minutes, and codes, in SI."""
    rng = np.random.default_rng(seed)
    white = noise * np.sqrt(rate_hz) * rng.standard_normal(samples)
    walk = drift * noise / np.sqrt(rate_hz) * np.cumsum(rng.standard_normal(samples))
    values = bias * rng.uniform(-1, 1) + white + walk
    return np.round(values / code) * code


def gyro(grade, seed=0, **options):
    noise, bias, code = GYROS[grade]
    return sensor(noise, bias, code * DEGREE, seed, **options)


def triad(grade, seed=0, **options):
    """Three accelerometers in any attitude."""
    gravity = np.random.default_rng(seed).standard_normal(3)
    gravity *= 9.80665 / np.linalg.norm(gravity)
    noise, bias, code = ACCELEROMETERS[grade]
    return [sensor(noise, bias, code, [seed, k], **options) + gravity[k] for k in range(3)]


def told(archive, unit, *series, rate_hz=RATE_HZ, **extra):
    """The findings on series in one unit."""
    names = [f"axis_{k}" for k in range(len(series))]
    units = str(dict.fromkeys(names, unit)).replace("'", '"')
    path = archive(**dict(zip(names, series, strict=True)), units=units, rate_hz=rate_hz, **extra)
    return [str(each) for each in load(path).findings]


def alarms(archive, unit, *series, rate_hz=RATE_HZ):
    names = [f"axis_{k}" for k in range(len(series))]
    units = str(dict.fromkeys(names, unit)).replace("'", '"')
    path = archive(**dict(zip(names, series, strict=True)), units=units, rate_hz=rate_hz)
    recording = load(path)
    return about_mistakes(recording.channels, recording.rate_hz)


@pytest.mark.parametrize("grade", GYROS)
@pytest.mark.parametrize("rate_hz", [10.0, 100.0, 1000.0])
def test_healthy_gyros_of_every_grade_are_not_accused(grade, rate_hz, archive):
    for seed in range(4):
        axes = [gyro(grade, [seed, k], rate_hz=rate_hz) for k in range(3)]
        for unit, factor in (("rad/s", 1.0), ("deg/s", DEGREE), ("deg/h", DEGREE / 3600)):
            scaled = [axis / factor for axis in axes]
            assert alarms(archive, unit, *scaled, rate_hz=rate_hz) == ()


@pytest.mark.parametrize("grade", ACCELEROMETERS)
def test_healthy_accelerometers_of_every_grade_are_not_accused(grade, archive):
    for seed in range(6):
        axes = triad(grade, seed)
        for unit, factor in (("m/s^2", 1.0), ("g", 9.80665), ("mg", 9.80665e-3)):
            assert alarms(archive, unit, *[axis / factor for axis in axes]) == ()


def test_a_warm_up_is_no_mistake(archive):
    time = np.arange(60_000) / RATE_HZ
    warm = gyro("consumer", samples=time.size) + 0.6 * DEGREE * np.exp(-time / 200)
    assert alarms(archive, "rad/s", warm) == ()


def test_outliers_and_a_damaged_packet_are_no_motion(archive):
    rng = np.random.default_rng(3)
    series = gyro("consumer")
    series[rng.random(series.size) < 0.07] += 0.5 * rng.standard_t(2)
    series[3000:3010] = 30.0
    assert alarms(archive, "rad/s", series) == ()


def test_a_filtered_sensor_is_no_sum(archive):
    rng = np.random.default_rng(4)
    white = rng.standard_normal(60_000)
    smooth = np.convolve(white, np.exp(-np.arange(200) / 40), "valid") * 1e-3
    assert alarms(archive, "rad/s", smooth, rate_hz=1000.0) == ()


@pytest.mark.parametrize("grade", ["consumer", "consumer, wide", "consumer, old"])
def test_degrees_called_radians(grade, archive):
    findings = told(archive, "rad/s", gyro(grade, 1) / DEGREE)
    assert any("give --unit deg/s" in each for each in findings), findings


def test_noise_that_no_gyro_in_radians_has(archive):
    noise, bias, _ = GYROS["consumer, wide"]
    findings = told(archive, "rad/s", sensor(noise, bias, 1e-7, 1) / DEGREE)
    assert any("ten times that of the worst gyros: if" in each for each in findings), findings


@pytest.mark.parametrize("grade", ["consumer", "consumer, wide", "consumer, old"])
def test_radians_called_degrees_told_by_the_codes(grade, archive):
    findings = told(archive, "deg/s", gyro(grade, 2))
    assert any("give --unit rad/s" in each for each in findings), findings


def test_a_rate_that_no_still_gyro_reads(archive):
    findings = told(archive, "deg/s", gyro("industrial mems") / DEGREE + 100)
    assert any("which no gyro does at rest" in each for each in findings), findings


def test_g_called_metres(archive):
    series = [axis / 9.80665 for axis in triad("consumer")]
    assert any("gravity in g: if so, give --unit g" in e for e in told(archive, "m/s^2", *series))


@pytest.mark.parametrize("unit", ["deg/s", "rad/s", "g", "m/s^2"])
def test_counts_with_a_unit(unit, archive):
    counts = np.round(20 * np.random.default_rng(1).standard_normal(4000))
    assert any("raw counts" in each for each in told(archive, unit, counts))


@pytest.mark.parametrize("unit", ["mg", "deg/h", "counts"])
def test_whole_numbers_of_small_units_are_no_counts(unit, archive):
    counts = np.round(20 * np.random.default_rng(1).standard_normal(4000))
    assert not any("raw counts" in each for each in told(archive, unit, counts))


@pytest.mark.parametrize(("unit", "what"), [("rad/s", "an angle"), ("m/s^2", "a velocity")])
@pytest.mark.parametrize("bias", [0.0, 0.1])
def test_sums(unit, what, bias, archive):
    rates = np.random.default_rng(2).standard_normal(20_000) + bias
    findings = told(archive, unit, np.cumsum(1e-5 * rates))
    assert any(f"as those of {what} do" in each for each in findings), findings


def test_sums_of_a_large_bias_are_refused_as_counters(archive):
    path = archive(gyro_x=np.cumsum(np.random.default_rng(2).standard_normal(4000) + 50))
    with pytest.raises(ValueError, match="an angle or a velocity that was summed up"):
        load(path)


@pytest.mark.parametrize("swap", ["m/s^2", "g"])
def test_gravity_in_the_gyros(swap, archive, tmp_path):
    factor = {"m/s^2": 1.0, "g": 9.80665}[swap]
    gyros = [gyro("consumer", [5, k]) / DEGREE for k in range(3)]
    names = [*(f"gyro_{k}" for k in "xyz"), *(f"accel_{k}" for k in "xyz")]
    series = [axis / factor for axis in triad("consumer", 5)] + [axis / 100 for axis in gyros]
    units = dict(zip(names, ["deg/s"] * 3 + ["m/s^2"] * 3, strict=True))
    path = archive(**dict(zip(names, series, strict=True)), units=str(units).replace("'", '"'))
    findings = load(path).findings
    assert any(f"gravity in {swap}: are the columns" in each for each in findings), findings


def of_imu(archive, gyros, accelerometers, units=("deg/s", "g")):
    """The findings on six axes."""
    names = [f"{kind}_{axis}" for kind in ("gyro", "accel") for axis in "xyz"]
    units = str(dict(zip(names, np.repeat(units, 3).tolist(), strict=True))).replace("'", '"')
    return load(archive(**dict(zip(names, [*gyros, *accelerometers], strict=True)), units=units))


@pytest.mark.parametrize(("unit", "factor"), [("g", 9.80665), ("mg", 9.80665e-3), ("m/s^2", 1.0)])
def test_swapped_columns_of_gyros_with_a_bias(unit, factor, archive):
    """The bias, 0.37 deg/s in all, is no gravity either."""
    gyros = [gyro("consumer", [5, k]) / DEGREE for k in range(3)]
    gyros = [axis - axis.mean() + bias for axis, bias in zip(gyros, (0.1, -0.2, 0.3), strict=True)]
    gravity = [axis / factor for axis in triad("consumer", 5)]
    findings = of_imu(archive, gravity, gyros, ("deg/s", unit)).findings
    assert any(f"gravity in {unit}: are the columns" in each for each in findings), findings
    assert not any("feel" in each for each in findings), findings


@pytest.mark.parametrize("felt", [0.37, 0.76, 1.35, 30.0])
@pytest.mark.parametrize(("unit", "factor"), [("g", 1.0), ("m/s^2", 9.80665)])
def test_accelerometers_that_feel_no_possible_gravity(felt, unit, factor, archive):
    axes = [axis / 9.80665 * felt * factor for axis in triad("tactical", 3)]
    gyros = [gyro("consumer", [5, k]) / DEGREE for k in range(3)]
    (finding,) = (e for e in of_imu(archive, gyros, axes, ("deg/s", unit)).findings if "feel" in e)
    assert finding == (
        f"accel_x, accel_y and accel_z feel {felt * factor:.3g} {unit} in all, and at rest they "
        f"would feel gravity, {factor:.3g} {unit}: is the unit or a scale factor another, or a "
        "column not what its name says?"
    )


def test_a_linear_acceleration(archive):
    axes = [axis - axis.mean() for axis in triad("consumer")]
    gyros = [gyro("consumer", [5, k]) / DEGREE for k in range(3)]
    (finding,) = (
        e for e in of_imu(archive, gyros, axes, ("deg/s", "m/s^2")).findings if "feel" in e
    )
    assert "in all: gravity was taken out" in finding


@pytest.mark.parametrize("grade", ACCELEROMETERS)
def test_accelerometers_with_all_their_errors_feel_gravity(grade, archive):
    """A scale factor of 3 %, a bias on each axis, and a sensor that is laid on another side."""
    gyros = [gyro("consumer", [5, k]) / DEGREE for k in range(3)]
    for seed in range(4):
        bias = ACCELEROMETERS[grade][1]
        axes = [1.03 * axis + bias for axis in triad(grade, seed)]
        axes = [np.concatenate([axes[k], axes[k - 1]]) for k in range(3)]
        longer = [np.tile(axis, 2) for axis in gyros]
        findings = of_imu(archive, longer, axes, ("deg/s", "m/s^2")).findings
        assert not any("feel" in each or "swapped" in each for each in findings), findings


def test_one_accelerometer_may_feel_anything(archive):
    findings = load(
        archive(accel_x=triad("consumer")[0] / 3, units='{"accel_x": "m/s^2"}')
    ).findings
    assert not any("feel" in each for each in findings), findings


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_stamps_off_by_a_thousand(scale, archive):
    stamps = np.arange(6000) / RATE_HZ / scale
    findings = told(archive, "rad/s", gyro("consumer"), rate_hz=None, time_s=stamps)
    assert any("time stamps in" in each and "The rate is" in each for each in findings), findings


def test_an_interval_given_for_the_rate(archive):
    findings = told(archive, "rad/s", gyro("consumer"), rate_hz=0.01)
    assert any("a sample every 100 s" in each for each in findings), findings


@pytest.mark.parametrize("kind", ["turned", "shaken", "tilted"])
def test_a_sensor_that_was_touched(kind, archive):
    series, unit = gyro("consumer"), "rad/s"
    if kind == "turned":
        series[2000:2400] += 0.5
    elif kind == "shaken":
        series[2000:2400] += 0.5 * np.random.default_rng(1).standard_normal(400)
    else:
        series, unit = triad("consumer")[0], "m/s^2"
        series[4000:] += 1.0
    (finding,) = (each for each in told(archive, unit, series) if "not at rest" in each)
    # A window of a second either side.
    start = float(finding.split(" s after")[0].split()[-1])
    assert (20 if kind != "tilted" else 40) - 1 <= start <= (24 if kind != "tilted" else 60)


def test_a_sensor_that_was_turned_is_no_angle(archive):
    """Its changes grow with the time between two samples as well, up to the time it was turned."""
    series = gyro("consumer", samples=30_000)
    series[19_800:20_200] += 50 * DEGREE
    findings = told(archive, "rad/s", series)
    assert any("not at rest" in each for each in findings), findings
    assert not any("as those of an angle do" in each for each in findings), findings


def test_real_recordings_are_not_accused(shared):
    accused = {}
    for path in sorted((shared / "recordings").glob("*.npz")):
        if path.stem.startswith(("published", "adis16405_b")):
            continue
        recording = load(path)
        said = about_mistakes(recording.channels, recording.rate_hz)
        accused |= {path.stem: said + about_gravity(recording.channels)}
    assert {name: each for name, each in accused.items() if each} == {}


def test_the_time_of_a_touch_counts_what_is_missing(archive):
    series = gyro("consumer")
    series[:1000] = np.nan
    series[2000:2400] += 0.5
    (finding,) = (each for each in told(archive, "rad/s", series) if "not at rest" in each)
    assert 19 <= float(finding.split(" s after")[0].split()[-1]) <= 24
