"""`allanfit calibrate`: text, JSON, page, exit status."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from allanfit.cli import main

TABLE = str(Path(__file__).parents[2] / "examples" / "rate_table.csv")


@pytest.fixture
def up_and_down(tmp_path):
    """Files of an axis up and down, and of its noise."""
    rng = np.random.default_rng(0)
    paths = []
    for name, sense in (("up", 9.9), ("down", -9.9)):
        path = tmp_path / f"{name}.npz"
        np.savez(path, az=sense + 0.1 + 0.02 * rng.standard_normal(1000), rate_hz=50.0)
        paths.append(str(path))
    noise = tmp_path / "noise.yaml"
    noise.write_text("unit: m/s^2\nN: 0.00283\n")
    return *paths, str(noise)


def test_rate_table_as_text_json_and_page(tmp_path, capsys):
    target, page = tmp_path / "c.json", tmp_path / "c.html"
    arguments = ["calibrate", "rate-table", TABLE, "--unit", "rpm", "--latitude", "33.7"]
    assert main([*arguments, "--json", str(target), "--report", str(page)]) == 0
    out, err = capsys.readouterr()
    assert re.search(r"bias +0\.27 +\[-0\.46, 1\.00\] +rpm +not significant", out)
    assert re.search(r"1\.6 +\[-2\.7, 6\.0\] +deg/s", out)
    assert max(map(len, out.splitlines())) <= 80
    assert "Page with figures" in err
    assert json.loads(target.read_text())["conditions"]["latitude_deg"] == 33.7
    html = page.read_text()
    assert html.count("<svg") == 3
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"|<!DOCTYPE[^>]*>', "", html).replace(
        "http-equiv", ""
    )


def test_up_down_and_multi_position_write_pages(up_and_down, tmp_path, capsys):
    up, down, noise = up_and_down
    page = tmp_path / "u.html"
    common = ["--gravity", "9.81", "--report", str(page), "--json", "-"]
    assert main(["calibrate", "up-down", up, down, "--noise", noise, *common]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["axes"]["az"]["bias"]["value"] == pytest.approx(0.1, abs=0.003)
    assert document["axes"]["az"]["bias"]["unit"] == "m/s^2"
    assert "No unit is known" in " ".join(document["findings"])
    assert page.read_text().count("<svg") == 1
    means = tmp_path / "<means>.csv"
    rows = np.random.default_rng(1).standard_normal((12, 3))
    rows *= 9.81 / np.linalg.norm(rows, axis=1, keepdims=True)
    np.savetxt(means, rows, delimiter=",", header="ax,ay,az", comments="")
    assert main(["calibrate", "multi-position", str(means), *common]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document["misalignment"]) == {"alpha_yz", "alpha_zy", "alpha_zx", "convention"}
    assert np.shape(document["correction"]["matrix"]) == (3, 3)
    assert "&lt;means&gt;" in page.read_text()
    assert "<means>" not in page.read_text()


def test_a_page_is_the_same_twice(tmp_path):
    pages = [tmp_path / "a.html", tmp_path / "b.html"]
    for page in pages:
        main(["calibrate", "rate-table", TABLE, "--unit", "rpm", "--report", str(page)])
    assert pages[0].read_bytes() == pages[1].read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["rate-table", "nowhere.csv"], "There is no file nowhere.csv"),
        (["rate-table", "."], "is a folder"),
        (["rate-table", TABLE, "--unit", "g"], "not one of an angular rate"),
        (["multi-position", "nowhere.csv"], "There is no file nowhere.csv"),
        (["multi-position", TABLE], "no column for x"),
        (["up-down", "nowhere.csv", "nowhere.csv"], "There is no file nowhere.csv"),
        (["rate-table", TABLE, "--json", "no/where.json"], "There is no folder"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(arguments, message, capsys):
    assert main(["calibrate", *arguments]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("allanfit: ")
    assert message in err
    assert err.count("\n") == 1


def test_wrong_usage(up_and_down, capsys):
    assert main(["calibrate", "rate-table"]) == 2
    up, down, noise = up_and_down
    assert main(["calibrate", "up-down", down, up, "--noise", noise]) == 1
    assert "swapped" in capsys.readouterr().err
