"""Writing a file so that it is there whole or not at all."""

import os
import sys
from pathlib import Path

from ..whole_file import replacing
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
    path = Path(os.path.realpath(target))
    # File names in odd encodings reach Python as lone surrogates, which UTF-8 cannot hold.
    content = text.encode("utf-8", errors="replace")
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)  # a device or a pipe cannot be replaced
        else:
            with replacing(path) as part:
                part.write_bytes(content)
    except OSError as error:
        raise ReportError(
            f"Cannot write {os.fspath(target)} ({error.strerror or error}): "
            "give a path in a folder that exists, is writable and has space."
        ) from error
