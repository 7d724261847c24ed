"""The audit's claims, from the printed tables alone and from formulas written out here."""

import numpy as np
import pytest


@pytest.fixture
def audit(example):
    return example("paper_audit")


def test_printed_coefficients_are_one_point_of_the_curve(audit):
    for _, printed in audit.printed_coefficients().values():
        sigma = 0.664 * printed["B"]
        assert sigma * 20 / 3**0.5 == pytest.approx(printed["Q"], rel=0.015)
        assert sigma * (3 / 20) ** 0.5 == pytest.approx(printed["K"], rel=0.015)
        # The slope the wrong way round: dividing by the root of tau, not multiplying.
        assert sigma / 20**0.5 == pytest.approx(printed["N"], rel=0.015)
        for value in audit.sigma_behind(printed).values():
            assert value == pytest.approx(sigma, rel=0.015)
        assert audit.depth_of_random_walk(printed) == pytest.approx(20, rel=0.02)


def test_reading_of_a_lone_term_is_that_term(audit):
    """Each line at 20 s, by IEEE Std 952; for N the rule is wrong by tau."""
    reading = audit.one_point_reading
    assert reading(3**0.5 * 0.01 / 20)["Q"] == pytest.approx(0.01)
    assert reading(0.664 * 0.01)["B"] == pytest.approx(0.01, rel=1e-3)
    assert reading(0.01 * (20 / 3) ** 0.5)["K"] == pytest.approx(0.01)
    assert reading(0.01 / 20**0.5)["N"] == pytest.approx(0.01 / 20)


def test_three_ways_to_read_600_seconds(audit):
    _, roll = audit.printed_coefficients()["roll gyro"]
    found = audit.readings(roll, records=6, seed=5)
    # At 20 s three equal lines add: the point lies a factor of sqrt(3) above each of them.
    for symbol in "QBK":
        assert np.median(found[symbol]["one point"]) == pytest.approx(3**0.5, rel=0.25)
    assert np.nanmin(found["N"]["ruler"]) > 10
    # 24 intervals of 95 %, those of B a little short (docs/paper.md).
    assert sum(audit.covers(each["interval"]).sum() for each in found.values()) >= 19
    assert found["Q"]["resolved"].all()
    assert found["N"]["resolved"].mean() <= 0.5
    np.testing.assert_allclose(found["Q"]["value"], 1, atol=0.02)


def test_rate_table_gives_no_significant_bias(audit):
    table = np.genfromtxt(audit.RATE_TABLE, delimiter=",", names=True)
    rate = np.concatenate([table["rate"], -table["rate"]])
    wanted = {"roll": 1.62, "pitch": -0.83, "yaw": -0.09}
    for name, (bias, (low, high), axis) in audit.rate_table_biases().items():
        reading = np.concatenate([table[f"{name}_cw"], -table[f"{name}_ccw"]])
        assert bias == pytest.approx(6 * np.polyfit(rate, reading, 1)[1])
        assert bias == pytest.approx(wanted[name], abs=0.005)
        assert low < 0 < high
        assert not axis.bias.significant
    text = audit.rate_table_audit()
    assert text.count("outside the interval") == 2


def test_figure_shows_records_that_have_no_slope(audit, tmp_path):
    value = np.array([0.9, 1.1, 1.3])
    each = {
        "one point": value,
        "ruler": np.array([2.0, np.nan, np.nan]),
        "value": value,
        "interval": np.stack([0 * value, 2 * value], axis=-1),
        "resolved": np.array([True, False, True]),
    }
    found = dict.fromkeys("QNBK", each)
    audit.draw(found, tmp_path / "audit.png")
    assert (tmp_path / "audit.png").read_bytes().startswith(b"\x89PNG")
    row = audit.many_records(found).splitlines()[-1]
    assert row.split() == ["K", "1.10", "2.00", "67%", "1.10", "67%", "3", "of", "3"]
