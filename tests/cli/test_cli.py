"""The command line: results, exit status, and one line for everything that goes wrong."""

import errno
import json
from importlib import metadata

import numpy as np
import pytest

import allanfit
from allanfit.cli import main


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    samples = allanfit.simulate({"N": 5e-3, "B": 2e-3}, duration_s=163.84, rate_hz=50.0, seed=1)
    path = tmp_path_factory.mktemp("recording") / "gyro.npz"
    np.savez(path, gyro_x=np.asarray(samples), rate_hz=50.0, units='{"gyro_x": "deg/s"}')
    return path


def test_fit_writes_table_json_page_and_figures(recording, tmp_path, capsys):
    target, page, figure = (tmp_path / f"fit.{suffix}" for suffix in ("json", "html", "pdf"))
    arguments = ["fit", str(recording), "--no-posterior", "--json", str(target)]
    assert main([*arguments, "--report", str(page), "--figure", str(figure)]) == 0
    out, err = capsys.readouterr()
    assert "angle random walk" in out
    assert "deg/sqrt(h)" in out
    assert "Page with figures" in err
    document = json.loads(target.read_text())
    (channel,) = document["channels"]
    low, high = channel["coefficients"]["N"]["intervals"]["0.95"]
    assert channel["unit"] == "deg/s"
    assert low < 5e-3 < high * 1.05
    assert "<svg" in page.read_text()
    names = ["fit-psd.pdf", "fit.html", "fit.json", "fit.pdf"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert figure.read_bytes().startswith(b"%PDF")


def test_a_figure_of_another_format_is_refused_before_the_fit(
    recording, tmp_path, monkeypatch, capsys
):
    def never(*_, **__):
        raise AssertionError

    monkeypatch.setattr("allanfit.cli.fit_recording", never)
    assert main(["fit", str(recording), "--figure", str(tmp_path / "fit.jpg")]) == 1
    assert "end its name with .pdf, .svg or .png" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("command", "figure"),
    [
        (("fit", "{}"), True),
        (("explain", "{}"), True),
        (("calibrate", "up-down", "{}", "{}"), False),
    ],
)
def test_a_page_of_another_format_is_refused(command, figure, recording, tmp_path, capsys):
    arguments = [each.format(recording) for each in command]
    assert main([*arguments, "--report", str(tmp_path / "fit.pdf")]) == 1
    err = capsys.readouterr().err
    assert "a page, whose name ends with .html or .htm, and not fit.pdf" in err
    assert ("--figure fit.pdf makes a figure" in err) == figure
    assert list(tmp_path.iterdir()) == []


