"""The pages in a browser, as a reader has them: nothing here looks at how they are made.

Both pages are opened once, with names in them that would do harm; a test leaves them as found.
"""

import copy
import re
import shutil

import pytest
from explanation_documents import make_explanation

from allanfit.report import write_explanation, write_page

HOSTILE = (
    "<img src=x onerror=alert(1)>",
    "</script><script>alert(2)</script>",
    "%{x} $a$ <a href='javascript:alert(3)'>b</a>\u2028&lt;b&gt;",
)
WORDS = " ".join(HOSTILE)
SHEET_LINE = {
    "words": "noise density",
    "coefficient": "N",
    "as": "one_sided_density",
    "bound": "typical",
    "unit": "°/s/√Hz",
    "stated": 0.008,
    "measured": 0.00707,
    "interval_95": [0.00706, 0.00708],
    "resolved": True,
    "from": "posterior",
    "probability": 0.9999,
    "verdict": "met",
    "verdict_as_coefficient": "missed",
}


@pytest.fixture(scope="module")
def browser():
    sync_api = pytest.importorskip("playwright.sync_api", reason="the browser is not needed else")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("there is no Chromium on this machine")
    with sync_api.sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium)
        yield running
        running.close()


@pytest.fixture(scope="module")
def fit_file(example, tmp_path_factory):
    document = copy.deepcopy({**example, "channels": example["channels"][:1]})
    document |= {"recording": WORDS, "findings": [WORDS]}
    (channel,) = document["channels"]
    channel |= {"channel": WORDS, "unit": WORDS, "findings": [WORDS]}
    channel["coefficients"]["B"]["name"] = WORDS
    sheet = {"file": "sheet.yaml", "sensor": WORDS, "source": None}
    channel["datasheet"] = {**sheet, "lines": [{**SHEET_LINE, "words": WORDS}, SHEET_LINE]}
    target = tmp_path_factory.mktemp("pages") / "fit.html"
    write_page(document, target)
    return target


@pytest.fixture(scope="module")
def explain_file(example, tmp_path_factory):
    found = make_explanation(example)
    channel = found["channels"][0] | {"channel": WORDS, "unit": WORDS}
    for kind in ("allan", "psd"):
        channel["curves"][kind]["effects"][WORDS] = channel["curves"][kind]["model_after"]
    target = tmp_path_factory.mktemp("pages") / "explain.html"
    write_explanation({**found, "channels": [channel]}, target)
    return target


@pytest.fixture(scope="module")
def light_file(fit_file):
    """The page of the fit without plotly, for what holds before it runs."""
    light = fit_file.with_name("light.html")
    text = fit_file.read_text("utf-8")
    light.write_text(re.sub(r'(<script type="text/plain"[^>]*>)[^<]*', r"\1", text), "utf-8")
    return light


@pytest.fixture(scope="module")
def tabs(browser):
    """Opened pages by file, and what went wrong or was asked of a network."""
    pages, trouble = {}, []

    def open_file(path):
        if path not in pages:
            page = pages[path] = browser.new_page(viewport={"width": 1280, "height": 900})
            page.on("console", lambda message: trouble.append(message.text))
            page.on("pageerror", lambda error: trouble.append(str(error)))
            page.on("dialog", lambda dialog: (trouble.append(dialog.message), dialog.dismiss()))
            page.on("request", lambda request: trouble.append(request.url))
            page.goto(path.as_uri())
            trouble.remove(path.as_uri())
            page.locator(".interactive").first.scroll_into_view_if_needed()
            page.locator(".live .legend").nth(1).wait_for()
        return pages[path]

    yield open_file, trouble
    for page in pages.values():
        page.close()


@pytest.fixture
def opened(tabs):
    """Open a file, in which nothing may go wrong."""
    open_file, trouble = tabs
    yield open_file
    assert trouble == []


def lines(page, figure=0):
    """The names in the legend of a figure whose lines are shown."""
    return page.evaluate(
        "at => document.querySelectorAll('.live')[at].data"
        ".filter(t => t.showlegend !== false && t.visible !== 'legendonly').map(t => t.name)",
        figure,
    )


