"""ROS 1 bags chunk by chunk, with rosbags' reader but without its index of messages.

The index is an object for each message, which a recording of hours has no memory for. Its chunks
hold the messages in the order in which they came (http://wiki.ros.org/Bags/Format/2.0).
"""

import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ._recording import RecordingError
from ._unpack import unpacked_chunk

_LENGTH = struct.Struct("<I").unpack_from
_TIME = struct.Struct("<II").unpack
_MESSAGE = b"\2"


def ros1_reader(path: Path) -> Any:
    """A reader of rosbags that skips the index."""
    from rosbags.rosbag1 import Reader

    reader: Any = Reader(path)
    reader.read_index_data = lambda position, indexes: None
    return reader


def ros1_counts(reader: Any) -> Counter[int]:
    """How many messages there are of each connection."""
    counts = Counter()
    for chunk in reader.chunk_infos:
        counts.update(chunk.connection_counts)
    return counts


def ros1_messages(reader: Any, connections: set[int]) -> Iterator[tuple[int, bytes]]:
    """The time of receipt in ns and the bytes of each message of the `connections`."""
    for position, chunk in reader.chunks.items():
        reader.bio.seek(chunk.datapos)
        data = unpacked_chunk(reader.path, reader.bio.read(chunk.datasize), chunk.decompressor)
        at = 0
        while at < len(data):
            body = at + 4 + _LENGTH(data, at)[0]
            start = body + 4
            stop = start + _LENGTH(data, body)[0]
            if stop > len(data):
                raise RecordingError(f"the chunk at byte {position} is damaged")
            fields = _fields(data[at + 4 : body])
            if fields[b"op"] == _MESSAGE and _LENGTH(fields[b"conn"])[0] in connections:
                seconds, nanoseconds = _TIME(fields[b"time"])
                yield seconds * 1_000_000_000 + nanoseconds, data[start:stop]
            at = stop


def _fields(header: bytes) -> dict[bytes, bytes]:
    """`name=value` after `name=value`, each with its length before it."""
    fields, at = {}, 0
    while at < len(header):
        stop = at + 4 + _LENGTH(header, at)[0]
        name, _, value = header[at + 4 : stop].partition(b"=")
        fields[name] = value
        at = stop
    return fields
