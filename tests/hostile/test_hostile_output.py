"""Results that have nowhere to go, and names that would do harm where they go."""

import io
import json
import os
import subprocess
import sys

import numpy as np
import pytest
import yaml
from bad_coefficients import fit_document
from bad_recordings import TABLE
from rich.console import Console

from allanfit.cli import _progress as progress
from allanfit.cli import main
from allanfit.recording import RecordingError, load, save

#: What a name may try: the terminal, a page, YAML, a shell, a path, a line of its own.
EVIL = (
    "\x1b[2J\x1b[31mred",
    "two\nlines: 1\r",
    "<script>alert(1)</script>",
    '"}\n- channel: injected\n  N: 9',
    "N: 1 # comment",
    "../../../outside",
    "\u202egnp.exe\u2066",
    "[/red][bold]",
    "$(touch ran) `touch ran`",
    "' OR 1=1 --%s{0}%n",
    "{{ 7 * 7 }}",
    "\u2028line\u0085separators",
)


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "gyro.csv"
    path.write_text(TABLE)
    return path


@pytest.fixture
def commands(tmp_path, recording):
    """Each command up to the name of its output, none of which may come as far as its work."""
    fit = tmp_path / "fit.json"
    fit.write_text(json.dumps(fit_document("gyro_x", "accel_x")))
    coefficients = tmp_path / "c.yaml"
    coefficients.write_text("N: 1\n")
    table = tmp_path / "table.csv"
    table.write_text("rate,cw,ccw\n1,1,1\n")
    return {
        "fit": (recording, "fit", str(recording), "--rate", "10", "--json"),
        "page": (recording, "fit", str(recording), "--rate", "10", "--report"),
        "explain": (recording, "explain", str(recording), "--rate", "10", "--json"),
        "simulate": (coefficients, "simulate", str(coefficients), "--duration", "1", "--rate", "9",
                     "--output"),
        "plan": (coefficients, "plan", str(coefficients), "--rate", "9", "--want", "N=1%",
                 "--json"),
        "export": (fit, "export", str(fit), "--format", "yaml", "--output"),
        "rate-table": (table, "calibrate", "rate-table", str(table), "--unit", "rpm", "--json"),
    }  # fmt: skip


NAMES = ("fit", "page", "explain", "simulate", "plan", "export", "rate-table")


@pytest.mark.parametrize("command", NAMES)
def test_targets_that_cannot_be(command, commands, tmp_path, refused):
    source, *arguments = commands[command]
    (tmp_path / "folder").mkdir()
    link = tmp_path / "link"
    link.symlink_to(source)
    assert "is a folder: give the name of a file" in refused(*arguments, str(tmp_path / "folder"))
    assert "is what is read" in refused(*arguments, str(source))
    assert "is what is read" in refused(*arguments, str(link))
    assert "make it first" in refused(*arguments, str(tmp_path / "none" / "out"))
    assert "make it first" in refused(*arguments, str(source / "out"))
    # Where not even root may make a file.
    assert "Cannot write /proc/out.npz" in refused(*arguments, "/proc/out.npz")
    assert "File name too long" in refused(*arguments, "o" * 300)


def test_two_results_of_one_name(recording, refused):
    line = refused("fit", str(recording), "--rate", "9", "--json", "o", "--report", "./o")
    assert "written twice" in line


@pytest.mark.parametrize("command", ["simulate", "plan", "export"])
def test_a_disk_that_is_full(command, commands, refused):
    _, *arguments = commands[command]
    target = "/dev/full"
    line = refused(*arguments, target)
    assert "No space left" in line or "ends in .npz" in line


def test_a_pipe_that_is_closed_ends_quietly(commands):
    _, *arguments = commands["export"]
    code = "import sys; from allanfit.cli import run; run()"
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments, "-"],
        stdout=writing, stderr=subprocess.PIPE, text=True, check=False, timeout=120,
    )  # fmt: skip
    os.close(writing)
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode in (0, 1, 120, 141)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--duration", "nan", "--rate", "100"), "must be positive"),
        (("--duration", "inf", "--rate", "100"), "must be positive"),
        (("--duration", "-1", "--rate", "100"), "must be positive"),
        (("--duration", "1", "--rate", "nan"), "must be positive"),
        (("--duration", "1", "--rate", "inf"), "must be positive"),
        (("--duration", "1e300", "--rate", "1e300"), "must be positive"),
        (("--duration", "1e9", "--rate", "1e9"), "at most"),
        (("--duration", "0.001", "--rate", "100"), "2 are needed"),
    ],
)
def test_records_that_cannot_be(options, message, tmp_path, refused):
    path = tmp_path / "c.yaml"
    path.write_text("N: 1\n")
    assert message in refused("simulate", str(path), *options, "--output", "o.npz")


