"""Files for other programs: keys, units, conversions and refusals."""

import json
import math
import re

import numpy as np
import pytest
import yaml

import allanfit
from allanfit.cli import main
from allanfit.coefficients import read_coefficients
from allanfit.export import FORMATS, ExportError, Options, export, parse_walk

DEGREE = math.pi / 180


@pytest.fixture
def imu(write_fit, make_channel):
    """Gyro in deg/s, accelerometer in m/s^2, one number per axis by hand."""
    return write_fit(
        make_channel("gx", N=5e-3, B=2e-3, K=3e-4),
        make_channel("gy", N=6e-3, B=1e-3, K=2e-4),
        make_channel("gz", N=4e-3, B=1e-3, K=1e-4, unresolved="QRK"),
        make_channel("ax", unit="m/s^2", N=1e-3, B=4e-4, K=1e-5),
        make_channel("ay", unit="m/s^2", N=2e-3, B=5e-4, K=2e-5),
        make_channel("az", unit="m/s^2", N=3e-3, B=6e-4, K=3e-5),
    )


def kalibr_reads(text):
    """What Kalibr's reader does: safe_load, required keys, numbers above zero."""
    data = yaml.safe_load(text)
    assert isinstance(data["rostopic"], str)
    for key in (
        "update_rate",
        "accelerometer_noise_density",
        "accelerometer_random_walk",
        "gyroscope_noise_density",
        "gyroscope_random_walk",
    ):
        # 1e-05 without a point would be read as text, which Python refuses to compare.
        assert data[key] > 0.0
    return data


def test_kalibr_has_the_worst_axis_in_si(imu):
    exported = export(imu, "kalibr", Options(rostopic="/imu/data"))
    data = kalibr_reads(exported.text)
    assert data["rostopic"] == "/imu/data"
    assert data["update_rate"] == 100.0
    assert data["gyroscope_noise_density"] == pytest.approx(6e-3 * DEGREE, rel=1e-5)
    assert data["gyroscope_random_walk"] == pytest.approx(3e-4 * DEGREE, rel=1e-5)
    assert data["accelerometer_noise_density"] == pytest.approx(3e-3, rel=1e-5)
    assert data["accelerometer_random_walk"] == pytest.approx(3e-5, rel=1e-5)
    assert "rad/s/sqrt(Hz)" in exported.text
    assert "K is not resolved for gz" in exported.text
    assert "Kalibr has no" in exported.text


def test_the_mean_is_that_of_densities(imu):
    data = kalibr_reads(export(imu, "kalibr", Options(axes="mean")).text)
    mean = math.sqrt((5e-3**2 + 6e-3**2 + 4e-3**2) / 3) * DEGREE
    assert data["gyroscope_noise_density"] == pytest.approx(mean, rel=1e-5)
    # The axis whose walk is not resolved is left out.
    walk = math.sqrt((3e-4**2 + 2e-4**2) / 2) * DEGREE
    assert data["gyroscope_random_walk"] == pytest.approx(walk, rel=1e-5)


def test_an_unresolved_walk_is_the_users_choice(write_fit, make_channel):
    path = write_fit(
        make_channel("g", B=2e-3, K=1e-5, unresolved="QRK"), make_channel("a", unit="m/s^2")
    )
    with pytest.raises(ExportError, match=r"K of g is not resolved.*--walk limit.*--walk SECONDS"):
        export(path, "kalibr")
    limit = kalibr_reads(export(path, "kalibr", Options(walk="limit")).text)
    assert limit["gyroscope_random_walk"] == pytest.approx(2e-5 * DEGREE, rel=1e-5)
    covering = kalibr_reads(export(path, "kalibr", Options(walk=100.0)).text)
    # Its Allan deviation at 100 s is the flicker's floor.
    floor = covering["gyroscope_random_walk"] * math.sqrt(100 / 3)
    assert floor == pytest.approx(0.664 * 2e-3 * DEGREE, rel=1e-3)
    # Where K is resolved, both add.
    both = covering["accelerometer_random_walk"] ** 2 * 100 / 3
    assert both == pytest.approx(3e-4**2 * 100 / 3 + (0.66428 * 2e-3) ** 2, rel=1e-3)
    nothing = write_fit(make_channel("g", unresolved="QRKB"))
    with pytest.raises(ExportError, match="--walk limit"):
        export(nothing, "kalibr", Options(walk=100.0))


