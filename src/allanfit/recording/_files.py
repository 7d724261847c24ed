"""Files that can be read at all: plain, not empty, and of a size that memory holds."""

import os
from pathlib import Path

from ._recording import RecordingError

# Less than this does no harm, however small the file is that it comes from.
_HARMLESS = 1 << 28
# Samples hold noise, and noise does not shrink as far as this.
_MOST_TIMES = 200


def require_file(path: Path) -> None:
    """Find out before reading that `path` is a file, has something in it, and is not too large.

    **Raises** `RecordingError` saying which, and `OSError` when the disk does not answer.
    """
    if path.is_dir():
        raise RecordingError(f"{path} is a folder: give a file.")
    if not path.exists():
        raise RecordingError(f"There is no file {path}.")
    if not path.is_file():
        # It might never end, or never begin.
        raise RecordingError(f"{path} is not a plain file: copy what it gives to one first.")
    size = path.stat().st_size
    if size == 0:
        raise RecordingError(f"{path.name} is empty.")
    if size > _memory():
        raise too_large(path)


def refuse_bomb(path: Path, unpacked: int) -> None:
    """Stop before `unpacked` bytes, so far or in all, fill the memory.

    A damaged header, or a file compressed to do harm, may announce anything.

    **Raises** `RecordingError` for what swells, and for more than there is memory.
    """
    refuse_swelling(path, unpacked)
    if unpacked > _memory():
        raise too_large(path)


def refuse_swelling(path: Path, unpacked: int) -> None:
    """Stop when a file or folder comes to `unpacked` bytes, so far or in all, from few.

    **Raises** `RecordingError` for more than 256 MiB and 200 times its size, which only a file
    made to do harm needs.
    """
    if unpacked <= _HARMLESS:
        return
    packed = path.rglob("*") if path.is_dir() else [path]
    if unpacked > _MOST_TIMES * sum(each.stat().st_size for each in packed if each.is_file()):
        raise RecordingError(
            f"{path.name} swells to more than {_MOST_TIMES} times its size, as no recording does: "
            "if it is one, unpack it yourself and give what comes out."
        )


def too_large(path: Path) -> RecordingError:
    """The error for more than the memory holds."""
    return RecordingError(
        f"{path.name} needs more memory than this machine has: divide the recording, or choose "
        "fewer channels."
    )


def _memory() -> float:
    """Bytes of memory, infinite where the system does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")
