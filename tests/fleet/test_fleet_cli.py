"""The command: its summary, its exit status, and one line for what goes wrong."""

import sys

import pytest
from fleet_recordings import write_recording

from allanfit.cli import main


@pytest.fixture
def fleet(scheduler, tmp_path):
    """The command with the worker of this process."""

    def run(*arguments):
        output = tmp_path / "fleet"
        command = ["fleet", *map(str, arguments), "--output", str(output)]
        return main([*command, "--scheduler", scheduler]), output

    return run


def test_a_summary_on_stdout_and_messages_on_stderr(recordings, fleet, capsys):
    damaged = recordings[0].with_name("damaged.npz")
    damaged.write_bytes(b"no recording")
    status, output = fleet(recordings[0].parent)
    out, err = capsys.readouterr()
    assert status == 0
    assert "3 recordings, 2 channels of 2 devices: 2 analysed now, 0 unchanged" in out
    assert "gyro_x [deg/s], 2 devices" in out
    assert "damaged.npz" in out
    assert "allanfit: 1 of 3 recordings could not be analysed" in err
    assert "<svg" in (output / "summary.html").read_text()
    # What failed is no result that is unchanged either.
    assert fleet(recordings[0].parent)[0] == 0
    again = " ".join(capsys.readouterr().out.split())
    assert "0 analysed now, 2 unchanged since an earlier run. 1 recording could not be" in again
    # Another recording beside those that are there.
    other = write_recording(recordings[0].with_name("unit_7.npz"), seed=7)
    assert fleet(other)[0] == 0
    assert "3 results of other recordings" in capsys.readouterr().err


def test_a_fleet_of_failures_is_one_line_and_status_one(tmp_path, fleet, capsys):
    damaged = tmp_path / "damaged.npz"
    damaged.write_bytes(b"no recording")
    status, output = fleet(damaged)
    out, err = capsys.readouterr()
    assert (status, out) == (1, "")
    assert err.startswith("allanfit: No recording could be analysed. damaged")
    assert len(err.splitlines()) == 1
    assert len(list((output / "results").iterdir())) == 1


def test_options_of_fit_are_passed_on(recordings, fleet, capsys):
    status, _ = fleet(recordings[0], "--channel", "gyro_y")
    assert status == 1
    assert "no channel gyro_y" in capsys.readouterr().err
    assert fleet(recordings[0], "--unit", "rad/s", "--rate", "10")[0] == 0
    assert "gyro_x [rad/s]" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["fleet"], ["fleet", "x.npz"], ["fleet", "--workers", "0"]])
def test_wrong_usage_exits_with_two(arguments, capsys):
    assert main(arguments) == 2
    capsys.readouterr()


def test_nothing_to_analyse_is_one_line(tmp_path, capsys):
    assert main(["fleet", str(tmp_path / "*.npz"), "--output", str(tmp_path / "out")]) == 1
    err = capsys.readouterr().err
    assert err.startswith("allanfit: No recording has a name like")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("package", ["distributed", "pyarrow"])
def test_without_the_extra_the_command_names_it(package, recordings, tmp_path, monkeypatch, capsys):
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    assert main(["fleet", str(recordings[0]), "--output", str(tmp_path / "out")]) == 1
    err = capsys.readouterr().err
    assert f"Fleets need {package}" in err
    assert "pip install 'allanfit[fleet]'" in err
    assert len(err.splitlines()) == 1
