"""The README's Python runs, and prints what the README says it prints."""

import io
import re
from contextlib import redirect_stdout
from pathlib import Path

import pytest

import allanfit

ROOT = Path(__file__).parents[1]


def test_python_of_the_readme_prints_its_output():
    text = (ROOT / "README.md").read_text()
    code, output = re.findall(r"```python\n(.*?)```.*?```text\n(.*?)```", text, re.DOTALL)[0]
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile(code, "README.md", "exec"), {})
    # Draws differ a little between processors, so numbers are compared to 10 %.
    number = re.compile(r"\d+\.\d+|\d+")
    assert number.sub("#", printed.getvalue()) == number.sub("#", output)
    shown, made = (
        [float(n) for n in number.findall(text)] for text in (output, printed.getvalue())
    )
    assert made == pytest.approx(shown, rel=0.1)


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
