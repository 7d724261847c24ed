"""Verdicts, from draws whose probabilities are known by construction."""

import math

import numpy as np
import pytest

from allanfit.datasheet import Measured, Shown, datasheet_document, datasheet_from, judge
from allanfit.datasheet._lowest import lowest_of_curve, lowest_of_model
from allanfit.report._datasheet_rows import sheet_notes, sheet_rows

SYMBOLS = "QNBKR"


def shown(consistent=True, resolved=SYMBOLS, **values):
    """Draws spread evenly over 1 to 2 times each value, so that quantiles are known."""
    spread = 1 + (np.arange(1000) + 0.5) / 1000
    draws = np.stack([values.get(symbol, 0.0) * spread for symbol in SYMBOLS], axis=1)
    tau = 2.0 ** np.arange(12)
    curve = np.where(tau < 256, 1 / np.sqrt(tau), 1 / 16 * np.sqrt(tau / 256))
    seen = {symbol: symbol in resolved for symbol in SYMBOLS}
    told = {
        symbol: Measured(*(values.get(symbol, 0.0) * at for at in (1.5, 1.025, 1.975, 1.95)))
        for symbol in SYMBOLS
    }
    return Shown(draws, told, seen, consistent, 1.0, tau, curve, 100_000)


def judged(lines, evidence):
    sheet = datasheet_from({"gyro": lines}, "sheet.yaml")
    return sheet, judge(sheet.of("gx", "gyro"), evidence)


@pytest.mark.parametrize(
    ("stated", "verdict", "probability"),
    [
        (1.96, "met", 0.96),
        (1.94, "cannot be told", 0.94),
        (1.06, "cannot be told", 0.06),
        (1.04, "missed", 0.04),
    ],
)
def test_a_coefficient_is_met_with_the_share_of_draws_below_it(stated, verdict, probability):
    _, (line,) = judged({"angle random walk": f"{stated} rad/s/√Hz"}, shown(N=1.0))
    assert (line.verdict, line.probability) == (verdict, pytest.approx(probability))
    assert line.measured == pytest.approx(1.5)
    assert line.interval_95 == pytest.approx((1.025, 1.975), abs=1e-3)
    assert line.as_coefficient is None


def test_what_the_fit_tells_is_told_and_not_the_draws_alone():
    evidence = shown(N=1.0)
    told = {**evidence.coefficients, "N": Measured(1.5, 1.0, 2.1, 2.0)}
    lines = {"angle random walk": "1.96 rad/s/√Hz", "noise density": "2.8 rad/s/√Hz"}
    _, (walk, density) = judged(lines, evidence._replace(coefficients=told))
    assert (walk.measured, walk.interval_95) == (pytest.approx(1.5), pytest.approx((1.0, 2.1)))
    assert density.interval_95 == pytest.approx((math.sqrt(2), 2.1 * math.sqrt(2)))


def test_a_density_is_one_sided_and_the_other_reading_is_told():
    _, (line,) = judged({"noise density": "2.2 rad/s/√Hz"}, shown(N=1.0))
    assert line.measured == pytest.approx(1.5 * math.sqrt(2))
    assert line.probability == pytest.approx(2.2 / math.sqrt(2) - 1, abs=1e-3)
    assert (line.verdict, line.as_coefficient) == ("cannot be told", "met")


def test_units_of_the_line_are_those_of_its_numbers():
    _, (line,) = judged({"arw": "1.7 deg/√h"}, shown(N=math.radians(1 / 60)))
    assert line.measured == pytest.approx(1.5)
    assert line.probability == pytest.approx(0.7, abs=1e-3)


def test_the_lowest_point_of_the_model_is_that_of_its_curve():
    # N^2/tau + K^2 tau/3 + (2 ln 2/pi) B^2 is lowest at 2 N K/sqrt(3), plus the flat part.
    n, b, k = 3.0, 0.5, 1e-3
    expected = math.sqrt(2 * n * k / math.sqrt(3) + 2 * math.log(2) / math.pi * b**2)
    (found,) = lowest_of_model(np.array([[0.0, n, b, k, 0.0]]), 0.01)
    assert found == pytest.approx(expected, rel=1e-3)