def test_the_version_is_that_of_the_package(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"allanfit {metadata.version('allanfit')}\n"


def test_fit_in_blocks_says_the_same(recording, tmp_path, capsys):
    """Within the rounding of bins whose edges are a thousandth apart."""
    found = {}
    for option in ("--blocks", "--no-posterior"):
        target = tmp_path / f"{option}.json"
        arguments = ["fit", str(recording), "--no-posterior", option, "--json", str(target)]
        assert main(arguments) == 0
        found[option] = json.loads(target.read_text())["channels"][0]
    capsys.readouterr()
    blocks, whole = found["--blocks"], found["--no-posterior"]
    for key in ("unit", "samples", "rate_hz", "status"):
        assert blocks[key] == whole[key]
    assert blocks["mean"] == pytest.approx(whole["mean"])
    for symbol, entry in whole["coefficients"].items():
        low, high = entry["intervals"]["0.95"]
        other = blocks["coefficients"][symbol]
        assert other["value"] == pytest.approx(entry["value"], abs=0.05 * (high - low))
    arguments = ["fit", str(recording), "--blocks", "--temperature", "remove"]
    assert main(arguments) == 1
    assert "leave --blocks out" in capsys.readouterr().err


def test_fit_says_whether_a_data_sheet_is_met(recording, tmp_path, capsys):
    sheet, target, page = tmp_path / "sheet.yaml", tmp_path / "fit.json", tmp_path / "fit.html"
    # The truth is 0.3 deg/√h, which has the one-sided density 7.07 mdps/√Hz.
    sheet.write_text(
        "sensor: <b>maker's</b>\n"
        "gyro: {angle random walk: 0.33 deg/√h, noise density: {max: 5.2 mdps/√Hz}}\n"
    )
    arguments = ["fit", str(recording), "--no-posterior", "--datasheet", str(sheet)]
    assert main([*arguments, "--json", str(target), "--report", str(page)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "met angle random walk 0.33 deg/√h typical; measured 0." in out
    assert "missed noise density 5.2 mdps/√Hz max; measured " in out
    assert "met with probability < 0.1 %" in out
    (channel,) = json.loads(target.read_text())["channels"]
    walk, density = channel["datasheet"]["lines"]
    assert (walk["verdict"], density["verdict"]) == ("met", "missed")
    # The table and the data sheet tell one number.
    table = channel["coefficients"]["N"]["intervals"]["0.95"]
    assert walk["interval_95"] == pytest.approx([60 * bound for bound in table], rel=1e-3)
    assert density["verdict_as_coefficient"] == "met"
    html = page.read_text()
    assert '<td class="bad">missed</td>' in html
    assert "<b>maker" not in html


def test_a_data_sheet_that_does_not_go_with_the_recording_is_told_before_the_fit(
    recording, tmp_path, capsys
):
    sheet = tmp_path / "sheet.yaml"
    sheet.write_text("gyro_w: {N: 0.3 deg/√h}\n")
    assert main(["fit", str(recording), "--datasheet", str(sheet)]) == 1
    err = capsys.readouterr().err
    assert err.startswith("allanfit: sheet.yaml is about 'gyro_w'")
    assert err.count("\n") == 1


def test_json_to_stdout_is_json_alone(recording, capsys):
    assert main(["fit", str(recording), "--no-posterior", "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["schema"] == "allanfit.fit/1"
    assert err == ""


@pytest.mark.parametrize("ending", ["npz", "npy", "csv"])
def test_simulate_then_load_gives_the_same_samples(tmp_path, ending):
    coefficients = tmp_path / "c.yaml"
    coefficients.write_text("unit: deg/s\nN: 1e-2\nR: 1.0e-4\n")
    output = tmp_path / f"sim.{ending}"
    arguments = ["simulate", str(coefficients), "--duration", "10", "--rate", "50"]
    assert main([*arguments, "--seed", "2", "--output", str(output)]) == 0
    found = allanfit.load(output, rate_hz=50.0, unit="deg/s").channels[0]
    expected = allanfit.simulate(
        {"N": 0.01, "R": 1e-4}, duration_s=10.0, rate_hz=50.0, seed=2 * 1_000_003
    )
    np.testing.assert_allclose(found.samples / found.factor, expected, rtol=1e-12)


def test_simulate_says_what_it_wrote_and_in_place_of_what(tmp_path, capsys):
    source, output = tmp_path / "c.yaml", tmp_path / "sim.csv"
    source.write_text("unit: deg/s\nN: 1e-2\n")
    arguments = ["simulate", str(source), "--duration", "10", "--rate", "50", "--seed", "7"]
    told = f"Recording: {output}, 500 samples, 10 s at 50 Hz, seed 7"
    for more in ("", ", in place of the file that was there"):
        assert main([*arguments, "--output", str(output)]) == 0
        assert capsys.readouterr() == ("", f"{told}{more}\n")


def test_the_largest_seed_simulates_every_channel_and_a_larger_one_is_told(tmp_path, capsys):
    source, output = tmp_path / "c.yaml", tmp_path / "sim.npz"
    source.write_text("gyro: {N: 1 deg/√h}\naccelerometer: {N: 60 ug/√Hz}\n", encoding="utf-8")
    arguments = ["simulate", str(source), "--duration", "60", "--rate", "50"]
    arguments += ["--output", str(output), "--seed"]
    assert main([*arguments, str(2**32 - 1)]) == 0
    assert output.exists()
    assert main([*arguments, "20240101120000"]) == 2
    assert "4294967295" in capsys.readouterr().err


def test_simulate_says_what_has_no_name_and_is_not_drawn(tmp_path, capsys):
    source, output = tmp_path / "c.yaml", tmp_path / "sim.npz"
    bump = "{{name: bump, parameters: {{height: {}, frequency: 12.5, width: 0.1}}}}"
    arguments = ["simulate", str(source), "--duration", "10", "--rate", "50", "--seed", "1"]
    for height, told in ((0, True), (1.5, False)):
        source.write_text(f"unit: deg/s\nN: 1e-2\neffects: [{bump.format(height)}]\n")
        assert main([*arguments, "--output", str(output)]) == 0
        assert ("12.5 Hz has no name" in capsys.readouterr().err) == told


def test_simulate_from_a_fit_keeps_channels_and_units(recording, tmp_path):
    target, output = tmp_path / "fit.json", tmp_path / "sim.npz"
    assert main(["fit", str(recording), "--no-posterior", "--json", str(target)]) == 0
    arguments = ["simulate", str(target), "--duration", "100", "--rate", "50"]
    assert main([*arguments, "--output", str(output)]) == 0
    (channel,) = allanfit.load(output).channels
    assert (channel.name, channel.unit, len(channel.samples)) == ("gyro_x", "deg/s", 5000)


def test_a_full_disk_is_told_without_the_name_of_a_file(monkeypatch, tmp_path, capsys):
    def full(path):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("allanfit.cli.contents", full)
    assert main(["fit", str(tmp_path), "--list"]) == 1
    told = capsys.readouterr().err
    assert told == "allanfit: Input or output failed: No space left on device.\n"


@pytest.mark.parametrize(
    ("content", "arguments", "message"),
    [
        (b"", [], "is empty"),
        (b"\x00\x01\xff\xfe" * 100, [], "is not plain text"),
        (b"x [deg/s]\n" + b"1.0\n" * 300, ["--rate", "10"], "x cannot be analysed: it is constant"),
        (b"x [deg/s]\n1.0\n2.0\n", ["--rate", "10"], "at least 256 are needed"),
        (b"x [deg/s]\n" + b"1.0\n2.0\n" * 300, [], "tells no sampling rate.*give it with --rate"),
        (b"x [furlong]\n" + b"1.0\n2.0\n" * 300, ["--rate", "10"], "'furlong' is not known"),
        (
            b"x [deg/s]\n" + b"1.0\n2.0\n" * 300,
            ["--rate", "10", "--channel", "y"],
            "has no channel y; it has x",
        ),
        (b"x [deg/s]\n" + b"nan\n" * 300, ["--rate", "10"], "it has 0 usable samples"),
        (b"x [deg/s]\n" + b"1.0\n2.0\n" * 300, ["--rate", "-5"], "the rate given is -5"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_file(content, arguments, message, tmp_path, capsys):
    import re

    source, target = tmp_path / "bad.csv", tmp_path / "fit.json"
    source.write_bytes(content)
    assert main(["fit", str(source), *arguments, "--json", str(target)]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("allanfit: ")
    assert len(err.splitlines()) == 1
    assert re.search(message, err), err
    assert [path.name for path in tmp_path.iterdir()] == ["bad.csv"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("N: -1\n", "zero or more"),
        ("N: .nan\n", "zero or more"),
        ("n: 1\n", "names 'n'"),
        ("unit: deg/s\n", "none of the coefficients"),
        ("- 1\n", "holds no coefficients"),
        ('{"channels": 3}', "not a complete fit"),
        ("{unclosed", "neither JSON nor YAML"),
        ('{"channels": [{}]}', "not a complete fit JSON"),
        ("N: 1\nsampling: often\n", "point or averaged"),
    ],
)
def test_bad_coefficients_are_one_line(text, message, tmp_path, capsys):
    source = tmp_path / "c.yaml"
    source.write_text(text)
    arguments = ["simulate", str(source), "--duration", "10", "--rate", "50"]
    assert main([*arguments, "--output", str(tmp_path / "sim.npz")]) == 1
    err = capsys.readouterr().err
    assert message in err
    assert len(err.splitlines()) == 1


def test_missing_file_and_missing_folder(recording, tmp_path, capsys):
    assert main(["fit", str(tmp_path / "none.npz")]) == 1
    assert "none.npz" in capsys.readouterr().err
    assert main(["fit", str(recording), "--json", str(tmp_path / "no" / "fit.json")]) == 1
    assert "make it first" in capsys.readouterr().err


def test_wrong_usage_exits_with_two(capsys):
    assert main(["fit"]) == 2
    assert main(["fit", "x.npz", "--rate", "fast"]) == 2
    assert main(["nonsense"]) == 2
    assert main(["--help"]) == 0
    capsys.readouterr()


@pytest.mark.parametrize("name", ["vn100", "phone_accelerometer"])
def test_real_recordings(name, tmp_path):
    from pathlib import Path

    source = Path(__file__).parents[2].parent / "shared" / "recordings" / f"{name}.npz"
    if not source.exists():
        pytest.skip("shared recordings are not beside this checkout")
    target = tmp_path / "fit.json"
    assert main(["fit", str(source), "--no-posterior", "--json", str(target)]) == 0
    document = json.loads(target.read_text())
    channels = {channel["channel"]: channel for channel in document["channels"]}
    if name == "vn100":
        assert 9.0e-5 < channels["gyro_x"]["coefficients"]["N"]["value"] < 1.1e-4
        assert all(channel["goodness_of_fit"]["consistent"] for channel in channels.values())
    else:
        assert any("gap" in finding for finding in document["findings"])
