"""The site builds strictly, loads nothing from elsewhere, and leaves out no public name."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import allanfit

ROOT = Path(__file__).parents[2]
PAGES = [*sorted((ROOT / "docs").glob("*.md")), *sorted(ROOT.glob("*.md"))]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocs", reason="the dependency group `docs` is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    # Its banner about its own future is no warning of the build.
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    found = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    return folder


def test_every_page_is_in_the_navigation(site):
    built = {page.stem for page in site.glob("*.html")} - {"404"}
    home = (site / "index.html").read_text()
    assert {page.stem for page in (ROOT / "docs").glob("*.md")} <= built
    assert [name for name in built if f'href="{name}.html"' not in home and name != "index"] == []


def test_pages_load_nothing_from_elsewhere(site):
    loaded = re.compile(r'<(?:script|img|link|iframe)\b[^>]*?(?:src|href)="?(https?:)?//[^">]*')
    for page in site.glob("*.html"):
        assert not loaded.search(page.read_text()), page.name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
        made = page.parent / target
        assert made.exists() or target in ("changelog.md", "contributing.md") or "//" in target, (
            target
        )


def test_public_names_are_documented():
    reference = (ROOT / "docs" / "reference.md").read_text()
    for name in dir(allanfit):
        value = getattr(allanfit, name)
        if not name.startswith("_") and callable(value):
            assert value.__doc__, name
            assert len(value.__doc__.split()) > 5, name
            assert f"::: allanfit.{name}\n" in reference, name
