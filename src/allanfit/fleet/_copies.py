"""Recordings whose files are the same, byte for byte."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from ._rows import Row


class Copy(NamedTuple):
    """A recording that is another one again."""

    path: str
    original: str
    """The path of that which counts."""


def find_copies(rows: Sequence[Row]) -> tuple[Copy, ...]:
    """All but one of the recordings of each checksum; rows without one are no copies."""
    paths: dict[str, set[str]] = {}
    for row in rows:
        if checksum := row.get("file_sha256"):
            paths.setdefault(checksum, set()).add(row["path"])
    found = []
    for alike in paths.values():
        original, *others = sorted(alike, key=_plainest)
        found += [Copy(path, original) for path in others]
    return tuple(sorted(found, key=lambda each: natural(each.path)))


def natural(name: str) -> list[tuple[int, str]]:
    """A key by which unit 2 comes before unit 10."""
    return [
        (int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name)
    ]


def _plainest(path: str) -> tuple[int, list[tuple[int, str]]]:
    # What copies are called has more to it: "unit_1 (copy).csv", "unit_1_backup.csv".
    return len(Path(path).name), natural(path)
