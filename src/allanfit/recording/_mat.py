"""MAT-files: variables and fields of structures, of version 4 to 7.3."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from ._damage import careful
from ._files import refuse_bomb
from ._hdf5 import hdf5_topics, object_left_out, read_hdf5
from ._mat5 import check_mat5
from ._recording import Table
from ._topics import Topic
from ._tree import Leaf, Place, Tree, tree_table, tree_topics

_HDF5_SINCE = b"MATLAB 7.3"


def read_mat(path: Path, topic: str | None = None) -> Table:
    """The arrays of a MAT-file, or of its structure `topic`.

    **Raises** `RecordingError` when the file is damaged or its arrays do not belong together.
    """
    return read_hdf5(path, topic) if _is_hdf5(path) else tree_table(path, _tree(path), topic)


def mat_topics(path: Path) -> tuple[Topic, ...]:
    """The structures of a MAT-file, or all of it where it is one recording."""
    return hdf5_topics(path) if _is_hdf5(path) else tree_topics(path, _tree(path))


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(520)
    return head.startswith((_HDF5_SINCE, b"\x89HDF")) or head[512:516] == b"\x89HDF"


def _tree(path: Path) -> Tree:
    leaves: list[Leaf] = []
    findings: list[str] = []
    with careful(path, "a MAT-file"):
        if scipy.io.matlab.matfile_version(path)[0] == 1:
            check_mat5(path)
        refuse_bomb(path, sum(8 * math.prod(shape) for _, shape, _ in scipy.io.whosmat(path)))
        content = scipy.io.loadmat(path, simplify_cells=True)
    for place, value in _walk((), content):
        name = "/".join(place)
        if isinstance(value, str):
            leaves.append(Leaf(place, value))
        elif isinstance(value, scipy.io.matlab.MatlabOpaque):
            findings.append(object_left_out(name, "object, such as a table or timetable"))
        # SciPy makes a list of a cell that holds a structure, of whatever lengths.
        elif isinstance(value, list) or np.asarray(value).dtype.kind == "O":
            findings.append(f"{name} is left out: it is no array of real numbers.")
        else:
            leaves.append(Leaf(place, np.asarray(value)))
    return Tree(tuple(leaves), tuple(findings))


def _walk(place: Place, content: dict[str, Any]) -> Iterator[tuple[Place, Any]]:
    for name, value in content.items():
        # Names of MATLAB begin with a letter: others are about the file.
        if isinstance(value, dict):
            yield from _walk((*place, name), value)
        elif not name.startswith("__"):
            yield (*place, name), value
