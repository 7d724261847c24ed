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


def test_list_takes_the_rate_and_the_unit_given(two, capsys):
    assert main(["fit", str(two), "--list", "--rate", "200", "--unit", "rad/s"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "imu0, 400 samples, 200 Hz",
        "  gyro_x  rad/s",
        "imu1, 300 samples, 200 Hz",
        "  gyro_x  rad/s",
    ]


def test_list_gives_a_unit_to_what_it_fits_alone(tmp_path, capsys):
    path = tmp_path / "imu.csv"
    rows = [f"{k / 100},{k % 7},{k % 5},20,{k % 3}" for k in range(400)]
    path.write_text("time,gyro_x,accel_x [g],temperature,battery\n" + "\n".join(rows))
    assert main(["fit", str(path), "--list", "--unit", "deg/s"]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == [
        "  gyro_x       deg/s",
        "  accel_x      g",
        "  temperature  -",
        "  battery      -",
    ]


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (["--rate", "-1"], "the rate given is -1"),
        (["--unit", "parsec"], "The unit 'parsec' is not known"),
        (["--unit", "g"], "The unit g fits none of the channels: gyro_x is in deg/s"),
    ],
)
def test_list_refuses_what_fit_would(option, message, two, capsys):
    assert main(["fit", str(two), "--list", *option]) == 1
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err


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
