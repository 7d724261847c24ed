import io
import warnings
from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import chi2

from allanfit.report import figure
from allanfit.report._figures import svg
from allanfit.report._interactive import curve_figure
from allanfit.report._shares_panel import draw_shares
from allanfit.report._temperature_panel import draw_temperature


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


def test_a_term_below_the_figure_is_not_in_its_legend(document):
    channel = document["channels"][0]
    curve = channel["curves"]["allan"]
    # Seen down to a third of the lowest point.
    for share, there in ((0.4, True), (0.2, False)):
        curve["terms"]["K"] = [share * min(curve["deviation"])] * len(curve["tau_s"])
        assert ("K  rate random walk" in legend(figure(channel).axes[0])) == there
        traces = curve_figure(channel, "allan")["data"]
        assert any("rate random walk" in each.get("name", "") for each in traces) == there


def in_sight(axes, box, points) -> bool:
    """Whether none of some points of the data is behind a box [pixels]."""
    across, along = axes.transData.transform(points).T
    inside = (across > box.x0) & (across < box.x1) & (along > box.y0) & (along < box.y1)
    return not inside.any()


@pytest.mark.parametrize("kind", ["allan", "psd"])
@pytest.mark.parametrize("channel", [0, 1, 2])
def test_legend_and_letters_hide_neither_points_nor_bars(document, channel, kind):
    """Also where names are long: four terms, two of them not resolved."""
    shown = document["channels"][channel]
    for symbol in "BK":
        shown["coefficients"][symbol]["resolved"] = False
    axes = figure(shown).axes[kind == "psd"]
    x_key, y_key = {"allan": ("tau_s", "deviation"), "psd": ("frequency_hz", "density")}[kind]
    curve = shown["curves"][kind]
    points = np.column_stack([curve[x_key], curve[y_key]])
    low, high = (np.column_stack([curve[x_key], each]) for each in curve["band_95"])
    bars = np.concatenate([low ** (1 - part) * high**part for part in np.linspace(0, 1, 99)])
    box = axes.get_legend().get_window_extent()
    assert in_sight(axes, box, np.concatenate([points, bars]))
    assert axes.bbox.x0 < box.x0 < box.x1 < axes.bbox.x1
    assert axes.bbox.y0 < box.y0 < box.y1 < axes.bbox.y1
    axes.figure.canvas.draw()
    for letter in axes.texts:
        assert in_sight(axes, letter.get_bbox_patch().get_window_extent(), points)
        assert not box.overlaps(letter.get_window_extent())


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


@pytest.mark.parametrize(("ordinates", "shown"), [(1, False), (2, True)])
def test_one_ordinate_that_is_nothing_by_chance_takes_no_room(ordinates, shown, document):
    """The interval of one goes from a fifth to a thousand times it, by the law of chi square."""
    psd = document["channels"][0]["curves"]["psd"]
    value = psd["density"][0] = 1e-6 * psd["model"][0]
    for ends, part in zip(psd["band_95"], (0.975, 0.025), strict=True):
        ends[0] = ordinates * value / chi2.ppf(part, ordinates)
    bottom = figure(document["channels"][0]).axes[1].get_ylim()[0]
    assert (bottom < value) == shown


def test_shares_have_a_panel_a_term_and_a_triangle_where_one_stands_out(document):
    channel = document["channels"][0]
    channel["influence"]["share"]["B"] = [-0.1, *[1.1 / 19] * 19]
    panels = draw_shares(channel).axes
    assert [texts(axes) for axes in panels] == [["N"], ["B"], ["K"]]
    assert panels[-1].get_xlabel() == "time in the recording [min]"
    assert panels[1].get_ylim()[0] < -10
    triangles = [np.asarray(axes.lines[-1].get_xdata()) for axes in panels]
    assert [len(marks) for marks in triangles] == [0, 0, 1]
    assert triangles[2][0] == pytest.approx(13.5 * 3)
    bars = panels[2].patches
    assert bars[13].get_height() == pytest.approx(50.0)
    assert bars[13].get_facecolor() != bars[12].get_facecolor()


@pytest.mark.parametrize(("duration", "unit"), [(90.0, "s"), (599.0, "s"), (72000.0, "h")])
def test_shares_are_against_time_in_a_handy_unit(document, duration, unit):
    channel = document["channels"][0]
    channel["influence"]["time_s"] = np.linspace(0, duration, 21).tolist()
    assert draw_shares(channel).axes[-1].get_xlabel().endswith(f"[{unit}]")


@pytest.mark.parametrize("warmest", [23.86, 24.92, 25.2, 31.0, 52.0])
def test_temperatures_along_the_axes_are_apart(document, warmest):
    celsius = np.linspace(23.73, warmest, 9)
    channel = document["channels"][0]
    courses = {"time_s": 60.0 * np.arange(9), "residual": celsius, "effect": celsius}
    channel["temperature"] = {
        "slow": {"temperature_degC": celsius, **{k: list(v) for k, v in courses.items()}},
        "curve": {"temperature_degC": celsius, "effect": celsius, "band_95": [celsius, celsius]},
    }
    axes = draw_temperature(channel).axes[0]
    axes.figure.canvas.draw()
    low, high = axes.get_xlim()
    labels = axes.get_xticklabels()
    shown = [each.get_window_extent() for each in labels if low <= each.get_position()[0] <= high]
    assert len(shown) > 1
    # By the width of one, so that no two are read as one.
    assert all(other.x0 - one.x1 > one.width for one, other in pairwise(shown))
