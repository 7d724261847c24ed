import json
import math
import os

import pytest

from allanfit.report import ReportError, write_json


def test_the_document_comes_back(document, tmp_path):
    target = tmp_path / "fit.json"
    write_json(document, target)
    assert json.loads(target.read_text()) == document
    assert [path.name for path in tmp_path.iterdir()] == ["fit.json"]


def test_a_dash_is_standard_output(document, capsys):
    write_json(document, "-")
    assert json.loads(capsys.readouterr().out) == document


@pytest.mark.parametrize("bad", [math.nan, math.inf, {1, 2}])
def test_what_json_cannot_hold_leaves_the_old_file(document, tmp_path, bad):
    target = tmp_path / "fit.json"
    target.write_text("old")
    document["channels"][0]["mean"] = bad
    with pytest.raises(ReportError, match="not strict JSON"):
        write_json(document, target)
    assert target.read_text() == "old"


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(document, tmp_path, monkeypatch):
    def full_disk(_descriptor):
        raise OSError(28, "No space left on device")

    target = tmp_path / "fit.json"
    target.write_text("old")
    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(ReportError, match=r"Cannot write .*fit\.json \(No space left on device\)"):
        write_json(document, target)
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["fit.json"]


def test_a_folder_that_is_not_there_is_named(document, tmp_path):
    with pytest.raises(ReportError, match=r"nowhere.*give a path in a folder that exists"):
        write_json(document, tmp_path / "nowhere" / "fit.json")


def test_a_folder_is_no_target(document, tmp_path):
    with pytest.raises(ReportError, match="Cannot write"):
        write_json(document, tmp_path)


def test_a_link_keeps_pointing_where_it_did(document, tmp_path):
    target, link = tmp_path / "fit.json", tmp_path / "latest.json"
    target.write_text("old")
    link.symlink_to(target)
    write_json(document, link)
    assert link.is_symlink()
    assert json.loads(target.read_text()) == document


def test_a_device_is_written_in_place(document):
    write_json(document, os.devnull)
    assert not os.path.isfile(os.devnull)
