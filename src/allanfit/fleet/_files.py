"""Which recordings are meant by what was typed: files, folders and patterns."""

import os
from collections.abc import Sequence
from glob import glob, has_magic
from pathlib import Path

from ..recording import is_recording
from ._errors import FleetError


def find_recordings(given: Sequence[str | os.PathLike[str]], apart_from: Path) -> tuple[Path, ...]:
    """The absolute paths of the recordings, each once, in the order given.

    A folder stands for the recordings directly in it; a pattern that the shell left alone is
    expanded, `**` for folders in folders. A file that is not there is kept: it may be on the
    workers' disk, and if it is not, that is said in its row.

    **Arguments:** `apart_from` is the folder of results, in which no recording is looked for.

    **Raises** `FleetError` for a folder or a pattern without recordings.
    """
    found: dict[str, Path] = {}
    for each in map(Path, given):
        for path in _expanded(each, os.path.realpath(apart_from)):
            # A link and what it points to are one recording.
            found.setdefault(os.path.realpath(path), path.absolute())
    if not found:
        raise FleetError("No recordings are given: give files, folders or patterns.")
    return tuple(found.values())


def _expanded(given: Path, apart_from: str) -> list[Path]:
    if given.is_dir() and not is_recording(given):
        inside = sorted(path for path in given.iterdir() if _wanted(path, apart_from))
        if not inside:
            raise FleetError(
                f"The folder {given} holds no recordings directly; for those in folders below "
                f"give a pattern, such as '{given}/**/*.npz'."
            )
        return inside
    if given.exists() or not has_magic(str(given)):
        return [given]
    matches = map(Path, sorted(glob(str(given), recursive=True)))
    inside = [path for path in matches if _wanted(path, apart_from)]
    if not inside:
        raise FleetError(f"No recording has a name like {given}.")
    return inside


def _wanted(path: Path, apart_from: str) -> bool:
    hidden = path.name.startswith(".")
    ours = Path(apart_from) in Path(os.path.realpath(path)).parents
    # The files in the folder of a ROS 2 bag are one recording, the folder.
    part = is_recording(path.parent)
    return is_recording(path) and path.exists() and not hidden and not ours and not part
