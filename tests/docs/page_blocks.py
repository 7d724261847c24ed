"""The blocks of a page of the docs, and running them as a reader would.

What a block needs beyond its text stands in a comment above it, which no reader sees:

    <!-- recordings: gyro.csv, up.csv -->     files of page_recordings.py, for the whole page
    <!-- before: import numpy as np -->       Python run ahead of the next block
    <!-- file: sensor.yaml -->                the next block is written to this file
    <!-- run with: fit --no-posterior -->     added to commands `fit`, for the sake of time; a
                                              semicolon parts one such rule from the next
    <!-- not run: needs a bag of yours -->    the next block is left alone; the test counts these

Python of one page runs in one namespace, commands in one folder. Where a block of `text` follows,
it is the output; its numbers may differ a little, since draws differ between processors.
"""

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from allanfit.cli import main

_MARK = re.compile(r"<!-- (recordings|before|file|run with|not run): (.*?) -->", re.DOTALL)
_FENCE = re.compile(r"```(\w*)\n(.*?)```", re.DOTALL)
_PART = re.compile(f"{_MARK.pattern}|{_FENCE.pattern}", re.DOTALL)
_CHECKSUM = re.compile(r"checksum \w+")
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")


@dataclass(frozen=True)
class Block:
    """A fenced block, what its comments say, and the output that follows it."""

    line: int
    language: str
    text: str
    marks: dict[str, str]
    output: str | None = None


def blocks_of(page: str) -> Iterator[Block]:
    """The blocks of a page but those of output, which belong to the block above them."""
    marks: dict[str, str] = {}
    found: list[Block] = []
    for part in _PART.finditer(page):
        kind, value, language, text = part.groups()
        if kind:
            marks[kind] = value
            continue
        line = page.count("\n", 0, part.start()) + 1
        if language == "text" and not marks and found and found[-1].output is None:
            last = found.pop()
            found.append(Block(last.line, last.language, last.text, last.marks, text))
        else:
            found.append(Block(line, language, text, marks))
        marks = {}
    yield from found


def recordings_of(page: str) -> list[str]:
    """Names of the recordings that a page is about."""
    return [
        name.strip()
        for kind, value in _MARK.findall(page)
        if kind == "recordings"
        for name in value.split(",")
    ]


def run(block: Block, folder: Path, namespace: dict) -> None:
    """Run a block in `folder`, the current one, and compare what it prints."""
    if "before" in block.marks:
        exec(block.marks["before"], namespace)
    if "file" in block.marks:
        (folder / block.marks["file"]).write_text(block.text, encoding="utf-8")
        return
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        if block.language == "python":
            exec(compile(block.text, f"line {block.line}", "exec"), namespace)
        elif block.language == "console":
            for command in _commands(block.text):
                _run_command(command, block.marks.get("run with", ""))
        else:
            pytest.fail(f"line {block.line}: a block of {block.language!r} needs a mark")
    if block.output is not None:
        _compare(printed.getvalue(), block.output, block.line)


def _commands(text: str) -> list[str]:
    return text.replace("\\\n", " ").strip().splitlines()


def _run_command(command: str, rules: str) -> None:
    program, *arguments = shlex.split(command, comments=True)
    assert program == "allanfit", f"{command}: only allanfit can be run, mark the block"
    for name, *added in map(str.split, filter(None, rules.split(";"))):
        if arguments[0] == name:
            arguments += added
    messages = io.StringIO()
    with contextlib.redirect_stderr(messages):
        status = main(arguments)
    assert status == 0, f"{command}\n{messages.getvalue()}"


def _compare(printed: str, shown: str, line: int) -> None:
    """The words alike, whatever the width of columns, and the numbers to within draws."""
    printed, shown = (_CHECKSUM.sub("checksum", text) for text in (printed, shown))
    made, told = (" ".join(_NUMBER.sub("#", text).split()) for text in (printed, shown))
    assert made == told, f"line {line}"
    made, told = ([float(n) for n in _NUMBER.findall(text)] for text in (printed, shown))
    assert made == pytest.approx(told, rel=0.1), f"line {line}"
