"""What a worker does: one recording, read and fitted."""

import hashlib
import socket
import warnings
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path

from ..compilation import configure_program
from ..identify import fit_recording
from ..recording import load
from ._options import Options
from ._rows import Row, row_of_error, rows_of_fit, stamped


@dataclass(frozen=True)
class Task:
    """A recording to be analysed, unless it is the one whose result is there."""

    path: Path
    options: Options
    version: str
    """Of allanfit, as it is where the command runs."""
    known: str | None
    """SHA-256 of the file whose result by these options and this version is there."""
    elsewhere: bool
    """Whether the worker may be on a machine that has other disks."""


@dataclass(frozen=True)
class Outcome:
    """What came of a task."""

    path: Path
    rows: tuple[Row, ...] | None
    """None if the result that is there is still good."""

    @property
    def error(self) -> str | None:
        """Why the recording could not be analysed, None if it was."""
        return None if self.rows is None else self.rows[0].get("error")

    @property
    def final(self) -> bool:
        """Whether the same file would lead to the same rows another time."""
        return self.rows is None or self.rows[0]["file_sha256"] is not None


def analyse(task: Task) -> Outcome:
    """Fit a recording; what is wrong with it is told in its row, and nothing is raised for it.

    **Raises** `RuntimeError` if the worker has another version of allanfit than the command.
    """
    if version("allanfit") != task.version:
        raise RuntimeError(
            f"the worker on {socket.gethostname()} has allanfit {version('allanfit')} and this "
            f"command {task.version}: install one version everywhere"
        )
    _configure_once()
    try:
        file_sha256 = _checksum(task.path)
    except OSError as error:
        return failed(task, _unreadable(task, error))
    if file_sha256 == task.known:
        return Outcome(task.path, None)
    try:
        with warnings.catch_warnings(action="ignore"):
            rows = _rows(task)
    except ValueError as error:
        # A disk that failed may do better another time; a file that is wrong stays so.
        final = not isinstance(error.__cause__, OSError)
        return failed(task, _one_line(error), file_sha256 if final else None)
    # Memory, disks and our own mistakes: another time it may go well.
    except Exception as error:
        return failed(task, f"{task.path.name}: {type(error).__name__}: {_one_line(error)}")
    return Outcome(task.path, tuple(_stamped(task, rows, file_sha256)))


def failed(task: Task, error: str, file_sha256: str | None = None) -> Outcome:
    """A row with the error; it is final where the file is at fault and its checksum is given."""
    rows = _stamped(task, [row_of_error(task.path, error)], file_sha256)
    return Outcome(task.path, tuple(rows))


@cache
def _configure_once() -> None:
    configure_program()


def _checksum(path: Path) -> str:
    if path.is_dir():
        # A ROS 2 bag: its files by name, one after the other.
        inside = sorted(each for each in path.iterdir() if each.is_file())
        told = "".join(f"{each.name} {_checksum(each)}\n" for each in inside)
        return hashlib.sha256(told.encode()).hexdigest()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _rows(task: Task) -> list[Row]:
    options = task.options
    recording = load(
        task.path,
        rate_hz=options.rate_hz,
        channels=options.channels,
        unit=options.unit,
        topic=options.topic,
    )
    result = fit_recording(
        recording,
        posterior=False,
        sampling=options.sampling,
        temperature=options.temperature,
        pieces="misfits",
        seed=options.seed,
    )
    return rows_of_fit(task.path, result)


def _stamped(task: Task, rows: list[Row], file_sha256: str | None) -> list[Row]:
    options = task.options.to_json()
    return stamped(rows, file_sha256=file_sha256, options=options, version=task.version)


def _unreadable(task: Task, error: OSError) -> str:
    place = f" on the worker {socket.gethostname()}" if task.elsewhere else ""
    advice = (
        ": workers read recordings by their path, so keep them where all machines see them"
        if task.elsewhere
        else ""
    )
    if isinstance(error, FileNotFoundError):
        return f"There is no file {task.path}{place}{advice}."
    return f"{task.path} cannot be read{place} ({error.strerror or error}){advice}."


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
