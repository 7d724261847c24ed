"""Files that are there whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path in the same folder, which takes the place of `path` at the end.

    A reader never sees half a file, and a failure leaves the old one as it was. A link keeps
    pointing where it did: what it points to is replaced.
    """
    # Unlike `Path.resolve`, it takes links that lead in a ring.
    path = Path(os.path.realpath(path))
    # The process number keeps two runs apart; `tempfile` would make the file private to its
    # owner, where a plain `open` follows the user's umask.
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield part
        with part.open("rb+") as stream:
            os.fsync(stream.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
