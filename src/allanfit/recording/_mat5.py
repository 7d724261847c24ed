"""What MAT-files of version 5 claim, found before SciPy takes their word for it.

SciPy crashes on types that do not exist and on cells nested without end, and makes room for
whatever a header announces. The layout is published: MAT-File Format, The MathWorks, chapter 1.
"""

import math
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ._files import refuse_bomb
from ._recording import RecordingError

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
# Cells, structures and objects; and those with functions and MATLAB's own.
_DIVIDED = (1, 2, 3)
_WITH_PARTS = (*_DIVIDED, 16, 17)
_CLASSES = range(1, 18)
_NUMBERS = (1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18)
_LONGEST_SHAPE = 1024
_DEEPEST = 32
# Cells and fields become objects, of which each takes a hundred times its bytes in the file.
_MOST_PARTS = 500_000
_CHUNK = 1 << 20

_Take = Callable[[int, bool], bytes]
"""Reads so many bytes; skips them, if they are not wanted."""


def check_mat5(path: Path) -> None:
    """Refuse a file that would crash SciPy or fill the memory.

    **Raises** `RecordingError` for variables that swell, or are nested or divided too far, and
    `EOFError`, `ValueError` or `zlib.error` for what is cut off or damaged.
    """
    check = _Check(path)
    end = path.stat().st_size
    with path.open("rb") as file:
        file.seek(_HEADER - 2)
        check.order = "<" if file.read(2) == b"IM" else ">"
        while file.tell() < end:
            check.element(file, end)


class _Check:
    """The parts and bytes of a file, counted."""

    def __init__(self, path: Path):
        self.path = path
        self.order = "<"
        self.parts = 0
        self.bytes = 0

    def element(self, file: BinaryIO, end: int) -> None:
        """Check the variable that begins here."""
        kind, size = struct.unpack(f"{self.order}II", _exactly(file.read, 8))
        if size > end - file.tell():
            raise EOFError
        stop = file.tell() + size
        if kind == _COMPRESSED:
            stream = _Inflated(file, size, self._count)
            inner, _, size = self._tag(stream.take)
            if inner == _MATRIX:
                self._matrix(stream.take, size, 0)
            stream.drain()
        elif kind == _MATRIX:

            def take(size: int, wanted: bool) -> bytes:
                if wanted:
                    return _exactly(file.read, size)
                file.seek(size, 1)
                return b""

            self._matrix(take, size, 0)
        file.seek(stop)

    def _count(self, size: int) -> None:
        self.bytes += size
        refuse_bomb(self.path, self.bytes)

    def _tag(self, take: _Take) -> tuple[int, bytes, int]:
        """The type of an element, its data where the tag holds it, and the bytes that follow."""
        tag = take(8, True)
        kind, size = struct.unpack(f"{self.order}II", tag)
        if kind >> 16:
            return kind & 0xFFFF, tag[4 : 4 + min(kind >> 16, 4)], 0
        return kind, b"", size

    def _matrix(self, take: _Take, size: int, depth: int) -> None:
        self.parts += 1
        if depth > _DEEPEST or self.parts > _MOST_PARTS:
            raise RecordingError(
                f"{self.path.name} nests or divides its cells and structures too far to be a "
                "recording: save arrays of numbers."
            )
        left, place, holds, flags = size, 0, 0, 0
        while left > 0:
            kind, small, size = self._tag(take)
            left -= 8
            padded = min(size + -size % 8, left)
            if size > left:
                raise EOFError
            left -= padded
            if kind == _MATRIX and holds in _WITH_PARTS:
                self._matrix(take, size, depth + 1)
                take(padded - size, False)
            else:
                data = small + take(padded, size <= _LONGEST_SHAPE)[:size]
                if place == 0:
                    (flags,) = struct.unpack_from(f"{self.order}I", data)
                    holds = flags & 0xFF
                elif place == 1 and holds in _DIVIDED:
                    parts = math.prod(np.frombuffer(data, f"{self.order}i4").tolist())
                    # Each takes 8 bytes at the least.
                    if parts > left // 8:
                        raise EOFError
                if kind not in _NUMBERS or holds not in _CLASSES:
                    raise ValueError("a part of it is of no known type")
            place += 1
        # What lacks here SciPy would take from the next variable, and crash on its type.
        if place and place < _fewest(flags):
            raise ValueError("a part of it is missing")


def _fewest(flags: int) -> int:
    """How many parts a variable has at the least: flags, shape, name, and what it holds."""
    holds, imaginary = flags & 0xFF, flags >> 11 & 1
    return {1: 3, 2: 5, 3: 6, 5: 6 + imaginary, 16: 3, 17: 3}.get(holds, 4 + imaginary)


class _Inflated:
    """A compressed variable, unpacked piece by piece and dropped."""

    def __init__(self, file: BinaryIO, size: int, count: Callable[[int], None]):
        self._file, self._left, self._count = file, size, count
        self._inflate = zlib.decompressobj()
        self._ready = b""

    def take(self, size: int, wanted: bool) -> bytes:
        """The next `size` bytes, or none of them if they are not wanted."""
        parts = []
        while size > 0:
            if not self._ready and not self._more():
                raise EOFError
            part, self._ready = self._ready[:size], self._ready[size:]
            size -= len(part)
            if wanted:
                parts.append(part)
        return b"".join(parts)

    def drain(self) -> None:
        """Unpack what is left."""
        while self._more():
            pass

    def _more(self) -> bool:
        packed = self._inflate.unconsumed_tail
        if not packed:
            packed = self._file.read(min(self._left, _CHUNK))
            self._left -= len(packed)
        self._ready = self._inflate.decompress(packed, _CHUNK)
        self._count(len(self._ready))
        return bool(self._ready) or bool(self._left)


def _exactly(read: Callable[[int], bytes], size: int) -> bytes:
    data = read(size)
    if len(data) < size:
        raise EOFError
    return data
