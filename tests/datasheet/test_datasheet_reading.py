"""Phrases and words of data sheets, against numbers worked out by hand."""

import math

import numpy as np
import pytest

import allanfit
from allanfit.cli import main
from allanfit.coefficients import read_coefficients
from allanfit.datasheet import DatasheetError
from allanfit.datasheet._phrase import parse_phrase
from allanfit.explain.simulation._references import references
from allanfit.recording import Channel, Recording

DEGREE = math.pi / 180
MICRO_G = 9.80665e-6


def write(folder, text):
    path = folder / "sheet.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("phrase", "symbol", "si"),
    [
        ("0.15 deg/sqrt(h)", "N", 0.15 * DEGREE / 60),
        ("0.15 °/√hr", "N", 0.15 * DEGREE / 60),
        ("0.15deg/rt-hr", "N", 0.15 * DEGREE / 60),
        ("4 mdps/sqrt(Hz)", "N", 4e-3 * DEGREE),
        ("4 mdps/√Hz", "N", 4e-3 * DEGREE),
        ("0.05 °/sec/√Hz rms", "N", 0.05 * DEGREE),
        ("60 ug/sqrt(Hz)", "N", 60 * MICRO_G),
        ("60 µg/√Hz", "N", 60 * MICRO_G),
        ("60 \N{GREEK SMALL LETTER MU}g/√(Hz)", "N", 60 * MICRO_G),
        ("0.02 m/s/√h", "N", 0.02 / 60),
        ("2 deg/h", "B", 2 * DEGREE / 3600),
        ("7 °/hr (1σ)", "B", 7 * DEGREE / 3600),
        ("< 7 °/hr, 1 sigma", "B", 7 * DEGREE / 3600),
        ("0.1 mg", "B", 1e-4 * 9.80665),
        ("5e-4 (deg/h)/sqrt(h)", "K", 5e-4 * DEGREE / 3600 / 60),
        ("3 m/s^3/√Hz", "K", 3.0),
        ("2 arcsec", "Q", 2 * DEGREE / 3600),
        ("1 deg/h²", "R", DEGREE / 3600**2),
    ],
)
def test_phrases_are_understood(phrase, symbol, si):
    quantity = parse_phrase(phrase)
    assert (quantity.measured.symbol, quantity.si) == (symbol, pytest.approx(si, rel=1e-12))


