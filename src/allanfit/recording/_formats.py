"""Which reader a file belongs to, by its name."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from ._csv import csv_blocks, read_csv
from ._files import require_file, too_large
from ._hdf5 import hdf5_blocks, hdf5_topics, read_hdf5
from ._mat import mat_topics, read_mat
from ._npz import npy_blocks, npz_blocks, read_npy, read_npz
from ._parquet import parquet_blocks, read_parquet
from ._recording import Block, Progress, RecordingError, Table, table_blocks
from ._ros import is_ros2_bag, read_ros, ros_topics
from ._stamp_pairs import joined
from ._topics import Topic, topic_of
from ._ulog import read_ulog, ulog_topics

_Read = TypeVar("_Read")

_KNOWN = (
    ".csv, .csv.gz, .txt, .tsv, .npy, .npz, .parquet, .mat, .h5, .hdf5, .bag, .mcap, .db3 or "
    ".ulg file"
)

_SPREADSHEETS = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")


@dataclass(frozen=True)
class _Format:
    """How to read a type of file."""

    read: Callable[[Path, str | None, Progress | None], Table]
    topics: Callable[[Path], tuple[Topic, ...]]
    blocks: Callable[[Path, int, str | None], Iterator[Block]] | None = None
    """Blocks of so many samples of a topic; None where a file can only be read as a whole."""


def _one_table(
    read: Callable[[Path], Table], blocks: Callable[[Path, int], Iterator[Block]]
) -> _Format:
    """A format whose files are one table."""

    def refuse_topic(path: Path, topic: str | None) -> None:
        if topic is not None:
            raise RecordingError(f"{path.name} is one table without topics: leave --topic out.")

    def only(path: Path, topic: str | None, progress: Progress | None) -> Table:
        refuse_topic(path, topic)
        return joined(read(path))

    def only_blocks(path: Path, samples: int, topic: str | None) -> Iterator[Block]:
        refuse_topic(path, topic)
        return (replace(block, table=joined(block.table)) for block in blocks(path, samples))

    return _Format(only, lambda path: (topic_of(joined(read(path))),), only_blocks)


def _in_parts(
    read: Callable[[Path, str | None], Table],
    topics: Callable[[Path], tuple[Topic, ...]],
    blocks: Callable[[Path, int, str | None], Iterator[Block]] | None = None,
) -> _Format:
    """A format whose files may have several tables."""
    return _Format(lambda path, topic, progress: read(path, topic), topics, blocks)


_CSV = _one_table(read_csv, csv_blocks)
_HDF5 = _in_parts(read_hdf5, hdf5_topics, hdf5_blocks)
_ROS = _Format(read_ros, ros_topics)
_FORMATS = {
    ".csv": _CSV,
    ".txt": _CSV,
    ".tsv": _CSV,
    ".npy": _one_table(read_npy, npy_blocks),
    ".npz": _one_table(read_npz, npz_blocks),
    ".parquet": _one_table(read_parquet, parquet_blocks),
    ".mat": _in_parts(read_mat, mat_topics),
    ".h5": _HDF5,
    ".hdf5": _HDF5,
    ".bag": _ROS,
    ".mcap": _ROS,
    ".db3": _ROS,
    ".ulg": _in_parts(read_ulog, ulog_topics),
}


def is_recording(path: Path) -> bool:
    """Whether the name of a file is that of a type that `load` reads, or a folder a ROS 2 bag."""
    return _format(path) is not None


def read_table(path: Path, topic: str | None = None, progress: Progress | None = None) -> Table:
    """The columns of a file, or of its `topic`.

    **Raises** `RecordingError` when it cannot be read.
    """
    return _checked(path, lambda form: form.read(path, topic, progress))


def read_blocks(path: Path, samples: int, topic: str | None = None) -> Iterator[Block]:
    """The columns of a file, or of its `topic`, in blocks of about `samples` rows.

    Formats that cannot be read so are read as a whole first.

    **Raises** `RecordingError` when it cannot be read, perhaps after some blocks.
    """
    form = _checked(path, lambda form: form)

    def blocks() -> Iterator[Block]:
        if form.blocks is not None:
            return form.blocks(path, samples, topic)
        return table_blocks(form.read(path, topic, None), samples)

    found = _checked(path, lambda _: blocks())
    while (block := _checked(path, lambda _: next(found, None))) is not None:
        yield block


def contents(path: str | Path) -> tuple[Topic, ...]:
    """What a file holds: its topics, or itself as the only one, with channels, units and rates.

    **Raises** `RecordingError` when it cannot be read.
    """
    path = Path(path)
    return _checked(path, lambda form: form.topics(path))


def _format(path: Path) -> _Format | None:
    if path.is_dir():
        return _ROS if is_ros2_bag(path) else None
    if path.suffix.lower() == ".gz":
        found = _FORMATS.get(path.with_suffix("").suffix.lower())
        return found if found is _CSV else None
    return _FORMATS.get(path.suffix.lower())


def _checked(path: Path, read: Callable[[_Format], _Read]) -> _Read:
    try:
        found = _format(path)
        if not path.is_dir():
            require_file(path)
        elif found is None:
            raise RecordingError(
                f"{path} is a folder: give the file of a recording, or a ROS 2 bag."
            )
        if path.suffix.lower() in _SPREADSHEETS:
            raise RecordingError(
                f"{path.name} is a spreadsheet: export the sheet of the recording as CSV."
            )
        if found is None:
            raise RecordingError(
                f"{path.name}: the file type '{path.suffix}' is not known; a recording is a "
                f"{_KNOWN}, or the folder of a ROS 2 bag."
            )
        return read(found)
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror or error}.") from error
    except MemoryError as error:
        raise too_large(path) from error
