"""`--list` and `--topic` on the command line."""

import h5py
import numpy as np
import pytest

from allanfit.cli import main
from allanfit.recording import Topic


@pytest.fixture
def two(tmp_path):
    path = tmp_path / "two.h5"
    samples = np.random.default_rng(1).standard_normal((2, 400))
    with h5py.File(path, "w") as file:
        for group, values, rate_hz in (
            ("imu0", samples[0], 50.0),
            ("imu1", samples[1, :300], 20.0),
        ):
            file[f"{group}/gyro_x"] = values
            file[group].attrs["fs"] = rate_hz
        file["imu0/gyro_x"].attrs["units"] = "deg/s"
    return path


def test_list_says_what_is_inside(two, capsys):
    assert main(["fit", str(two), "--list"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines() == [
        "imu0, 400 samples, 50 Hz",
        "  gyro_x  deg/s",
        "imu1, 300 samples, 20 Hz",
        "  gyro_x  -",
    ]
    assert err == ""


def test_list_sends_no_control_characters_to_the_terminal(monkeypatch, tmp_path, capsys):
    hostile = "a\x1b[31m\n"
    topic = Topic(name=hostile, kind=hostile, samples=1, rate_hz=1.0, units={hostile: hostile})
    monkeypatch.setattr("allanfit.cli.contents", lambda path: (topic,))
    assert main(["fit", str(tmp_path), "--list"]) == 0
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert len(out.splitlines()) == 2


@pytest.mark.parametrize("command", ["fit", "explain"])
def test_several_topics_need_a_choice(command, two, capsys):
    assert main([command, str(two)]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "choose one of imu0 (400 samples), imu1 (300 samples) with --topic" in err
    assert main([command, str(two), "--topic", "imu2"]) == 1
    assert "no topic imu2" in capsys.readouterr().err


def test_list_of_nothing(tmp_path, capsys):
    assert main(["fit", str(tmp_path / "none.mcap"), "--list"]) == 1
    assert "There is no file" in capsys.readouterr().err


@pytest.mark.parametrize("test", [["up-down", 2], ["multi-position", 1]])
def test_calibrate_reads_the_topic_asked_for(test, two, capsys):
    command, files = test
    assert main(["calibrate", command, *[str(two)] * files, "--topic", "imu2"]) == 1
    assert "no topic imu2" in capsys.readouterr().err
