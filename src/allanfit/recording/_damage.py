"""What keeps damaged and hostile files from ending in a traceback or in all of the memory."""

import io
import threading
import warnings
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, closing, contextmanager, redirect_stdout
from pathlib import Path
from typing import TypeVar

from ._recording import RecordingError

_Item = TypeVar("_Item")
# Printing and warning belong to the whole process: of two threads, the second to leave would put
# back what the first had put there.
_ALONE = threading.RLock()


@contextmanager
def quiet() -> Iterator[None]:
    """Drop what a library prints or warns of; threads go in one after the other."""
    with _ALONE, redirect_stdout(io.StringIO()), warnings.catch_warnings(action="ignore"):
        yield


@contextmanager
def careful(path: Path, what: str) -> Iterator[None]:
    """Guard a library that reads `path`, a file said to be `what`, such as `a MAT-file`.

    What the library prints or warns of is dropped. Threads go in one after the other.

    **Raises** `RecordingError` in one sentence for whatever the library raises, apart from errors
    of the disk and of permission, which pass.
    """
    try:
        with quiet():
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


def each_guarded(
    guard: Callable[[], AbstractContextManager[None]], items: Generator[_Item, None, None]
) -> Iterator[_Item]:
    """The items of a generator, with `guard` about the making of each and not about its use.

    What is printed between two items is the caller's own.
    """
    with closing(items):
        while True:
            with guard():
                item = next(items, None)
            if item is None:
                return
            yield item
