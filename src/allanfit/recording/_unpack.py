"""Compressed pieces of a recording, unpacked no further than they may be."""

import bz2
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ._files import refuse_swelling
from ._recording import RecordingError

# More than any recorder packs together; most take a MB or less.
_LARGEST_CHUNK = 1 << 28


def unpacked(data: bytes, unpacker: Any, most: int) -> bytes:
    """What `unpacker`, of bz2's kind, makes of `data`.

    **Raises** `RecordingError` for more than `most` bytes, and for data that are cut off.
    """
    found = unpacker.decompress(data, most + 1)
    if len(found) > most or not unpacker.eof:
        raise RecordingError("a compressed piece of it is cut off or larger than it may be")
    return found


def unpacked_chunk(path: Path, data: bytes, decompress: Callable[[bytes], bytes]) -> bytes:
    """A chunk of a ROS 1 bag, packed as the function says that rosbags has for it.

    **Raises** `RecordingError` for a chunk that swells or is cut off.
    """
    import lz4.frame

    unpackers = {
        bz2.decompress: bz2.BZ2Decompressor,
        lz4.frame.decompress: lz4.frame.LZ4FrameDecompressor,
    }
    if decompress not in unpackers:
        return decompress(data)
    found = unpacked(data, unpackers[decompress](), _LARGEST_CHUNK)
    refuse_swelling(path, len(found))
    return found
