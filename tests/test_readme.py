"""Python in the README and the page of units runs, and prints what they say it prints."""

import io
import re
from contextlib import redirect_stdout
from pathlib import Path

import pytest

import allanfit

ROOT = Path(__file__).parents[1]


_EXAMPLE = re.compile(r"```python\n((?:(?!```).)*)```\s*```text\n(.*?)```", re.DOTALL)
EXAMPLES = [
    pytest.param(code, output, id=f"{page.name}-{number}")
    for page in (ROOT / "README.md", ROOT / "docs" / "units.md")
    for number, (code, output) in enumerate(_EXAMPLE.findall(page.read_text()))
]


@pytest.mark.parametrize(("code", "output"), EXAMPLES)
def test_python_of_the_docs_prints_its_output(code, output):
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile(code, "docs", "exec"), {})
    number = re.compile(r"\d+\.\d+(?:e-?\d+)?|\d+(?:e-?\d+)?")
    assert number.sub("#", printed.getvalue()) == number.sub("#", output)
    shown, made = (
        [float(n) for n in number.findall(text)] for text in (output, printed.getvalue())
    )
    # Draws differ a little between processors.
    assert made == pytest.approx(shown, rel=0.1 if "seed=" in code else 1e-12)


def test_every_python_of_the_units_page_is_run():
    page = (ROOT / "docs" / "units.md").read_text()
    assert page.count("```python") == len(_EXAMPLE.findall(page)) == 3


@pytest.mark.parametrize("page", [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md"])
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
        assert (page.parent / target).exists(), target


def test_public_names_have_docstrings():
    for name in dir(allanfit):
        value = getattr(allanfit, name)
        if not name.startswith("_") and callable(value):
            assert value.__doc__, name
            assert len(value.__doc__.split()) > 5, name
