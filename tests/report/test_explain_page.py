import sys
from itertools import pairwise

import numpy as np
import pytest
from explanation_documents import make_explanation, mismatch
from test_report_page import OURS, Page, scripts

from allanfit.report import ReportError, write_explanation
from allanfit.report._explain_line_panel import draw_line
from allanfit.report._explain_panels import draw_curve, load_explained
from allanfit.report._explain_time_panel import draw_time, has_time


@pytest.fixture
def explanation(document):
    return make_explanation(document)


@pytest.fixture(scope="module")
def source(example, tmp_path_factory) -> str:
    target = tmp_path_factory.mktemp("page") / "explain.html"
    write_explanation(make_explanation(example), target)
    assert [path.name for path in target.parent.iterdir()] == ["explain.html"]
    return target.read_text("utf-8")


def written(explanation, capsys) -> str:
    write_explanation(explanation, "-")
    return capsys.readouterr().out


def legend(axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_the_page_is_whole(source):
    page = Page(source)
    text = " ".join(" ".join(page.words).split())
    assert len(page.ids) == len(set(page.ids))
    # Two curves a channel, two lines, one course in time.
    assert sum(tag == "svg" for tag, _ in page.tags) == 11
    assert sum(tag == "details" for tag, _ in page.tags) == 1
    for fact in (
        "(Gauss-Markov) and a sinusoid; with them it describes the recording.",
        "differs from them by as much with probability 4e-7.",
        "1. 13.019 Hz to 13.022 Hz spectrum × 31 p < 1e-12 A line at 13.02 Hz",
        "Exponentially correlated noise (Gauss-Markov) 97 %",
        "sigma 0.00302 [0.00290, 0.00314] deg/s 10.87 [10.44, 11.31] deg/h",
        "or random telegraph noise, 2.6 %; to tell them apart: the histogram of 2 s means",
        "better by 247 ± 21, 12 standard errors",
        "0.006550 [0.006534, 0.006566] deg/s/√Hz 0.39300 [0.39206, 0.39394] deg/√h",
        "change -24 % intervals do not overlap",
        "Further tests (2)",
        "Look for a source of vibration at 13.02 Hz",
        "Steps of the mean 83 %",
        "The five-term model agrees with the recording",
        "a smooth bump stands for it in the better model",
        "the better model still differs from the recording",
        "allanfit 0.1.0, checksum sha256:3f1c9a",
    ):
        assert fact in text


def test_strings_of_the_user_stay_text(source):
    page = Page(source)
    assert not {tag for tag, _ in page.tags} & {"img", "i"}
    assert scripts(source) == OURS
    assert "&lt;script&gt;alert(&#39;$x_1$&#39;)&lt;/script&gt;" in source
    assert "&lt;img src=x&gt;" in source
    assert "Send &lt;b&gt;this&lt;/b&gt; page" in source


def test_hostile_words_in_every_place_stay_text(explanation, capsys):
    bad = "--><script>x</script>$\\broken{$"
    channel = explanation["channels"][1]
    explanation["channels"] = [channel]
    channel |= {"unit": bad, "channel": bad, "advice": [bad], "findings": [bad]}
    channel["effects"][0] |= {"name": bad, "sentence": bad}
    channel["effects"][0]["alternatives"][0] |= {"name": bad, "told_apart_by": bad}
    channel["effects"][0]["parameters"] = {bad: {"value": 1.0, "unit": bad, "intervals": {}}}
    channel["mismatch"][0] |= {"sentence": bad, "cause": bad}
    channel["witnesses"] = [{"name": bad, "statistic": None, "p_value": None, "sentence": bad}]
    channel["curves"]["psd"]["effects"] = {bad: channel["curves"]["psd"]["density"]}
    assert scripts(written(explanation, capsys)) == OURS


def test_the_page_needs_nothing_from_elsewhere(source):
    names = {"href", "src", "xlink:href", "action", "data"}
    attributes = [pair for _, each in Page(source).tags for pair in each.items()]
    links = [value for name, value in attributes if name in names]
    assert links
    assert all(link.startswith("#") for link in links)
    assert "@import" not in source


def test_two_pages_of_one_document_are_equal(explanation, source, tmp_path):
    write_explanation(explanation, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text("utf-8") == source


def test_a_consistent_channel_without_curves_of_the_better_model(explanation, capsys):
    channel = explanation["channels"][2]
    explanation["channels"] = [channel]
    for kind in ("allan", "psd"):
        channel["curves"][kind] |= {"model_after": None, "effects": None}
    page = written(explanation, capsys)
    assert "<nav" not in page
    assert "The coefficients" in page
    assert "Where it differs" not in page


@pytest.mark.parametrize("curves", [None, {"allan": None, "psd": None, "time": None, "lines": []}])
def test_a_channel_without_curves_has_empty_figures(explanation, curves, capsys):
    explanation["channels"] = explanation["channels"][2:3]
    explanation["channels"][0]["curves"] = curves
    assert written(explanation, capsys).count("<svg") == 2


def test_a_page_that_cannot_be_written_says_so(explanation, tmp_path):
    explanation["channels"] = []
    with pytest.raises(ReportError, match="Cannot write"):
        write_explanation(explanation, tmp_path / "nowhere" / "explain.html")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("package", ["matplotlib", "jinja2"])
def test_a_page_names_the_install_command(explanation, tmp_path, monkeypatch, package):
    for name in list(sys.modules):
        ours = package == "matplotlib" and ("_panel" in name or "_interactive" in name)
        if name.partition(".")[0] == package or ours:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    explanation["channels"] = explanation["channels"][:1]
    with pytest.raises(ReportError, match=rf"{package}.*`pip install allanfit\[report\]`"):
        write_explanation(explanation, tmp_path / "explain.html")
    assert list(tmp_path.iterdir()) == []


def test_a_curve_has_both_models_its_effects_and_shaded_bands(explanation):
    upper, lower = draw_curve(explanation["channels"][0], "psd").axes
    assert legend(upper) == [
        "recording, 95 % interval",
        "five terms",
        "better model",
        "Gauss-Markov",
        "sinusoid",
    ]
    assert lower.get_ylabel() == "recording / model"
    assert [text.get_text() for text in upper.texts] == ["1", "2"]
    line, hump = upper.patches
    # A line is shaded wide enough to be seen.
    assert line.get_width() == pytest.approx(0.012)
    assert hump.get_width() > 0.1
    assert len(lower.patches) == 2


@pytest.mark.parametrize(("share", "named"), [(0.06, True), (0.02, False)])
def test_a_weak_effect_is_in_sight(explanation, share, named):
    """Of the lowest density a sixteenth, which is as much as a line in one bin has; or less."""
    channel = explanation["channels"][0]
    curve = channel["curves"]["psd"]
    lowest = min(*curve["density"], *curve["model_before"], *curve["model_after"])
    size = len(curve["density"])
    curve["effects"]["resonance"] = [0.0] * (size - 1) + [share * lowest]
    upper = draw_curve(channel, "psd").axes[0]
    assert ("resonance" in legend(upper)) == named
    assert (upper.get_ylim()[0] < share * lowest) == named


@pytest.mark.parametrize(
    "spans",
    [
        # Three lines, two of them close, in a band whose middle has one of them.
        [(4.77, 4.80), (3.56, 42.4), (3.34, 3.345), (12.25, 12.35)],
        [(19.81, 20.11), (20.53, 20.62)],
        [(0.01, 40.0), (0.01, 40.0), (0.01, 40.0)],
        [(0.16 + 1e-4 * k, 0.16005 + 1e-4 * k) for k in range(14)],
    ],
    ids=["lines in a band", "two lines", "one band three times", "many lines"],
)
def test_each_difference_has_its_number_where_it_is(explanation, spans):
    channel = explanation["channels"][0]
    channel["mismatch"] = [mismatch("frequency", *each, 2.0, 1e-9, "") for each in spans]
    sheet = draw_curve(channel, "psd")
    axes = sheet.axes[0]
    numbers = {int(text.get_text()): text for text in axes.texts}
    assert list(numbers) == list(range(1, len(spans) + 1))
    boxes = [text.get_window_extent() for text in axes.texts]
    boxes.sort(key=lambda box: box.x0)
    if len(spans) < 10:
        assert all(one.x1 < other.x0 for one, other in pairwise(boxes))
    # Never farther from one's own than half of all numbers take.
    own = axes.transAxes.inverted()
    ends = {
        n: own.transform(axes.transData.transform([(f, 1.0) for f in each]))[:, 0]
        for n, each in enumerate(spans, start=1)
    }
    room = 0.006 + sum(0.02 + 0.025 * len(str(number)) for number in numbers) / 2
    for number, (low, high) in ends.items():
        x = numbers[number].get_position()[0]
        assert low - room < x < high + room
    if spans[0] == (4.77, 4.80):
        places = {number: text.get_position()[0] for number, text in numbers.items()}
        # That of the band is in the band, and over none of the lines.
        assert ends[2][0] < places[2] < ends[2][1]
        assert min(abs(places[2] - ends[line].mean()) for line in (1, 3, 4)) > 0.015
        assert places[3] < places[1] < places[4]


@pytest.mark.parametrize("kind", ["allan", "psd"])
def test_the_legend_hides_nothing_of_the_recording(explanation, kind):
    for channel in explanation["channels"]:
        upper = draw_curve(channel, kind).axes[0]
        curve = load_explained(channel, kind)
        points = np.column_stack([np.tile(curve.x, 3), [*curve.data, *curve.low, *curve.high]])
        assert (
            not upper.get_legend()
            .get_window_extent()
            .count_contains(upper.transData.transform(points))
        )


@pytest.mark.parametrize(("kind", "power"), [("allan", 2), ("psd", 1)])
def test_the_parts_of_one_line_are_one_curve(explanation, kind, power):
    channel = explanation["channels"][0]
    effects = channel["curves"][kind]["effects"]
    size = len(channel["curves"][kind]["model_after"])
    effects["drifting_line"] = [3e-3] * size
    effects["drifting_line 2"] = [4e-3] * (size - 1) + [None]
    channel["effects"].append({**channel["effects"][0], "name": "drifting_line"})
    curve = load_explained(channel, kind)
    # Variances add up, and so do densities.
    assert curve.effects["drifting line"][0] ** power == pytest.approx(3e-3**power + 4e-3**power)
    assert curve.effects["drifting line"][-1] == pytest.approx(3e-3)
    assert "drifting line 2" not in curve.effects
    # Two effects of one name stay two.
    channel["effects"].append(channel["effects"][-1])
    assert {"drifting line", "drifting line 2"} <= set(load_explained(channel, kind).effects)


def test_the_ratio_comes_down_to_the_band(explanation):
    lower = draw_curve(explanation["channels"][0], "psd").axes[1]
    _, before, after = (np.asarray(line.get_ydata()) for line in lower.lines)
    assert before.max() > 4
    assert abs(np.log(after)).max() < abs(np.log(before)).max() + 0.5
    assert abs(after[-8:] - 1).max() < 0.05


def test_a_gross_misfit_leaves_the_ratio_readable(explanation):
    curve = explanation["channels"][0]["curves"]["psd"]
    curve["density"][60] *= 1e6
    lower = draw_curve(explanation["channels"][0], "psd").axes[1]
    assert lower.get_yscale() == "log"
    assert len(lower.get_yticks()) < 10


def test_a_consistent_channel_has_no_better_model(explanation):
    upper = draw_curve(explanation["channels"][2], "allan").axes[0]
    assert legend(upper) == ["recording, 95 % interval", "five terms"]


def test_time_is_drawn_where_something_happens_in_it(explanation):
    assert [has_time(channel) for channel in explanation["channels"]] == [False, True, False, False]
    upper, lower = draw_time(explanation["channels"][1]).axes
    assert lower.get_xlabel() == "time in the recording [min]"
    assert [text.get_text() for text in upper.texts] == ["1", "2"]
    assert len(upper.patches) == len(lower.patches) == 3
    points, model = (np.asarray(line.get_ydata()) for line in upper.lines)
    assert abs(points.mean()) < 1e-12
    assert np.std(points - model) < 4e-4


@pytest.mark.parametrize(
    ("size", "power"), [(1e-3, "10⁻³ "), (0.03, ""), (1e5, "10⁵ ")], ids=["small", "usual", "large"]
)
def test_a_power_of_ten_stands_beside_the_unit(explanation, size, power):
    """Above the lower axes the frame of the upper one would strike it through."""
    channel = explanation["channels"][1]
    entry = channel["curves"]["time"]
    entry["deviation"] = np.linspace(0.2 * size, 1.5 * size, len(entry["time_s"])).tolist()
    lower = draw_time(channel).axes[1]
    lower.figure.canvas.draw()
    assert lower.get_ylabel() == f"deviation [{power}deg/s]"
    assert lower.yaxis.get_offset_text().get_text() == ""
    factor = size if power else 1.0
    for label in lower.get_yticklabels():
        shown = float(label.get_text().replace("\N{MINUS SIGN}", "-"))
        assert shown * factor == pytest.approx(label.get_position()[1], abs=1e-9 * size)


def test_a_course_without_a_model_shows_the_intervals(explanation):
    channel = explanation["channels"][1]
    channel["curves"]["time"]["model"] = None
    assert len(draw_time(channel).axes[0].lines) == 1


@pytest.mark.parametrize(("width", "unit"), [(1.0, "mHz"), (1000.0, "Hz")])
def test_a_line_is_drawn_against_the_distance_from_it(explanation, width, unit):
    line = explanation["channels"][0]["curves"]["lines"][0]
    line["frequency_hz"] = [13.02 + width * (each - 13.02) for each in line["frequency_hz"]]
    (axes,) = draw_line(line, "deg/s").axes
    assert axes.get_title() == "13.02 Hz"
    assert axes.get_xlabel() == f"frequency less this [{unit}]"
    assert axes.get_ylabel() == "density [(deg/s)²/Hz]"


def test_a_line_has_the_digits_that_its_interval_has(explanation):
    """Half of it is 2.6e-5 Hz, of which two digits are told; the table has the same."""
    channel = explanation["channels"][0]
    line = {**channel["curves"]["lines"][0], "line_hz": 13.0204}
    (axes,) = draw_line(line, "deg/s", channel["effects"]).axes
    assert axes.get_title() == "13.020400 Hz"
    wide = {"value": 13.0204, "unit": "Hz", "intervals": {"0.95": [12.96, 13.08]}}
    channel["effects"][1]["parameters"]["frequency"] = wide
    (axes,) = draw_line(line, "deg/s", channel["effects"]).axes
    assert axes.get_title() == "13.020 Hz"


def test_many_lines_are_not_all_drawn(explanation, capsys):
    channel = explanation["channels"][0]
    explanation["channels"] = [channel]
    channel["curves"]["lines"] = channel["curves"]["lines"][:1] * 14
    page = written(explanation, capsys)
    assert page.count("<svg") == 14
    assert "The JSON holds 2 more lines." in page