def test_a_missing_sensor_is_told(write_fit, make_channel):
    exported = export(write_fit(make_channel("g")), "kalibr")
    assert "gyroscope_noise_density" in yaml.safe_load(exported.text)
    assert exported.warnings == ["The fit has no accelerometer, so that its numbers are missing."]
    assert "# The fit has no accelerometer" in exported.text


def test_ros_numbers_are_those_of_each_reader(imu):
    data = yaml.safe_load(export(imu, "ros").text)
    covariance = np.reshape(data["sensor_msgs_imu"]["angular_velocity_covariance"], (3, 3))
    expected = np.diag(np.square([5e-3, 6e-3, 4e-3]) * DEGREE**2 * 100)
    np.testing.assert_allclose(covariance, expected, rtol=1e-5)
    dt = 0.01
    # One step of the midpoint rule in VINS: two half noises in the velocity, one in the bias.
    step = 2 * (0.5 * dt) ** 2 * data["vins"]["acc_n"] ** 2
    assert step == pytest.approx(3e-3**2 * dt, rel=1e-5)
    assert (dt * data["vins"]["acc_w"]) ** 2 == pytest.approx(3e-5**2 * dt, rel=1e-5)
    assert data["gtsam"]["accelerometerCovariance"] == pytest.approx(3e-3**2, rel=1e-5)
    assert data["gtsam"]["biasOmegaCovariance"] == pytest.approx((3e-4 * DEGREE) ** 2, rel=1e-5)


def test_matlab_is_single_sided_and_by_axis(imu):
    text = export(imu, "matlab").text

    def vector(name, occurrence):
        return [float(x) for x in re.findall(rf"'{name}', \[(.*?)\]", text)[occurrence].split()]

    np.testing.assert_allclose(
        vector("NoiseDensity", 0), np.array([5e-3, 6e-3, 4e-3]) * DEGREE, rtol=1e-5
    )
    np.testing.assert_allclose(vector("BiasInstability", 1), [4e-4, 5e-4, 6e-4], rtol=1e-5)
    np.testing.assert_allclose(
        vector("RandomWalk", 0), np.array([3e-4, 2e-4, 0]) * DEGREE, rtol=1e-5
    )
    assert text.count("'NoiseType', 'single-sided'") == 2
    assert "K of gz is not resolved, and set to zero" in text
    # Brackets and quotes pair up outside the comments.
    code = re.sub(r"%.*", "", text)
    assert code.count("(") == code.count(")")
    assert code.count("'") % 2 == 0


