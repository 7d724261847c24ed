import re

import pytest
from explanation_documents import make_explanation
from PIL import Image

from allanfit.report import ReportError, write_figures


def test_one_channel_is_written_to_the_name_itself(document, tmp_path):
    document["channels"] = document["channels"][:1]
    found = write_figures(document, tmp_path / "gyro.pdf")
    assert [path.name for path in found] == ["gyro.pdf", "gyro-psd.pdf"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gyro-psd.pdf", "gyro.pdf"]
    content = found[0].read_bytes()
    width = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+)", content)
    assert width is not None
    assert float(width[1]) == pytest.approx(88.9 / 25.4 * 72)
    # Letters as letters, not as pictures, and nothing that differs from run to run.
    assert b"/FontFile2" in content
    assert b"CreationDate" not in content
    assert write_figures(document, tmp_path / "gyro.pdf")[0].read_bytes() == content


def test_each_channel_has_a_file_of_its_own(document, tmp_path):
    names = [path.name for path in write_figures(document, tmp_path / "imu.svg")]
    assert names[:3] == ["imu-gyro_x.svg", "imu-gyro_x-psd.svg", "imu-accel_z.svg"]
    assert len(set(names)) == 6
    assert "script" not in (tmp_path / "imu-gyro_x.svg").read_text("utf-8")


def test_names_that_no_file_can_tell_apart_are_numbered(document, tmp_path):
    document["channels"] = document["channels"][:2]
    for channel, name in zip(document["channels"], ("a/b", "a b"), strict=True):
        channel["channel"] = name
    names = [path.name for path in write_figures(document, tmp_path / "imu.svg")]
    assert names == ["imu-1.svg", "imu-1-psd.svg", "imu-2.svg", "imu-2-psd.svg"]


def test_an_explanation_as_pixels(document, tmp_path):
    found = make_explanation(document)
    found["channels"] = found["channels"][:1]
    allan, _ = write_figures(found, tmp_path / "gyro.png")
    with Image.open(allan) as image:
        assert image.width == 2100


def test_another_format_is_refused(document, tmp_path):
    with pytest.raises(ReportError, match=r"'.*gyro.jpg': end its name with .pdf, .svg or .png"):
        write_figures(document, tmp_path / "gyro.jpg")


def test_a_folder_that_is_not_there_is_named(document, tmp_path):
    with pytest.raises(ReportError, match="Cannot write"):
        write_figures(document, tmp_path / "nowhere" / "gyro.svg")