@pytest.mark.parametrize("rate", ["nan", "inf", "-1", "0", "1e308"])
def test_plans_that_cannot_be(rate, tmp_path, refused):
    path = tmp_path / "c.yaml"
    path.write_text("N: 1\n")
    assert "rate" in refused("plan", str(path), "--rate", rate, "--want", "N=1%")


@pytest.mark.parametrize("arguments", [
    ("fit", "a.csv", "--rate", "fast"), ("fit", "a.csv", "--seed", "-1"), ("fit",),
    ("fit", "a.csv", "--sampling", "\x1b[2J"), ("simulate", "c.yaml"), ("explode",),
    ("plan", "c.yaml", "--rate", "1e", "--want", "N"), ("fleet", "a"),
])  # fmt: skip
def test_wrong_usage_is_2(arguments, capsys):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" not in err
    assert "\x1b[2J" not in err


@pytest.mark.parametrize("name", EVIL)
def test_names_in_messages_do_not_steer_the_terminal(name, tmp_path, refused):
    path = tmp_path / "a.npz"
    save(path.with_suffix(".csv"), {"x": np.ones(400)}, {}, 100.0)
    np.savez(path, x=np.ones(400), units=json.dumps({"x": name}))
    refused("fit", str(path), "--rate", "100")
    refused("fit", str(path.with_suffix(".csv")), "--channel", name)
    refused("fit", str(path.with_suffix(".csv")), "--unit", name)
    refused("fit", f"{name}.csv")


@pytest.mark.parametrize("name", EVIL)
def test_names_in_exports_stay_names(name, tmp_path, capsys):
    path, target = tmp_path / "fit.json", tmp_path / "out"
    document = fit_document(name, "accel_x")
    document["recording"] = name
    path.write_text(json.dumps(document))
    for format_ in ("yaml", "ros", "kalibr", "kalman", "matlab"):
        options = ("--walk", "limit") if format_ in ("ros", "kalibr") else ()
        assert (
            main(["export", str(path), "--format", format_, "--output", str(target), *options]) == 0
        )
        assert capsys.readouterr().err.replace("\n", "").isprintable()
        text = target.read_text()
        assert text.replace("\n", "").isprintable()
        if format_ == "matlab":
            code = [line for line in text.splitlines() if not line.lstrip().startswith("%")]
            assert not any("injected" in line or "touch" in line for line in code)
        elif format_ == "kalman":
            assert [each["channel"] for each in json.loads(text)["channels"]] == [name, "accel_x"]
        else:
            assert "injected" not in str(list(yaml.safe_load(text)))
        if format_ == "yaml":
            found = yaml.safe_load(text)["channels"]
            assert [each["channel"] for each in found] == [name, "accel_x"]
            assert len(found[0]) == 8 - (not found[0].get("effects"))
    assert sorted(each.name for each in tmp_path.iterdir()) == ["fit.json", "out"]


@pytest.mark.parametrize("name", EVIL)
def test_names_in_recordings_come_back_or_are_refused(name, tmp_path):
    series = np.random.default_rng(1).standard_normal(300)
    for suffix in (".npz", ".csv"):
        path = tmp_path / f"a{suffix}"
        try:
            save(path, {name: series}, {name: "deg/s"}, 100.0)
            found = load(path)
        except RecordingError:
            continue
        np.testing.assert_allclose(found.channels[0].samples / found.channels[0].factor, series)
    assert {each.name for each in tmp_path.iterdir()} <= {"a.npz", "a.csv"}


@pytest.mark.parametrize("name", ["file", "rate_hz", "units", "../x", "a\\..\\x"])
def test_names_that_an_archive_keeps_for_itself(name, tmp_path):
    with pytest.raises(RecordingError, match="cannot hold a channel named"):
        save(tmp_path / "a.npz", {name: np.arange(9.0)}, {}, 1.0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", EVIL)
def test_names_in_progress_bars(name, monkeypatch):
    shown = io.StringIO()
    monkeypatch.setattr(
        progress, "Console", lambda **_: Console(file=shown, force_terminal=True, width=200)
    )
    with progress.channel_by_channel("fitting", 1) as (announce, done):
        announce(name)
        done()
    assert "\x1b[2J" not in shown.getvalue()
    assert "\u202e" not in shown.getvalue()