def test_bias_instability_is_the_lowest_point_where_the_model_holds():
    _, (line,) = judged({"bias instability": "1.5 rad/s"}, shown(B=2.0))
    floor = math.sqrt(2 * math.log(2) / math.pi)
    assert line.measured == pytest.approx(3.0 * floor, rel=1e-6)
    assert line.probability == pytest.approx(1.5 / floor / 2 - 1, abs=2e-3)
    assert line.as_coefficient == "missed"


def test_the_curve_is_read_where_the_model_does_not_hold():
    evidence = shown(consistent=False, B=100.0)
    _, (low, high) = judged(
        {"bias instability": "0.05 rad/s", "in-run bias stability": "0.08 rad/s"}, evidence
    )
    assert (low.verdict, high.verdict) == ("missed", "met")
    assert low.measured == pytest.approx(1 / 16, rel=1e-2)
    # 5 N^2/(4 n (N + 3 n)) = 484.6 degrees of freedom: half a 95 % interval is 1.96/sqrt(2 nu).
    assert low.interval_95 == pytest.approx((0.05883, 0.06665), rel=5e-3)


def test_a_curve_that_still_falls_cannot_be_missed():
    tau = 2.0 ** np.arange(8)
    draws, reached = lowest_of_curve(tau, 1 / np.sqrt(tau), 5000)
    assert not reached
    assert np.median(draws) == pytest.approx(128**-0.5, rel=0.02)
    evidence = shown(consistent=False)._replace(sizes=tau, deviation=tau**-0.5, samples=5000)
    _, (strict, lax) = judged(
        {"bias instability": "0.01 rad/s", "in-run bias stability": "0.2 rad/s"}, evidence
    )
    assert (strict.verdict, strict.probability) == ("cannot be told", None)
    assert lax.verdict == "met"


def test_nothing_can_be_told_of_a_fit_that_did_not_converge():
    sheet, lines = judged({"N": "1 deg/√h"}, None)
    left_out = ["In x.yaml, bandwidth of gyro is left out."]
    document = datasheet_document(sheet, lines, left_out)
    assert document["left_out"] == left_out
    channel = {"datasheet": document, "goodness_of_fit": {}}
    channel["goodness_of_fit"]["consistent"] = False
    (row,) = sheet_rows(channel)
    assert (row.verdict, row.measured, row.chance) == ("cannot be told", "unknown", "unknown")


def test_rows_and_notes_say_how_words_were_read():
    sheet, lines = judged(
        {"noise density": "2.2 rad/s/√Hz", "rate random walk": {"max": "1.5 rad/s/√s"}},
        shown(N=1.0, K=0.5, resolved="N"),
    )
    channel = {
        "datasheet": datasheet_document(sheet, lines),
        "goodness_of_fit": {"consistent": False},
    }
    density, walk = sheet_rows(channel)
    assert density.stated == "2.2 rad/s/√Hz typical"
    assert (walk.stated, walk.measured, walk.verdict) == ("1.5 rad/s/√s max", "< 0.98", "met")
    # Half of 1.95, where 95 % of the draws lie below; half of 1.975 ends the interval.
    assert [line.upper_limit_95 for line in lines] == [None, pytest.approx(0.975, abs=1e-3)]
    old = datasheet_document(sheet, lines)
    for line in old["lines"]:
        del line["upper_limit_95"]
    assert sheet_rows({"datasheet": old})[1].measured == "< 0.99"
    reading, misfit = sheet_notes(channel)
    assert reading == (
        "noise density is read as the root of a one-sided density, √2 N; read as N itself, it is "
        "met."
    )
    assert "do not explain" in misfit
