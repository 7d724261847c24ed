"""What keeps damaged and hostile files from ending in a traceback or in all of the memory."""

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

from ._recording import RecordingError


@contextmanager
def careful(path: Path, what: str) -> Iterator[None]:
    """Guard a library that reads `path`, a file said to be `what`, such as `a MAT-file`.

    What the library prints or warns of is dropped.

    **Raises** `RecordingError` in one sentence for whatever the library raises, apart from errors
    of the disk and of permission, which pass.
    """
    try:
        with redirect_stdout(io.StringIO()), warnings.catch_warnings(action="ignore"):
            yield
    except (RecordingError, FileNotFoundError, PermissionError, IsADirectoryError):
        raise
    except MemoryError as error:
        raise RecordingError(
            f"{path.name} needs more memory to read than there is: cut it into pieces."
        ) from error
    # On bytes that are not what they should be, parsers raise what they come across.
    except Exception as error:
        reason = " ".join(str(error).split())
        told = f" ({reason:.120})" if " " in reason else ""
        raise RecordingError(
            f"{path.name} is not {what} that can be read{told}: it may be cut off, damaged or of "
            "another kind."
        ) from error
