"""The rate-table test: a published table and its audit, coverage, the Earth, and bad tables."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import linregress, t

from allanfit.calibrate import rate_table

TABLE = Path(__file__).parents[2] / "examples" / "rate_table.csv"
DEGREES_PER_RPM = 6.0


def columns(rates=(10.0, 20.0, 30.0), bias=0.3, scale=0.01, earth=0.0, scatter=0.0, seed=0):
    rates = np.array(rates)
    error = scatter * np.random.default_rng(seed).standard_normal((2, len(rates)))
    return {
        "rate": rates,
        "cw": (1 + scale) * (rates + earth) + bias + error[0],
        "ccw": (1 + scale) * (-rates + earth) + bias + error[1],
    }


@pytest.mark.parametrize(
    ("axis", "bias", "bias_error", "scale", "scale_error"),
    [
        # Computed by hand from the published readings: deg/s and per cent, standard errors.
        ("roll", 1.62, 1.90, 0.49, 1.24),
        ("pitch", -0.83, 0.92, -0.45, 0.60),
        ("yaw", -0.09, 1.48, -0.03, 0.97),
    ],
)
def test_published_table(axis, bias, bias_error, scale, scale_error):
    found = rate_table(TABLE, unit="rpm")[axis]
    quantile = t.ppf(0.975, 8)
    for quantity, factor, value, error in (
        (found.bias, DEGREES_PER_RPM, bias, bias_error),
        (found.scale_factor, 100.0, scale, scale_error),
    ):
        low, high = quantity.intervals["0.95"]
        assert quantity.value * factor == pytest.approx(value, abs=0.006)
        assert (high - low) / 2 / quantile * factor == pytest.approx(error, abs=0.006)
        assert quantity.significant is False


def test_published_table_rate_by_rate():
    first = rate_table(TABLE, unit="rpm")["roll"].per_rate[0]
    assert first == pytest.approx({"rate": 10.0, "bias": 0.1, "scale_factor": 0.04})


def test_what_stands_out_is_named_and_the_rest_is_not():
    findings = rate_table(TABLE, unit="rpm").findings
    assert len(findings) == 1
    assert "roll: the counter-clockwise reading at 25 rpm" in findings[0]


def test_intervals_are_those_of_a_straight_line():
    data = columns(scatter=0.2)
    found = rate_table(data, unit="deg/s")["data"]
    signed = np.concatenate([data["rate"], -data["rate"]])
    line = linregress(signed, np.concatenate([data["cw"], data["ccw"]]) - signed)
    for quantity, value, error in (
        (found.bias, line.intercept, line.intercept_stderr),
        (found.scale_factor, line.slope, line.stderr),
    ):
        for level in (0.68, 0.95):
            half = t.ppf((1 + level) / 2, 4) * error
            expected = (value - half, value + half)
            np.testing.assert_allclose(quantity.intervals[f"{level}"], expected, rtol=1e-9)


def test_intervals_hold_the_truth():
    # 1000 trials: 950 expected, standard deviation 6.9; beyond four of them once in 16000.
    held = np.zeros(2)
    for seed in range(1000):
        found = rate_table(columns(scatter=0.5, seed=seed), unit="deg/s")["data"]
        for k, (quantity, truth) in enumerate(((found.bias, 0.3), (found.scale_factor, 0.01))):
            low, high = quantity.intervals["0.95"]
            held[k] += low <= truth <= high
    assert np.all(np.abs(held - 950) < 27.6), held


def test_magnitudes_and_signs_are_the_same_table():
    signed = columns()
    magnitudes = {**signed, "ccw": np.abs(signed["ccw"])}
    found = [rate_table(data, unit="deg/s")["data"].bias.value for data in (signed, magnitudes)]
    assert found == pytest.approx([0.3, 0.3])


@pytest.mark.parametrize("latitude", [48.0, -30.0])
def test_the_earth_is_taken_out_of_the_bias_alone(latitude):
    # Clockwise seen from above is the Earth's way round in the south and against it in the north;
    # a sidereal day has 86164.1 s.
    earth = -360 / 86164.1 * math.sin(math.radians(latitude))
    data = columns(rates=(0.1, 0.2, 0.3), bias=0.01, earth=earth)
    found = rate_table(data, unit="deg/s", latitude_deg=latitude)["data"]
    assert found.bias.value == pytest.approx(0.01, abs=1e-7)
    assert found.scale_factor.value == pytest.approx(0.01, abs=1e-7)
    assert [row["bias"] for row in found.per_rate] == pytest.approx([0.01] * 3, abs=1e-7)
    without = rate_table(data, unit="deg/s")["data"]
    assert without.bias.value == pytest.approx(0.01 + 1.01 * earth, abs=1e-7)


def test_the_earth_as_the_reference():
    # 15.041 deg/h times the sine of the latitude, up and turned over, as the paper has it.
    rate = 15.0410671 * math.sin(math.radians(60.0))
    table = {"cw": np.array([1.02 * rate - 3.0]), "ccw": np.array([-1.02 * rate - 3.0])}
    found = rate_table(table, unit="deg/h", latitude_deg=60.0, reference="earth")["data"]
    assert found.bias.value == pytest.approx(-3.0, rel=1e-6)
    assert found.scale_factor.value == pytest.approx(0.02, rel=1e-4)
    assert found.bias.intervals["0.95"] is None


def at_rest(readings, scatter, seed=0):
    """Readings of a gyro at 60 degrees north, up and turned over, with a bias of -3 deg/h."""
    rate = 15.0410671 * math.sin(math.radians(60.0))
    noise = scatter * np.random.default_rng(seed).standard_normal((2, readings))
    return {"cw": rate - 3.0 + noise[0], "ccw": -rate - 3.0 + noise[1]}


def exchanged(table):
    return {"cw": table["ccw"], "ccw": table["cw"]}


def of_the_earth(table):
    return rate_table(table, unit="deg/h", latitude_deg=60.0, reference="earth")


def test_the_earth_seen_the_wrong_way_round_is_refused():
    table = at_rest(4, scatter=0.5)
    assert of_the_earth(table).findings == ()
    with pytest.raises(
        ValueError, match="change against the Earth's rate: the columns are swapped"
    ):
        of_the_earth(exchanged(table))


def test_the_earth_seen_the_wrong_way_round_once_is_told():
    # A single pair has no interval, and a gyro that barely resolves the Earth a wide one.
    for readings, scatter in ((1, 0.0), (2, 4.0)):
        table = at_rest(readings, scatter, seed=3)
        assert of_the_earth(table).findings == ()
        (finding,) = of_the_earth(exchanged(table)).findings
        assert "the columns may be swapped" in finding


def test_what_rounding_leaves_of_an_exact_line_is_no_outlier():
    rates = np.array([10.0, 20.0, 40.0, 60.0, 80.0, 100.0, 150.0, 200.0])
    for unit in ("deg/s", "rpm", "rad/s"):
        for bias in np.linspace(0.011, 0.0123456789, 20):
            exact = rates * 1.0037 + bias, rates * 1.0037 - bias
            for digits in (3, 6, 15):
                cw, ccw = (np.round(each, digits) for each in exact)
                found = rate_table({"rate": rates, "cw": cw, "ccw": ccw}, unit=unit)
                assert found.findings == ()
    # Ten units in the last place are no rounding.
    cw[3] += 1e-5
    (finding,) = rate_table({"rate": rates, "cw": cw, "ccw": ccw}, unit="rpm").findings
    assert "the clockwise reading at 60 rpm stands out" in finding


def test_two_rates_give_values_and_the_reason_for_no_intervals():
    found = rate_table(columns(rates=(10.0, 20.0)), unit="rpm")
    assert found["data"].bias.value == pytest.approx(0.3)
    assert found["data"].bias.intervals == {"0.68": None, "0.95": None}
    assert found.to_dict()["axes"]["data"]["significant"] == {"bias": None, "scale_factor": None}
    assert "at least 3" in found.findings[0]


def test_units_of_headers_count(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(
        "rate [rpm],cw [deg/s],ccw [deg/s]\n10,60.6,-60\n20,120.6,-120\n30,180.6,-180\n"
    )
    axis = rate_table(path)["data"]
    assert axis.bias.unit == "deg/s"
    assert axis.bias.value == pytest.approx(0.3)
    # What was given in rpm is told in the unit of the readings.
    assert axis.per_rate[0]["rate"] == pytest.approx(60.0)


def test_the_document():
    document = rate_table(TABLE, unit="rpm").to_dict()
    json.dumps(document, allow_nan=False)
    assert document["schema"] == "allanfit.calibrate/1"
    assert list(document["axes"]) == ["roll", "pitch", "yaw"]
    roll = document["axes"]["roll"]
    assert roll["bias"]["unit"] == "rpm"
    assert roll["scale_factor"]["unit"] == "1"
    assert roll["significant"] == {"bias": False, "scale_factor": False}
    assert len(roll["bias"]["intervals"]["0.68"]) == 2
    assert set(roll["per_rate"][0]) == {"rate", "bias", "scale_factor"}


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("rate,cw\n1,1\n2,2\n", {}, "a column cw but no ccw"),
        ("rate,roll_cw,pitch_ccw\n1,1,1\n2,2,2\n", {}, "no roll_ccw"),
        ("cw,ccw\n1,1\n2,2\n", {}, "no column rate"),
        ("rate,speed\n1,1\n2,2\n", {}, "has a column 'speed'"),
        ("rate,cw,ccw\n1,1,1\n2,two,2\n3,3,3\n", {}, "line 3, column cw: 'two'"),
        ("rate,cw,ccw\n1,1,1\n2,,2\n3,3,3\n", {}, "the column cw has no number in row 2"),
        ("rate,cw,ccw\n1,1,1\n0,0.1,-0.1\n3,3,3\n", {}, "row 2 is zero"),
        ("rate,cw,ccw\n1,1,1\n-2,2,2\n3,3,3\n", {}, "row 2 is negative"),
        ("rate,cw,ccw\n1,1,1\n2,2,2.1\n2,2,2.1\n", {}, "1 row twice"),
        ("rate,cw,ccw\n1,-1,1\n2,-2,2\n3,-3,3\n", {}, "the columns are swapped"),
        ("rate,cw,ccw\n1,1,1\n2,2,-2\n3,3,3\n", {}, "readings change their sign in row 2"),
        ("rate,cw,ccw\n1,6,6\n2,12,12\n3,18,18\n", {}, "in one unit"),
        ("rate [rpm],cw,ccw\n1,1,1\n2,2,2\n", {}, "no unit for cw, ccw"),
        ("rate,cw,ccw\n1,1,1\n2,2,2\n3,3,3\n", {"unit": "m/s^2"}, "not one of an angular rate"),
        ("rate,cw,ccw\n1,1,1\n2,2,2\n3,3,3\n", {"unit": "furlong"}, "is not known"),
        ("rate,cw,ccw\n1,1,1\n2,2,2\n", {"latitude_deg": 50.0}, "A latitude takes a unit"),
        ("rate,cw,ccw\n1,1,1\n", {"unit": "rpm", "latitude_deg": 95.0}, "from -90 to 90"),
        ("cw,ccw\n1,-1\n", {"unit": "rpm", "reference": "earth"}, "takes --latitude"),
    ],
)
def test_bad_tables(tmp_path, text, options, message):
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        rate_table(path, **options)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"rate": [], "cw": [], "ccw": []}, "columns of the rate table are empty"),
        ({"rate": [1.0], "cw": [1.0], "CW": [2.0], "ccw": [1.0]}, "data has two columns cw"),
        ({"rate": [1.0], "cw": [1.0], " cw": [2.0], "ccw": [1.0]}, "data has two columns cw"),
    ],
)
def test_bad_columns(table, message):
    with pytest.raises(ValueError, match=message):
        rate_table(table)
