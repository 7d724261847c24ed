from explanation_documents import make_explanation

from allanfit import plan
from allanfit.report import explanation_html, fit_html, fits_html


def test_a_fit_has_units_intervals_and_limits(document):
    shown = fit_html(document)
    for fact in (
        "gyro_x, 100 Hz, 1 h: 95 % intervals",
        "0.30000 [0.29928, 0.30072] deg/√h",
        "&lt; 0.036 arcsec",
        "not resolved",
        "the five terms agree with both curves (p = 0.41)",
    ):
        assert fact in shown
    assert "&lt;script&gt;alert" in shown
    assert "<script" not in shown
    assert "<img" not in shown


def test_an_explanation_has_its_effects(document):
    shown = explanation_html(make_explanation(document))
    assert "A sinusoid</td>" in shown
    assert "&gt; 99.9 %" in shown
    assert "amplitude 0.03010 [0.02992, 0.03028] deg/s" in shown
    assert "intervals do not overlap" in shown
    assert "<script" not in shown


def test_many_sensors_are_cut_short():
    ones = [1.0] * 12
    shown = fits_html({"N": ones}, {"N": [[0.9, 1.1]] * 12}, {"N": ones}, {"N": [True] * 12})
    assert shown.count("1.00 [0.90, 1.10]") == 10
    assert "2 more sensors." in shown


def test_a_plan_is_a_table():
    shown = plan({"N": 5e-3, "B": 1e-3}, 50.0, {"B": 0.1})._repr_html_()
    assert "10 %</td>" in shown
    assert "taken as absent: Q, K and R." in shown
