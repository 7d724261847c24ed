"""`allanfit explain` with the analysis replaced: what it passes on and what it delivers."""

import json
import sys
from types import ModuleType

import numpy as np
import pytest
from explanation_documents import make_explanation

from allanfit.cli import main


class Explained:
    def __init__(self, document):
        self.document = document

    def to_dict(self):
        return self.document


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "gyro.npz"
    samples = np.random.default_rng(0).standard_normal(600)
    np.savez(path, gyro_x=samples, rate_hz=50.0, units='{"gyro_x": "deg/s"}')
    return path


@pytest.fixture
def analysis(monkeypatch, document):
    """The options of each call; what it raises if told to."""
    seen: dict = {"fail": None}

    def explain_recording(recording, *, announce, done, **options):
        if seen["fail"] is not None:
            raise seen["fail"]
        for channel in recording.channels:
            announce(channel.name)
            done()
        seen["recording"], seen["options"] = recording, options
        return Explained(make_explanation(document))

    stage = ModuleType("allanfit.explain")
    monkeypatch.setattr(stage, "explain_recording", explain_recording, raising=False)
    monkeypatch.setitem(sys.modules, "allanfit.explain", stage)
    return seen


def test_text_json_and_page(recording, analysis, tmp_path, capsys):
    target, page = tmp_path / "explain.json", tmp_path / "explain.html"
    arguments = ["explain", str(recording), "--json", str(target), "--report", str(page)]
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert "The five-term model leaves out" in out
    assert err == f"\nPage with figures: {page}\n"
    assert json.loads(target.read_text())["schema"] == "allanfit.explain/1"
    assert "<svg" in page.read_text("utf-8")
    assert analysis["options"] == {
        "simulation": None,
        "sampling": "point",
        "seed": 0,
        "posterior": True,
    }


def test_json_to_stdout_is_json_alone(recording, analysis, capsys):
    assert main(["explain", str(recording), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["channels"][0]["verdict"] == "explained"
    assert err == ""


def test_options_are_passed_on(recording, analysis, tmp_path, capsys):
    simulation = tmp_path / "datasheet.yaml"
    simulation.write_text("unit: deg/s\nN: 0.005\n")
    options = ["--simulation", str(simulation), "--no-posterior", "--sampling", "averaged"]
    assert main(["explain", str(recording), *options, "--seed", "3", "--rate", "25"]) == 0
    capsys.readouterr()
    assert analysis["recording"].rate_hz == 25.0
    assert analysis["options"] == {
        "simulation": simulation,
        "sampling": "averaged",
        "seed": 3,
        "posterior": False,
    }


def test_help_names_the_options(capsys):
    assert main(["explain", "--help"]) == 0
    out = capsys.readouterr().out
    for option in ("--simulation", "--rate", "--channel", "--unit", "--json", "--report", "--seed"):
        assert option in out
    assert main(["--help"]) == 0
    assert "explain" in capsys.readouterr().out


def test_wrong_usage_exits_with_two(capsys):
    assert main(["explain"]) == 2
    assert main(["explain", "x.npz", "--sampling", "often"]) == 2
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--simulation", "none.yaml"], "There is no file 'none.yaml' to compare with"),
        (["--report", "nowhere/explain.html"], "make it first"),
        (["--channel", "gyro_q"], "gyro_q"),
    ],
)
def test_errors_are_one_line(recording, analysis, capsys, arguments, message):
    assert main(["explain", str(recording), *arguments]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.startswith("allanfit: ")
    assert len(err.splitlines()) == 1


def test_a_failing_analysis_is_one_line_and_leaves_no_file(recording, analysis, tmp_path, capsys):
    analysis["fail"] = ValueError("too few\nsamples")
    assert main(["explain", str(recording), "--json", str(tmp_path / "explain.json")]) == 1
    assert capsys.readouterr().err == "allanfit: too few samples\n"
    assert [path.name for path in tmp_path.iterdir()] == ["gyro.npz"]
