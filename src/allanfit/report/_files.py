"""Writing a file so that it is there whole or not at all."""

import os
import sys
from pathlib import Path

from ._errors import ReportError


def write_whole(text: str, target: str | os.PathLike[str]) -> None:
    """Write `text` as UTF-8 to a path, or to standard output for "-".

    The text goes to a temporary file in the same folder, which then takes the target's name: a
    reader never sees half a file, and a failure leaves the old one as it was.

    **Raises** `ReportError` when the file cannot be written.
    """
    if os.fspath(target) == "-":
        sys.stdout.write(text)
        return
    # A link keeps pointing where it did: what it points to is replaced.
    path = Path(target).resolve()
    # File names in odd encodings reach Python as lone surrogates, which UTF-8 cannot hold.
    content = text.encode("utf-8", errors="replace")
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)  # a device or a pipe cannot be replaced
        else:
            _replace(content, path)
    except OSError as error:
        raise ReportError(
            f"Cannot write {os.fspath(target)} ({error.strerror or error}): "
            "give a path in a folder that exists, is writable and has space."
        ) from error


def _replace(content: bytes, path: Path) -> None:
    # The process number keeps two runs apart; `tempfile` would make the report private to its
    # owner, where a plain `open` follows the user's umask.
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
