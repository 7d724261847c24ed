import io
import warnings

import numpy as np
import pytest

from allanfit.report import figure
from allanfit.report._figures import svg


def texts(axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def legend(axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_four_panels_with_units(document):
    sheet = figure(document["channels"][0])
    allan, psd, allan_residual, psd_residual = sheet.axes
    assert allan.get_ylabel() == "Allan deviation [deg/s]"
    assert psd.get_ylabel() == "power spectral density [(deg/s)²/Hz]"
    assert allan_residual.get_xlabel() == "averaging time τ [s]"
    assert psd_residual.get_xlabel() == "frequency [Hz]"
    assert {allan.get_xscale(), allan.get_yscale()} == {"log"}


def test_each_term_is_labelled_on_its_line(document):
    allan = figure(document["channels"][0]).axes[0]
    assert texts(allan) == ["N", "B", "K"]
    assert legend(allan) == [
        "data, 95 % interval",
        "fit",
        "N  angle random walk",
        "B  bias instability",
        "K  rate random walk",
    ]


def test_a_term_that_is_not_resolved_is_dotted(document):
    channel = document["channels"][0]
    channel["coefficients"]["K"]["resolved"] = False
    allan = figure(channel).axes[0]
    assert legend(allan)[-1] == "K  rate random walk (not resolved)"
    assert allan.lines[-1].get_linestyle() == ":"


def test_residuals_leave_the_band_where_the_interval_misses_the_model(document):
    curve = document["channels"][0]["curves"]["psd"]
    curve["model"][10] = 1.01 * curve["band_95"][1][10]
    curve["model"][20] = 0.99 * curve["band_95"][1][20]
    points = np.asarray(figure(document["channels"][0]).axes[3].lines[-1].get_ydata())
    assert points[10] < -1.96 < points[20] < 0


def test_a_gross_misfit_leaves_the_rest_readable(document):
    curve = document["channels"][0]["curves"]["psd"]
    for values in (curve["density"], *curve["band_95"]):
        values[60] *= 1e6
    residual = figure(document["channels"][0]).axes[3]
    assert residual.get_yscale() == "symlog"


def test_undefined_points_are_left_out(document):
    curve = document["channels"][0]["curves"]["allan"]
    curve["deviation"][-1] = None
    curve["band_95"][0][-1] = curve["band_95"][1][-1] = None
    shown = np.asarray(figure(document["channels"][0]).axes[0].lines[0].get_ydata())
    assert np.isnan(shown[-1])
    assert np.isfinite(shown[:-1]).all()


@pytest.mark.parametrize("model", [None, "nulls"])
def test_a_curve_without_data_says_so(document, model):
    channel = document["channels"][0]
    size = 0 if model is None else 3
    channel["curves"]["psd"] = {
        "frequency_hz": [1.0, 2.0, 3.0][:size],
        "density": [None] * size,
        "model": [None] * size,
        "band_95": [[None] * size, [None] * size],
    }
    sheet = figure(channel)
    assert texts(sheet.axes[1]) == texts(sheet.axes[3]) == ["no data"]
    sheet.savefig(io.BytesIO(), format="png")


def test_a_fit_without_a_model_still_shows_the_data(document):
    channel = document["channels"][0]
    curve = channel["curves"]["allan"]
    curve["model"] = [None] * len(curve["tau_s"])
    curve["terms"] = {}
    sheet = figure(channel)
    assert texts(sheet.axes[2]) == ["no data"]
    sheet.savefig(io.BytesIO(), format="png")


def test_a_dollar_in_a_name_is_no_formula(document):
    channel = document["channels"][2]
    channel["channel"] = "$\\broken{$"
    figure(channel).savefig(io.BytesIO(), format="png")


def test_figures_leave_no_state_behind(document):
    import matplotlib as mpl

    before = mpl.rcParams.copy()
    sheet = figure(document["channels"][0])
    sheet.savefig(io.BytesIO(), format="png")
    assert mpl.rcParams.copy() == before
    # A figure made through pyplot would have a manager, and stay in memory with it.
    assert sheet.canvas.manager is None


def test_the_users_settings_do_not_change_the_page(document):
    import matplotlib as mpl

    channel = document["channels"][0]
    plain = svg(channel, "allan", "a-")
    with mpl.rc_context({"font.size": 20, "svg.fonttype": "none", "lines.linewidth": 9}):
        assert svg(channel, "allan", "a-") == plain


def test_the_svg_stands_alone(document):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        element = svg(document["channels"][0], "psd", "psd-1-")
    assert element.startswith("<svg")
    assert "<metadata>" not in element
    assert element.count('id="') == element.count('id="psd-1-')
    assert element.count("url(#") == element.count("url(#psd-1-")
    assert element.count('href="#') == element.count('href="#psd-1-') > 0