def test_matlab_flicker_is_flat_for_as_long_as_it_says():
    """The filter of fractalcoef, by its definition, driven by white noise of deviation B."""
    poles = 200
    denominator = np.cumprod([1.0, *((k - 1.5) / k for k in range(1, poles + 1))])
    f = np.arange(1, 2**20) / 2**21
    response = np.fft.rfft(denominator, 2**21)[1:-1]
    for samples, tolerance in ((6 * poles, 0.11), (poles // 4, 0.01), (40 * poles, None)):
        kernel = 2 * np.sin(np.pi * f * samples) ** 4 / (samples * np.sin(np.pi * f)) ** 2
        variance = np.sum(2 / np.abs(response) ** 2 * kernel) / 2**21
        error = abs(math.sqrt(variance / (2 * math.log(2) / math.pi)) - 1)
        assert error < tolerance if tolerance else error > 0.3


def test_imu_error_model_flicker_is_the_fits(write_fit, make_channel):
    path = write_fit(make_channel("g", B=2e-3), make_channel("a", unit="m/s^2"))
    data = yaml.safe_load(export(path, "imu-error-model").text)
    gyro = data["gyroscope"]
    assert gyro["white_noise_density"] == pytest.approx(5e-3 * DEGREE, rel=1e-5)
    assert gyro["bias_std"] == pytest.approx(3e-4 * DEGREE, rel=1e-5)
    # The simulator's own rule: equal relaxations, evenly spaced in the logarithm of their times,
    # of which the Allan deviation in the middle is flicker_bias_std.
    times = np.geomspace(
        gyro["flicker_min_correlation_time"],
        gyro["flicker_max_correlation_time"],
        gyro["flicker_components"],
    )

    def shape(tau):
        r = tau / times
        return (2 / r - (3 - 4 * np.exp(-r) + np.exp(-2 * r)) / r**2).sum()

    variance = gyro["flicker_bias_std"] ** 2 / shape(np.sqrt(times[0] * times[-1]))
    for tau in np.geomspace(0.2, 3600, 50):
        deviation = math.sqrt(variance * shape(tau))
        assert deviation == pytest.approx(0.66428 * 2e-3 * DEGREE, rel=0.055)


def test_yaml_reads_back_to_the_last_digit(imu, tmp_path):
    path = tmp_path / "coefficients.yaml"
    export(imu, "yaml").write(path)
    assert read_coefficients(path) == read_coefficients(imu)
    document, original = yaml.safe_load(path.read_text()), json.loads(imu.read_text())
    for entry, wanted in zip(document["channels"], original["channels"], strict=True):
        assert entry["coefficients"] == wanted["coefficients"]


def test_yaml_then_simulation_then_fit_gives_the_same_numbers(write_fit, make_channel, tmp_path):
    truth = {"N": 5e-3, "B": 4e-3, "K": 2e-3}
    fit = write_fit(make_channel("x", rate_hz=50.0, samples=30_000, Q=0.0, **truth))
    path, record = tmp_path / "c.yaml", tmp_path / "r.npz"
    export(fit, "yaml").write(path)
    arguments = ["--duration", "600", "--rate", "50", "--seed", "3", "--output", str(record)]
    assert main(["simulate", str(path), *arguments]) == 0
    channel = allanfit.load(record).channels[0]
    assert channel.unit == "deg/s"
    found = allanfit.fit(channel.samples / channel.factor, 50.0)
    for symbol, true in truth.items():
        # 95 % intervals of one record, at a seed that is no exception.
        low, high = found.intervals[symbol]
        assert low < true < high, symbol


@pytest.mark.parametrize("name", FORMATS)
def test_names_cannot_break_out_of_a_comment(write_fit, make_channel, name):
    channels = [make_channel("g\nevil: 1"), make_channel("a", unit="m/s^2")]
    text = export(write_fit(*channels), name).text
    assert "\nevil" not in text


@pytest.mark.parametrize("name", sorted(set(FORMATS) - {"yaml"}))
def test_no_filter_without_white_noise(write_fit, make_channel, name):
    path = write_fit(make_channel("g", unresolved="QRN"))
    with pytest.raises(ExportError, match="N of g is not resolved"):
        export(path, name)


@pytest.mark.parametrize("name", ["kalibr", "ros", "matlab", "imu-error-model"])
def test_units_and_rates_that_do_not_fit_are_refused(write_fit, make_channel, name):
    with pytest.raises(ExportError, match="v in V: fit again with --unit"):
        export(write_fit(make_channel("v", unit="V")), name)
    path = write_fit(make_channel("g"), make_channel("a", unit="m/s^2", rate_hz=50.0))
    with pytest.raises(ExportError, match="g has 100 Hz and a 50 Hz"):
        export(path, name)
    exported = export(write_fit(make_channel("g"), make_channel("v", unit="V")), name)
    assert any("v is neither an angular rate" in each for each in exported.warnings)


def test_what_is_no_fit_is_refused(write_fit, make_channel, tmp_path):
    explained = write_fit(make_channel("g"), schema="allanfit.plan/1")
    with pytest.raises(ExportError, match=r"fit\.json is not a fit"):
        export(explained, "kalman")
    for text, message in {
        "N: 0.005\n": "is not a fit",
        "[1, 2]": "is not a fit",
        '{"schema": "allanfit.fit/1"}': "not a complete fit",
        '{"schema": "allanfit.fit/1", "recording": "r", "channels": []}': "has no channels",
        '{"schema": "allanfit.fit/1", "recording": "r", "channels": [{}]}': "not a complete fit",
    }.items():
        path = tmp_path / "other.json"
        path.write_text(text)
        with pytest.raises(ExportError, match=message):
            export(path, "kalman")
    with pytest.raises(ExportError, match=r"There is no file .*none\.json"):
        export(tmp_path / "none.json", "kalman")
    broken = json.loads(write_fit(make_channel("g")).read_text())
    broken["channels"][0]["coefficients"]["N"]["value"] = -1
    path.write_text(json.dumps(broken))
    with pytest.raises(ExportError, match="not a complete fit"):
        export(path, "kalman")


def test_unknown_formats_and_channels_are_refused(imu):
    with pytest.raises(ExportError, match="'kalmann' is not known; known are kalman, kalibr"):
        export(imu, "kalmann")
    with pytest.raises(ExportError, match="no channel 'wx'; it has gx, gy"):
        export(imu, "kalman", channels=["wx"])


@pytest.mark.parametrize(
    ("name", "option", "options"),
    [
        ("matlab", "walk", Options(walk=10.0)),
        ("yaml", "walk", Options(walk="limit")),
        ("kalibr", "band", Options(band_s=(1.0, 10.0))),
    ],
)
def test_options_without_effect_change_nothing_and_are_told(imu, name, option, options):
    told, plain = export(imu, name, options), export(imu, name)
    assert told.text == plain.text
    said = f"--{option} has no effect on the format {name}."
    assert told.warnings == [*plain.warnings, said]


def test_walks_are_parsed():
    assert parse_walk(None) is None
    assert parse_walk("limit") == "limit"
    assert parse_walk("12.5") == 12.5
    for text in ("", "-1", "0", "nan", "inf", "long"):
        with pytest.raises(ExportError, match="`limit` or a number of seconds"):
            parse_walk(text)


def prose(text):
    """The words of a file's comments or fields, whatever its lines."""
    return " ".join(word for word in text.split() if word not in "#%")


@pytest.mark.parametrize("name", FORMATS)
def test_a_fit_that_does_not_hold_is_doubted_in_the_file_too(write_fit, make_channel, name):
    channel = make_channel("gx")
    channel["goodness_of_fit"] = {"p_value": 1e-9, "consistent": False}
    exported = export(write_fit(channel, make_channel("gy")), name)
    assert "do not explain gx" in exported.warnings[0]
    assert "run `allanfit explain` on the recording" in exported.warnings[0]
    assert exported.warnings[0] in prose(exported.text)
    assert "do not explain gy" not in exported.text
    assert "do not explain" not in export(write_fit(make_channel("gx")), name).text


@pytest.mark.parametrize("name", FORMATS)
def test_several_fits_that_do_not_hold_are_doubted_in_one_sentence(write_fit, make_channel, name):
    doubtful = [make_channel(each) for each in ("gx", "gy", "gz")]
    for channel in doubtful:
        channel["goodness_of_fit"] = {"p_value": 1e-9, "consistent": False}
    exported = export(write_fit(*doubtful), name)
    (said,) = [each for each in exported.warnings if "do not explain" in each]
    assert "do not explain gx, gy and gz: their numbers describe them in part only" in said
    assert prose(exported.text).count("in part only") == 1


def test_without_white_noise_the_advice_is_to_explain_what_the_terms_do_not(
    write_fit, write_explained, make_channel
):
    channel = make_channel("g", unresolved="QRN")
    with pytest.raises(ExportError, match="or record at a higher rate or for longer"):
        export(write_fit(channel), "ros")
    channel["goodness_of_fit"] = {"p_value": 1e-9, "consistent": False}
    with pytest.raises(ExportError, match="run `allanfit explain` on the recording") as refusal:
        export(write_fit(channel), "ros")
    assert "for longer" not in str(refusal.value)
    # Explained as far as may be: there is nothing left to run.
    with pytest.raises(ExportError, match="choose other channels with --channel") as refusal:
        export(write_explained(channel, verdict="unexplained"), "ros")
    assert "run `allanfit" not in str(refusal.value)


def test_the_command_writes_data_and_messages_apart(imu, tmp_path, capsys):
    assert main(["export", str(imu), "--format", "kalman", "--band", "1", "100"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["schema"] == "allanfit.kalman/1"
    assert "K of gz is not resolved" in err
    target = tmp_path / "imu.yaml"
    assert main(["export", str(imu), "--format", "kalibr", "--output", str(target)]) == 0
    kalibr_reads(target.read_text())
    assert main(["export", str(imu), "--format", "kalibr", "--output", "no/where.yaml"]) == 1
    assert main(["export", str(imu), "--format", "nothing"]) == 1
    err = capsys.readouterr().err
    assert "no folder 'no'" in err
    assert "Traceback" not in err