def seen_paths(page):
    return page.locator(".live").first.locator(".trace").count()


def wait_until(page, condition):
    """As `wait_for_function`, which evaluates strings, as no script of these pages may."""
    page.evaluate(
        "() => new Promise((met, late) => {"
        f"const look = () => ({condition}) ? met() : requestAnimationFrame(look);"
        "setTimeout(() => late(new Error('waited in vain')), 20000); look(); })"
    )


def press_legend(page, name, paths):
    """Press an entry and wait until as many paths are drawn."""
    page.locator(".live").first.locator(".legend .traces").filter(has_text=name).locator(
        ".legendtoggle"
    ).click()
    wait_until(
        page, f"document.querySelectorAll('.live')[0].querySelectorAll('.trace').length === {paths}"
    )


def under_pointer(page):
    box = page.locator(".live .nsewdrag").first.bounding_box()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.4 * box["height"])
    hover = page.locator(".live .hoverlayer .legend").first
    hover.wait_for()
    return hover.text_content()


def test_a_press_on_the_legend_hides_a_term_in_both_figures(opened, fit_file):
    page = opened(fit_file)
    before = seen_paths(page)
    assert "K  rate random walk" in lines(page)
    press_legend(page, "K  rate random walk", before - 2)  # the line and its letter
    assert lines(page) == lines(page, 1)
    assert "K  rate random walk" not in lines(page)
    press_legend(page, "K  rate random walk", before)
    assert "K  rate random walk" in lines(page)


def test_the_pointer_reads_values_and_intervals(opened, fit_file, example):
    text = under_pointer(opened(fit_file))
    number = r"(\d[\d.e-]*\d)"
    found = re.search(
        rf"τ \[s\]: {number}data {number} \[{number}, {number}\]residual.*K {number}", text
    )
    assert found, text
    tau, value, low, high, walk = map(float, found.groups())
    curve = example["channels"][0]["curves"]["allan"]
    at = min(range(len(curve["tau_s"])), key=lambda i: abs(curve["tau_s"][i] - tau))
    bands = curve["band_95"]
    truth = (curve["tau_s"][at], curve["deviation"][at], bands[0][at], bands[1][at])
    assert (tau, value, low, high) == pytest.approx(truth, rel=1e-3)
    assert walk == pytest.approx(1e-4 * (truth[0] / 3) ** 0.5, rel=1e-3)


@pytest.mark.parametrize("axis", ["xaxis", "yaxis"])
def test_axes_are_linear_or_logarithmic(opened, fit_file, axis):
    page = opened(fit_file)
    look = "name => [...document.querySelectorAll('.drawn .live')].map(p => p._fullLayout[name]"
    first = page.evaluate(f"{look}.range)", axis)
    for kind in ("linear", "log"):
        page.locator(f"button[data-axis={axis}][data-type={kind}]").first.click()
        assert page.evaluate(f"{look}.type)", axis) == [kind, kind]
        pressed = page.locator(f"button[data-axis={axis}][aria-pressed=true]").first
        assert pressed.get_attribute("data-type") == kind
    assert page.evaluate(f"{look}.range)", axis) == first


def test_before_and_after(opened, explain_file):
    page = opened(explain_file)
    both = lines(page)
    assert {"five terms", "better model", "Gauss-Markov"} < set(both)
    page.locator("[data-models='before']").click()
    assert lines(page) == lines(page, 1) == ["five terms", "recording, 95 % interval"]
    page.locator("[data-models='after']").click()
    assert "five terms" not in lines(page)
    assert {"better model", "sinusoid"} < set(lines(page))
    page.locator("[data-models='before after']").click()
    assert lines(page) == both
    assert "recording / better model" in under_pointer(page)