@pytest.mark.parametrize(
    ("phrase", "message"),
    [
        ("0.3 deg/s RMS at 92 Hz bandwidth", "shape of a filter.*give the noise density"),
        ("0.3 parsec", "'parsec' is not known; understood are such as deg/sqrt.h. or deg/h"),
        ("0.3", "'0.3' has no unit"),
        ("good", "'good' is not a number"),
        (True, "'True' is not a number"),
        ("-1 deg/h", "must be above zero"),
        ("1e999 deg/h", "must be above zero"),
        ("0,009 °/s/√Hz", "has a comma in its number: write a decimal point"),
        ("1,500.5 ug", "has a comma in its number"),
    ],
)
def test_phrases_that_mean_nothing_are_refused(phrase, message):
    with pytest.raises(DatasheetError, match=message):
        parse_phrase(phrase)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gyro: {angle random wlak: 1 deg/√h}", "angle random wlak of gyro is not understood"),
        ("gyro:\n\tnoise density: 1", "sheet.yaml has lines that begin with tabs.*with spaces"),
        ("gyro: {noise density: 0.009}", "write 0.009 deg/s/sqrt.Hz., for example"),
        ("accelerometer: {noise density: 60}", "write 60 ug/sqrt.Hz., for example"),
        ("accelerometer: {velocity random walk: 0.1}", "write 0.1 m/s/sqrt.h., for example"),
        ("gyro: {bias stability: 7}", "write 7 deg/h, for example"),
        ("gyro: {N: {max: 0,009 °/s/√Hz}}", "has a comma in its number"),
        ("gyro: {bias instabilty: 2 deg/h}", "if it means bias instability, write so"),
        ("gyro: {full scale: 500 deg/s}", "says nothing of the noise of a sensor at rest.*walk"),
        ("gyro: {noise density: 60 µg/√Hz}", r"cannot be in µg/√Hz; give it in deg/sqrt\(h\)"),
        ("accelerometer: {B: 2 deg/h}", "cannot be in deg/h; give it in ug, m/s"),
        ("gyro: {noise density: 2 deg/h}", "noise density of gyro cannot be in deg/h"),
        ("gyro: {N: {worst: 1 deg/√h}}", "N of gyro has worst; give typical or max"),
        ("gyro: {N: {as: coefficient}}", "N of gyro has no number"),
        ("gyro: {K: {max: 1 deg/h/√h, as: allan_minimum}}", "cannot be read as 'allan_minimum'"),
        ("gyro: {}\nx: 1", "'gyro' in sheet.yaml has no lines"),
        ("gyro: 5\nx: {}", "'gyro' in sheet.yaml has no lines"),
        ("imu: {N: 1 deg/√h, B: 1 mg}", "'imu' in sheet.yaml mixes deg/√h and mg"),
        ("sensor: none", "holds no data sheet"),
        ("- 1", "holds no data sheet; give sections"),
        ("a: b: c", "neither JSON nor YAML"),
    ],
)
def test_sheets_that_make_no_sense_are_refused(tmp_path, text, message):
    with pytest.raises(DatasheetError, match=message) as caught:
        allanfit.read_datasheet(write(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_a_mark_before_the_number_makes_it_a_largest_value_unless_one_is_named(tmp_path):
    path = write(
        tmp_path,
        "gyro:\n"
        "  bias instability: < 7 deg/hr\n"
        "  angle random walk: ≤0.2 deg/√h\n"
        "  rate random walk: {typical: < 3 deg/h/√h}\n"
        "  noise density: 0.01 deg/s/√Hz\n",
    )
    bounds = [line.bound for line in allanfit.read_datasheet(path).lines]
    assert bounds == ["max", "max", "typical", "typical"]


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(DatasheetError, match=r"There is no file .*none.yaml"):
        allanfit.read_datasheet(tmp_path / "none.yaml")


def test_words_say_how_a_number_is_read(tmp_path):
    path = write(
        tmp_path,
        "gyro:\n"
        "  Noise Density: 3 deg/s/√Hz\n"
        "  in run bias stability: {max: 2 deg/s}\n"
        "  rate random walk: 5 deg/s/√s\n"
        "accelerometer:\n"
        "  noise density: {typical: 3 m/s^2/√Hz, as: coefficient}\n"
        "  B: 2 m/s^2\n",
    )
    gyro, accelerometer = read_coefficients(path)
    assert (gyro.channel, gyro.unit) == ("gyro", "rad/s")
    floor = math.sqrt(2 * math.log(2) / math.pi)
    assert gyro.values == {
        "N": pytest.approx(3 * DEGREE / math.sqrt(2)),
        "B": pytest.approx(2 * DEGREE / floor),
        "K": pytest.approx(5 * DEGREE),
    }
    assert (accelerometer.channel, accelerometer.unit) == ("accelerometer", "m/s^2")
    assert accelerometer.values == {"N": pytest.approx(3.0), "B": pytest.approx(2.0)}


def test_a_random_walk_is_preferred_to_a_density_and_typical_to_largest(tmp_path):
    path = write(
        tmp_path,
        "gyro: {noise density: 9 deg/s/√Hz, "
        "angle random walk: {max: 120 deg/√h, typical: 60 deg/√h}}",
    )
    (gyro,) = read_coefficients(path)
    assert gyro.values["N"] == pytest.approx(DEGREE)


def test_lines_that_are_not_about_noise_at_rest_are_left_out_with_a_sentence(tmp_path, capsys):
    others = {
        "zero-rate offset": "1 dps",
        "rms noise": "0.3 deg/s at 92 Hz",
        "full scale": "{max: 500 dps}",
        "bandwidth": "92",
        "bias stability (over temperature)": "30 deg/h",
    }
    text = "gyro:\n  bias stability: 7 deg/hr\n  Angle Random Walk (ARW): 60 deg/√h\n"
    path = write(tmp_path, text + "".join(f"  {name}: {it}\n" for name, it in others.items()))
    sheet = allanfit.read_datasheet(path)
    assert [(line.symbol, line.meaning) for line in sheet.lines] == [
        ("B", "allan_minimum"),
        ("N", "coefficient"),
    ]
    told = sheet.left_out_of("gx", "gyro")
    assert [f"In sheet.yaml, {name} of gyro is left out" in each for name, each in
            zip(others, told, strict=True)] == [True] * 5  # fmt: skip
    assert sheet.left_out_of("ax", "accelerometer") == []
    assert main(["plan", str(path), "--rate", "100", "--want", "N=1%"]) == 0
    assert capsys.readouterr().err.count("is left out") == 5


def make_recording(*channels):
    made = tuple(
        Channel(name, unit, 1.0, unit, kind, samples=np.zeros(1), stretches=(), findings=())
        for name, unit, kind in channels
    )
    return Recording("bench.csv", 100.0, made, (), (), "")


GYROS = (("gx", "rad/s", "gyro"), ("gy", "rad/s", "gyro"), ("ax", "m/s^2", "accelerometer"))


def test_a_channel_has_its_own_lines_or_those_of_its_kind(tmp_path):
    sheet = allanfit.read_datasheet(
        write(tmp_path, "gyro: {N: 1 deg/√h}\ngx: {N: 2 deg/√h}\naccelerometer: {B: 1 mg}")
    )
    sheet.check("bench.csv", make_recording(*GYROS).channels)
    numbers = [[line.number for line in sheet.of(name, kind)] for name, _, kind in GYROS]
    assert numbers == [[2.0], [1.0], [1.0]]
    assert sheet.of("other", "other") == ()


@pytest.mark.parametrize(
    ("text", "channels", "message"),
    [
        ("gz: {N: 1 deg/√h}", GYROS, "is about 'gz', which bench.csv has not; it has gx, gy, ax"),
        ("ax: {N: 1 deg/√h}", GYROS, r"N of ax is in deg/√h, which is not of a channel in m/s\^2"),
        ("accelerometer: {B: 1 mg}", GYROS[:2], "says nothing about gx, gy"),
        ("gyro: {B: 1 deg/h}", [("c", "", "other")], "give the unit of the recording with --unit"),
    ],
)
def test_a_sheet_of_another_recording_is_refused(tmp_path, text, channels, message):
    sheet = allanfit.read_datasheet(write(tmp_path, text))
    with pytest.raises(DatasheetError, match=message):
        sheet.check("bench.csv", make_recording(*channels).channels)


def test_explain_compares_each_channel_with_the_sheet_of_its_kind(tmp_path):
    path = write(tmp_path, "gyro: {N: 60 deg/√h}\naccelerometer: {N: 60 m/s/√h}")
    found = references(path, make_recording(*GYROS), "point")
    values = {name: reference.coefficients[1] for name, reference in found.items()}
    assert values == pytest.approx({"gx": DEGREE, "gy": DEGREE, "ax": 1.0})
    # A gyro's alone says nothing about an accelerometer.
    found = references(write(tmp_path, "gyro: {N: 1 deg/√h}"), make_recording(*GYROS), "point")
    assert list(found) == ["gx", "gy"]
