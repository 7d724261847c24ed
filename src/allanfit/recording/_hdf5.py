"""HDF5: arrays anywhere in its groups, with units and rates as arrays or as attributes.

MATLAB's files since version 7.3 are of this kind too, and its own attributes are understood.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needs
from ._damage import careful, refuse_larger_than_memory
from ._names import is_rate, is_unit
from ._recording import Block, RecordingError, Table
from ._timestamps import SHORTEST_STRETCH
from ._topics import Topic
from ._tree import Leaf, Place, Tree, tree_table, tree_topics

# MATLAB keeps there what cells and objects refer to.
_INTERNAL = ("#refs#", "#subsystem#")
_FEWEST = 1024
_MATLAB_NUMBERS = ("double", "single", "int", "uint")


def read_hdf5(path: Path, topic: str | None = None) -> Table:
    """The arrays of an HDF5 file, or of its group `topic`.

    **Raises** `RecordingError` when the file is damaged or its arrays do not belong together.
    """
    return tree_table(path, _tree(path), topic)


def hdf5_topics(path: Path) -> tuple[Topic, ...]:
    """The groups of an HDF5 file, or all of it where it is one recording."""
    return tree_topics(path, _tree(path))


def object_left_out(name: str, kind: str) -> str:
    """What to do with an object that only MATLAB can read."""
    return (
        f"{name} is a MATLAB {kind}, which only MATLAB can read: save arrays of numbers in its "
        "place, those of a timetable T by `s = table2struct(timetable2table(T), 'ToScalar', true); "
        "save('new.mat', '-struct', 's')`."
    )


def hdf5_blocks(path: Path, samples: int, topic: str | None = None) -> Iterator[Block]:
    """The same in blocks of so many samples.

    Arrays that are shorter than the longest are left out.
    """
    rows = _rows(path, topic)
    # A last block must be long enough to tell samples from channels.
    starts = range(0, max(rows - min(samples, _FEWEST), 1), samples)
    for start, stop in pairwise([*starts, rows]):
        yield Block(tree_table(path, _tree(path, (rows, start, stop)), topic), stop, rows)


def _rows(path: Path, topic: str | None) -> int:
    """Samples of the longest array in a file or a group of it."""
    found = [0]
    with _opened(path) as file:
        asked = tuple(part for part in (topic or "").split("/") if part)

        def visit(name: str, item: Any) -> None:
            place = tuple(name.split("/"))
            inside = place[: len(asked)] == asked and place[0] not in _INTERNAL
            if inside and getattr(item, "shape", None):
                found.append(max(item.shape))

        file.visititems(visit)
    return max(found)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with needs("allanfit[io]", "HDF5 files", RecordingError):
        import h5py
    with careful(path, "an HDF5 file"), h5py.File(path, "r") as file:
        yield file


def _tree(path: Path, rows: tuple[int, int, int] | None = None) -> Tree:
    """All arrays, or of those with so many rows the rows [start, stop)."""
    leaves: list[Leaf] = []
    findings: list[str] = []
    datasets: dict[Place, Any] = {}
    with _opened(path) as file:

        def visit(name: str, item: Any) -> None:
            place = tuple(name.split("/"))
            if place[0] not in _INTERNAL:
                leaves.extend(_attributes(place, item))
                if hasattr(item, "shape"):
                    datasets[place] = item

        leaves += _attributes((), file)
        # Links to other places and other files are not followed.
        file.visititems(visit)
        if rows is None:
            refuse_larger_than_memory(path, sum(item.nbytes for item in datasets.values()))
        for place, item in datasets.items():
            read, doubts = _dataset(place, item, rows)
            leaves += read
            findings += doubts
    return Tree(tuple(leaves), tuple(findings))


def _attributes(place: Place, item: Any) -> list[Leaf]:
    """Rates and units that stand beside a group or an array."""
    found = []
    for name, value in item.attrs.items():
        if is_rate(name):
            found.append(Leaf((*place, name), np.asarray(value)))
        elif is_unit(name) and (text := _text(value)).lstrip().startswith("{"):
            found.append(Leaf((*place, name), text))
    return found


def _dataset(
    place: Place, item: Any, rows: tuple[int, int, int] | None
) -> tuple[list[Leaf], list[str]]:
    name, kind = "/".join(place), _text(item.attrs.get("MATLAB_class", ""))
    if item.shape is None or "MATLAB_empty" in item.attrs:
        return [], []
    if item.is_virtual or item.external:
        return [], [f"The array {name} is left out: its numbers are in another file."]
    if kind == "char":
        return [Leaf(place, "".join(map(chr, np.ravel(item[()]))))], []
    if kind and not kind.startswith(_MATLAB_NUMBERS):
        return [], [object_left_out(name, kind)]
    if item.dtype.kind == "O" and item.shape == ():
        return [Leaf(place, _text(item[()]))], []
    unit = next((_text(value) for key, value in item.attrs.items() if is_unit(key)), "")
    values = np.asarray(item[()] if rows is None else _cut(item, *rows))
    if values.dtype.names is not None:
        return [Leaf((*place, field), values[field], unit) for field in values.dtype.names], []
    return [Leaf(place, values, unit)], []


def _cut(item: Any, rows: int, start: int, stop: int) -> np.ndarray:
    """The asked rows of an array that has as many, all of a small one, and nothing of others."""
    if rows in item.shape:
        return item[(slice(None),) * item.shape.index(rows) + (slice(start, stop),)]
    return item[()] if item.size < SHORTEST_STRETCH else np.empty(0)


def _text(value: Any) -> str:
    """A text, however HDF5 or MATLAB stores it; empty if it is none."""
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size else ""
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