def test_hostile_words_do_nothing_and_stay_as_they_are(opened, fit_file, explain_file):
    page = opened(fit_file)
    assert HOSTILE[0] in page.locator(".live .legend").first.text_content()
    assert HOSTILE[1] in page.locator(".live .ytitle").first.text_content()
    under_pointer(page)
    assert page.locator(".live a, img").count() == 0
    page = opened(explain_file)
    text = under_pointer(page)
    assert all(each.replace("\u2028", "\ufffd") in text for each in HOSTILE)
    assert page.locator(".live a, img").count() == 0


def test_no_button_sends_a_figure_away(opened, fit_file):
    page = opened(fit_file)
    titles = page.locator(".live .modebar-btn").evaluate_all("all => all.map(b => b.dataset.title)")
    assert len(titles) == 12
    assert not [title for title in titles if "loud" in title or "link" in title.lower()]


@pytest.mark.parametrize(
    ("what", "instead"),
    [
        (r'(.*<script type="application/json">)', r"\1 this is no figure "),
        (r'(.*)<div class="live"[^>]*>.*?</div>', r"\1"),
    ],
    ids=["fails", "has no live twin"],
)
def test_a_figure_that_is_not_drawn_keeps_its_still_one(browser, fit_file, tmp_path, what, instead):
    text = fit_file.read_text("utf-8")
    # The last of the two, so that the first is drawn.
    broken, changes = re.subn(what, instead, text, count=1, flags=re.DOTALL)
    assert changes == 1
    target = tmp_path / "broken.html"
    target.write_text(broken, "utf-8")
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.goto(target.as_uri())
    page.locator(".interactive").first.scroll_into_view_if_needed()
    page.locator(".live .legend").first.wait_for()
    figures = page.locator(".interactive figure")
    still = [figures.nth(k).locator(".still").is_visible() for k in range(2)]
    assert still == [False, True]
    assert figures.locator(".live").first.is_visible()
    page.locator(".switches button[data-axis=xaxis][data-type=linear]").first.click()
    wait_until(page, "document.querySelector('.live').layout.xaxis.type === 'linear'")
    page.close()


def test_print_has_the_drawn_figures(opened, fit_file):
    page = opened(fit_file)
    still, live = page.locator(".drawn .still").first, page.locator(".drawn .live").first
    assert (still.is_visible(), live.is_visible()) == (False, True)
    page.emulate_media(media="print")
    assert (still.is_visible(), live.is_visible()) == (True, False)
    assert not page.locator(".switches").first.is_visible()
    page.emulate_media(media="screen")


@pytest.mark.parametrize("width", [390, 1280])
def test_the_page_fits_its_width(opened, fit_file, explain_file, width):
    for path in (fit_file, explain_file):
        page = opened(path)
        page.set_viewport_size({"width": width, "height": 900})
        wait_until(
            page,
            "[...document.querySelectorAll('.live')]"
            ".every(plot => Math.abs(plot._fullLayout.width - plot.clientWidth) <= 1)",
        )
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert page.evaluate(
            "[...document.querySelectorAll('nav, table, h3, p, dl, .live')]"
            ".every(e => e.scrollWidth <= e.clientWidth + 1)"
        )


def test_without_scripts_the_drawn_figures_stand(browser, light_file):
    page = browser.new_page(java_script_enabled=False)
    page.goto(light_file.as_uri())
    assert page.locator(".still svg").first.is_visible()
    assert not page.locator(".switches").first.is_visible()
    page.close()


def test_a_script_that_crept_in_would_not_run(browser, light_file, tmp_path):
    crept = "<main><script>document.title = 'crept in'</script><img src=x onerror=alert(1)>"
    file = tmp_path / "crept.html"
    file.write_text(light_file.read_text("utf-8").replace("<main>", crept), "utf-8")
    page = browser.new_page()
    page.goto(file.as_uri())
    assert page.title().startswith(HOSTILE[0])
    # Without the policy it would have.
    file.write_text(f"<title>t</title>{crept}", "utf-8")
    page.on("dialog", lambda dialog: dialog.dismiss())
    page.goto(file.as_uri())
    assert page.title() == "crept in"
    page.close()
