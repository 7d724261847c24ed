"""Every block of the README and the docs runs, or is written to a file, or says why not."""

from pathlib import Path

import page_blocks
import page_recordings
import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
# How many blocks of a page are not run, each marked with its reason there.
NOT_RUN = {
    "README.md": 3,
    "CONTRIBUTING.md": 1,
    "index.md": 2,
    "first-recording.md": 1,
    "formats.md": 3,
    "fleet.md": 1,
    "paper.md": 3,
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = page.read_text(encoding="utf-8")
    for name in page_blocks.recordings_of(text):
        page_recordings.make(name, tmp_path)
    namespace: dict = {}
    for block in page_blocks.blocks_of(text):
        if "not run" not in block.marks:
            page_blocks.run(block, tmp_path, namespace)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_blocks_that_are_not_run_are_known(page):
    blocks = page_blocks.blocks_of(page.read_text(encoding="utf-8"))
    left_out = [block.line for block in blocks if "not run" in block.marks]
    assert len(left_out) == NOT_RUN.get(page.name, 0), left_out


def test_an_unmarked_block_cannot_slip_in(tmp_path):
    (block,) = page_blocks.blocks_of("```matlab\nload x\n```\n")
    with pytest.raises(pytest.fail.Exception, match="needs a mark"):
        page_blocks.run(block, tmp_path, {})


@pytest.mark.parametrize(
    ("page", "message"),
    [
        ("```console\nmake demo\n```\n", "only allanfit can be run"),
        ("```console\nallanfit fit none.csv\n```\n", "none.csv"),
        ("```python\nprint(2)\n```\n\n```text\n3\n```\n", "line 1"),
        ("```python\nprint('a')\n```\n\n```text\nb\n```\n", "line 1"),
    ],
)
def test_blocks_that_fail_are_told(page, message, tmp_path):
    (block,) = page_blocks.blocks_of(page)
    with pytest.raises(AssertionError, match=message):
        page_blocks.run(block, tmp_path, {})
