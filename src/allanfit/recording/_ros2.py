"""What rosbags does not look after in bags of ROS 2: files that swell and files left unfinished."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from ._files import refuse_swelling
from ._recording import RecordingError
from ._unpack import unpacked

_PIECE = 1 << 24
# Of a message that is packed for itself.
_LONGEST = 1 << 16


def refuse_unfinished(path: Path) -> None:
    """Refuse SQLite files whose last messages are still in a journal, or whose name misleads.

    **Raises** `RecordingError` saying what to do.
    """
    for file in path.glob("*.db3") if path.is_dir() else [path]:
        if file.suffix != ".db3":
            continue
        misleading = [mark for mark in "?#%" if mark in str(file)]
        if misleading:
            # SQLite would open a file of another name, and say nothing.
            raise RecordingError(
                f"{file} has a {misleading[0]} in its path, which SQLite takes for a command: "
                "rename the file or its folder."
            )
        for journal in (Path(f"{file}-wal"), Path(f"{file}-journal")):
            if journal.is_file() and journal.stat().st_size:
                raise RecordingError(
                    f"{file.name} was not closed, and {journal.name} beside it holds messages of "
                    f"its own: let SQLite put them together, `sqlite3 {file.name} "
                    "'PRAGMA wal_checkpoint(TRUNCATE); VACUUM;'`."
                )


def refuse_swelling_files(path: Path) -> None:
    """Refuse a folder whose files, packed as wholes, swell; they are unpacked to be counted.

    **Raises** `RecordingError` when they do.
    """
    zstd = _zstd()
    size = 0
    for file in path.glob("*.zstd") if path.is_dir() else ():
        with zstd.open(file) as stream:
            while piece := stream.read(_PIECE):
                size += len(piece)
                refuse_swelling(path, size)


@contextmanager
def chunks_within_bounds(path: Path) -> Iterator[None]:
    """Let rosbags unpack chunks of MCAP to the size that they state, if it is bearable.

    Its functions are replaced for the whole process: only within `careful`, where a thread is
    alone.
    """
    import lz4.frame
    from rosbags.rosbag2 import storage_mcap

    zstd = _zstd()

    before = dict(storage_mcap.DECOMPRESSORS)
    total = 0

    def within(make: Callable[[], Any]) -> Callable[[bytes, int], bytes]:
        def unpack(data: bytes, size: int) -> bytes:
            nonlocal total
            total += size
            refuse_swelling(path, total)
            return unpacked(data, make(), size)

        return unpack

    storage_mcap.DECOMPRESSORS.update(
        lz4=within(lz4.frame.LZ4FrameDecompressor),
        zstd=within(zstd.ZstdDecompressor),
    )
    try:
        yield
    finally:
        storage_mcap.DECOMPRESSORS.update(before)


def messages_apart(reader: Any) -> Callable[[bytes], bytes]:
    """What unpacks a message, where each is packed for itself; rosbags then leaves it as it is."""
    zstd = _zstd()
    bag = reader.storage
    if bag.metadata.compression_mode == "message":
        bag.metadata = bag.metadata._replace(compression_mode="packed")
    if bag.metadata.compression_mode == "packed":
        return lambda message: unpacked(message, zstd.ZstdDecompressor(), _LONGEST)
    return lambda message: message


def _zstd() -> Any:
    """The module that rosbags uses: Python's own since 3.14."""
    return import_module("rosbags.rosbag2.storage_mcap").zstd
