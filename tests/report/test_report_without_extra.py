"""The stage without the packages of the extra `report`."""

import sys

import pytest

from allanfit.report import ReportError, figure, format_text, write_json, write_page


@pytest.fixture
def without(monkeypatch):
    """Hide a package, as if it had never been installed."""

    def hide(package: str) -> None:
        for name in list(sys.modules):
            if name.partition(".")[0] == package or name == "allanfit.report._panels":
                monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, package, None)

    return hide


@pytest.mark.parametrize("package", ["matplotlib", "jinja2"])
def test_text_and_json_need_no_extra(document, tmp_path, without, package):
    without(package)
    assert format_text(document)
    write_json(document, tmp_path / "fit.json")


@pytest.mark.parametrize("package", ["matplotlib", "jinja2"])
def test_a_page_names_the_install_command(document, tmp_path, without, package):
    without(package)
    with pytest.raises(ReportError, match=rf"{package}.*`pip install allanfit\[report\]`"):
        write_page(document, tmp_path / "fit.html")
    assert list(tmp_path.iterdir()) == []


def test_a_figure_names_the_install_command(document, without):
    without("matplotlib")
    with pytest.raises(ReportError, match=r"matplotlib.*`pip install allanfit\[report\]`"):
        figure(document["channels"][0])


def test_importing_the_stage_imports_no_extra(tmp_path):
    import subprocess

    code = (
        # pint imports dask where it is installed, and that imports jinja2.
        "import sys; sys.modules['dask'] = None; import allanfit.report; "
        "print({'matplotlib', 'jinja2', 'rich', 'arviz'} & set(sys.modules))"
    )
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert shown.stdout.strip() == "set()"
