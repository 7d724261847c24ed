"""Which reader a file belongs to, by its name."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from ._csv import read_csv
from ._files import require_file, too_large
from ._hdf5 import hdf5_topics, read_hdf5
from ._mat import mat_topics, read_mat
from ._npz import read_npy, read_npz
from ._parquet import read_parquet
from ._recording import RecordingError, Table
from ._ros import Progress, is_ros2_bag, read_ros, ros_topics
from ._topics import Topic, topic_of
from ._ulog import read_ulog, ulog_topics

_Read = TypeVar("_Read")

_KNOWN = ".csv, .csv.gz, .txt, .npy, .npz, .parquet, .mat, .h5, .bag, .mcap, .db3 or .ulg file"


@dataclass(frozen=True)
class _Format:
    """How to read a type of file."""

    read: Callable[[Path, str | None, Progress | None], Table]
    topics: Callable[[Path], tuple[Topic, ...]]


def _one_table(read: Callable[[Path], Table]) -> _Format:
    """A format whose files are one table."""

    def only(path: Path, topic: str | None, progress: Progress | None) -> Table:
        if topic is not None:
            raise RecordingError(f"{path.name} is one table without topics: leave --topic out.")
        return read(path)

    return _Format(only, lambda path: (topic_of(read(path)),))


def _in_parts(
    read: Callable[[Path, str | None], Table], topics: Callable[[Path], tuple[Topic, ...]]
) -> _Format:
    """A format whose files may have several tables."""
    return _Format(lambda path, topic, progress: read(path, topic), topics)


_CSV = _one_table(read_csv)
_HDF5 = _in_parts(read_hdf5, hdf5_topics)
_ROS = _Format(read_ros, ros_topics)
_FORMATS = {
    ".csv": _CSV,
    ".txt": _CSV,
    ".npy": _one_table(read_npy),
    ".npz": _one_table(read_npz),
    ".parquet": _one_table(read_parquet),
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


def contents(path: str | Path) -> tuple[Topic, ...]:
    """What a file holds: its topics, or itself as the only one, with channels, units and rates.

    **Raises** `RecordingError` when it cannot be read.
    """
    path = Path(path)
    return _checked(path, lambda form: form.topics(path))


def _format(path: Path) -> _Format | None:
    if path.is_dir():
        return _ROS if is_ros2_bag(path) else None
    if path.suffix == ".gz":
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
