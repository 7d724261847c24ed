"""HDF5: arrays anywhere in its groups, with units and rates as arrays or as attributes.

MATLAB's files since version 7.3 are of this kind too, and its own attributes are understood.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import needs
from ._damage import careful
from ._files import refuse_bomb
from ._lateness import SHORTEST_STRETCH
from ._names import is_rate, is_unit
from ._recording import Block, RecordingError, Table
from ._topics import Topic
from ._tree import Leaf, Place, Tree, longest, tree_table, tree_topics

# Deeper than anyone nests groups; their paths grow with each.
_DEEPEST = 32
# MATLAB keeps there what cells and objects refer to.
_INTERNAL = ("#refs#", "#subsystem#")
_FEWEST = 1024
# What to take of an array of numbers.
_Read = Callable[[Any], np.ndarray]
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
    """The same in blocks of so many samples."""
    shapes = _tree(path, _shape)
    rows = longest(shapes, topic)
    # A last block must be long enough to tell samples from channels.
    starts = range(0, max(rows - min(samples, _FEWEST), 1), samples)
    for start, stop in pairwise([*starts, rows]):
        tree = _tree(path, partial(_cut, rows, start, stop))
        yield Block(tree_table(path, tree, topic, shapes), stop, rows)


@contextmanager
def _opened(path: Path) -> Iterator[dict[Place, Any]]:
    """Groups and arrays of a file by their place, the file itself at the empty one."""
    with needs("allanfit[io]", "HDF5 files", RecordingError):
        import h5py
    with careful(path, "an HDF5 file"), h5py.File(path, "r") as file:
        yield {(): file} | dict(_items((), file, {_address(file)}))


def _all(item: Any) -> np.ndarray:
    return np.asarray(item[()])


def _tree(path: Path, read: _Read = _all) -> Tree:
    """All arrays, of each what `read` takes of it."""
    leaves: list[Leaf] = []
    findings: list[str] = []
    with _opened(path) as items:
        datasets = {place: item for place, item in items.items() if hasattr(item, "dtype")}
        if read is _all:
            refuse_bomb(path, sum(item.nbytes for item in datasets.values()))
        for place, item in items.items():
            leaves += _attributes(place, item)
        for place, item in datasets.items():
            found, doubts = _dataset(place, item, read)
            leaves += found
            findings += doubts
    return Tree(tuple(leaves), tuple(findings))


def _items(place: Place, group: Any, known: set[int]) -> Iterator[tuple[Place, Any]]:
    """Groups and arrays in a group and below, each once, however many names it has."""
    import h5py

    if len(place) > _DEEPEST:
        raise RecordingError(
            f"{Path(group.file.filename).name} nests its groups too deep to be a recording."
        )
    for name in group:
        # Links to other places and other files are not followed.
        own = isinstance(group.get(name, getlink=True), h5py.HardLink)
        if not own or (not place and name in _INTERNAL):
            continue
        item = group[name]
        address = _address(item)
        if address in known:
            continue
        known.add(address)
        yield (*place, name), item
        if isinstance(item, h5py.Group):
            yield from _items((*place, name), item, known)


def _address(item: Any) -> int:
    """Where in the file it is, under whatever name."""
    # The stubs of h5py know its low-level modules by their full names alone.
    from h5py import h5o  # pyright: ignore[reportAttributeAccessIssue]

    return h5o.get_info(item.id).addr


def _attributes(place: Place, item: Any) -> list[Leaf]:
    """Rates and units that stand beside a group or an array."""
    found = []
    for name, value in item.attrs.items():
        if is_rate(name):
            found.append(Leaf((*place, name), np.asarray(value)))
        elif is_unit(name) and (text := _text(value)).lstrip().startswith("{"):
            found.append(Leaf((*place, name), text))
    return found


def _dataset(place: Place, item: Any, read: _Read) -> tuple[list[Leaf], list[str]]:
    name, kind = "/".join(place), _text(item.attrs.get("MATLAB_class", ""))
    if item.shape is None or "MATLAB_empty" in item.attrs:
        return [], []
    if item.is_virtual or item.external:
        return [], [f"The array {name} is left out: its numbers are in another file."]
    if kind == "char":
        text = np.ravel(item[()]).astype("<u2").tobytes().decode("utf-16-le", errors="replace")
        return [Leaf(place, text)], []
    if kind and not kind.startswith(_MATLAB_NUMBERS):
        return [], [object_left_out(name, kind)]
    if item.dtype.kind == "O" and item.shape == ():
        return [Leaf(place, _text(item[()]))], []
    unit = next((_text(value) for key, value in item.attrs.items() if is_unit(key)), "")
    if item.dtype.names is not None:
        fields = {field: item.dtype[field] for field in item.dtype.names}
        return [
            Leaf((*place, field), _numbers(item, kind, read, field), unit)
            for field, kind in fields.items()
        ], []
    return [Leaf(place, _numbers(item, item.dtype, read), unit)], []


def _numbers(item: Any, kind: np.dtype, read: _Read, field: str = "") -> np.ndarray:
    """An array or a field of it; for what holds no numbers, an array of its shape."""
    if kind.base.kind in "iuf":
        values = read(item)
        return values[field] if field else values
    # Not read: many long texts may be one in the file.
    return np.broadcast_to(np.empty((), kind), item.shape + kind.shape)


def _shape(item: Any) -> np.ndarray:
    """Zeros in its shape, which take no memory."""
    return np.broadcast_to(np.zeros((), item.dtype), item.shape)


def _cut(rows: int, start: int, stop: int, item: Any) -> np.ndarray:
    """The asked rows of an array that has as many, all of a small one, and nothing of others."""
    if rows in item.shape:
        return item[(slice(None),) * item.shape.index(rows) + (slice(start, stop),)]
    return _all(item) if item.size < SHORTEST_STRETCH else np.empty(0, item.dtype)


def _text(value: Any) -> str:
    """A text, however HDF5 or MATLAB stores it; empty if it is none."""
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size else ""
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
