import re
from html.parser import HTMLParser

import pytest

from allanfit.report import ReportError, write_page

VOID = {"meta", "br", "img", "input", "link", "hr"}


class Page(HTMLParser):
    """Tags, attributes and text of a page; fails when tags do not pair."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.open, self.tags, self.ids, self.words = [], [], [], []
        self.feed(source)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in {"style", "script"}:
            self.words.append(data)


# Figures as data, plotly and what starts it.
OURS = {"application/json", "text/plain", None}


def scripts(source: str) -> set[str | None]:
    """The kinds of the scripts of a page, of which one is a program."""
    kinds = [attributes.get("type") for tag, attributes in Page(source).tags if tag == "script"]
    assert kinds.count(None) == 1
    assert source.count("<script") == len(kinds)
    return set(kinds)


@pytest.fixture(scope="module")
def source(example, tmp_path_factory) -> str:
    target = tmp_path_factory.mktemp("page") / "fit.html"
    write_page(example, target)
    return target.read_text("utf-8")


def test_the_page_is_whole(source):
    page = Page(source)
    text = " ".join(" ".join(page.words).split())
    assert len(page.ids) == len(set(page.ids))
    assert sum(tag == "svg" for tag, _ in page.tags) == 7
    for fact in (
        "0.30000 [0.29928, 0.30072] deg/√h",
        "8.727e-5 [8.706e-5, 8.748e-5] rad/s/√Hz",
        "resolved, 0.01 s to 49 s",
        "< 0.036 arcsec",
        "Slope reading",
        "0.00163",
        "no such slope",
        "A bar is what 3 min of the recording adds",
        "Dark bars under a triangle stand out",
        "the five terms agree with both curves (p = 0.41)",
        "R-hat at most 1.007",
        "record 6.2 h more (7.2 h in all)",
        "The fit did not converge: the least squares stopped after 200 steps",
        "The code width is 0.8 of the noise; see `output_rounding`.",
        "allanfit 0.1.0, checksum sha256:3f1c9a",
    ):
        assert fact in text
    assert len(re.findall("<li>(?=[APRB])", source[source.index("How to read") :])) == 5


def test_a_document_of_an_earlier_version_has_no_shares_and_no_slopes(document, capsys):
    document["channels"] = document["channels"][1:2]
    write_page(document, "-")
    page = capsys.readouterr().out
    assert 'class="slope"' not in page
    assert "figcaption>" not in page


def test_shares_that_chance_explains_are_said_to_be_so(document, capsys):
    document["channels"] = [channel] = document["channels"][:1]
    channel["influence"]["stands_out"]["K"] = [False] * 20
    write_page(document, "-")
    assert "No stretch stands out by more than chance." in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("empty", [None, {"time_s": [0.0, 1.0], "share": {}}])
def test_a_fit_without_shares_has_no_such_figure(document, capsys, empty):
    document["channels"] = document["channels"][:1]
    document["channels"][0]["influence"] = empty
    write_page(document, "-")
    assert "figcaption>" not in capsys.readouterr().out


def test_names_of_the_user_stay_text(source):
    page = Page(source)
    assert "img" not in {tag for tag, _ in page.tags}
    assert scripts(source) == OURS
    assert "&lt;script&gt;alert(&#39;$x_1$&#39;)&lt;/script&gt;" in source
    assert "bench &lt;b&gt;3&lt;/b&gt;.csv" in source
    assert "&lt;img src=x&gt;" in source


def test_a_hostile_unit_stays_text(document, tmp_path):
    document["channels"] = document["channels"][:1]
    document["channels"][0]["unit"] = "--><script>x</script>$"
    write_page(document, tmp_path / "fit.html")
    assert scripts((tmp_path / "fit.html").read_text("utf-8")) == OURS


def test_a_page_without_scripts_is_small(document, tmp_path):
    document["channels"] = document["channels"][1:2]
    for name, interactive in (("live", True), ("still", False)):
        write_page(document, tmp_path / name, interactive=interactive)
    still = (tmp_path / "still").read_text("utf-8")
    assert "<script" not in still.replace("&lt;script", "")
    assert "script-src" not in still
    added = (tmp_path / "live").stat().st_size - len(still.encode())
    assert 1.9e6 < added < 2.3e6


def test_the_page_needs_nothing_from_elsewhere(source):
    page = Page(source)
    links = [
        value
        for tag, attributes in page.tags
        for name, value in attributes.items()
        if name in {"href", "src", "xlink:href", "action", "data"}
    ]
    assert links
    assert all(link.startswith("#") for link in links)
    assert "@import" not in source
    assert re.findall(r"url\((?!#)", source) == []


def test_two_pages_of_one_document_are_equal(document, source, tmp_path):
    write_page(document, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text("utf-8") == source


def test_one_channel_needs_no_overview(document, tmp_path, capsys):
    document["channels"] = document["channels"][2:]
    write_page(document, "-")
    page = capsys.readouterr().out
    assert "<nav" not in page
    assert "In SI" not in page


def test_a_page_that_cannot_be_written_says_so(document, tmp_path):
    document["channels"] = []
    with pytest.raises(ReportError, match="Cannot write"):
        write_page(document, tmp_path / "nowhere" / "fit.html")
