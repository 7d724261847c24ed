"""The progress bar of the commands that take a while."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ..formatting import printable
from ..recording import Recording, load


class StoppedError(ValueError):
    """The user has stopped the command; its cause is the KeyboardInterrupt."""


@contextmanager
def _before_writing() -> Iterator[None]:
    """What is done before anything is written can be stopped without a trace, which is said."""
    try:
        yield
    except KeyboardInterrupt as stop:
        raise StoppedError("Interrupted; nothing was written.") from stop


def progress_bar() -> Progress:
    """A bar on stderr that vanishes when it is done; nothing where stderr is no terminal."""
    console = Console(stderr=True)
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )


def load_with_progress(
    path: Path,
    rate_hz: float | None,
    channels: list[str] | None,
    unit: str | None,
    topic: str | None,
) -> Recording:
    """`load`, with a bar for the formats whose messages are read one by one."""
    with reading(path) as progress:
        return load(
            path, rate_hz=rate_hz, channels=channels, unit=unit, topic=topic, progress=progress
        )


@contextmanager
def reading(path: Path) -> Iterator[Callable[[int, int], None]]:
    """What to call with how much of a file is read, and of how much."""
    with _before_writing(), progress_bar() as progress:
        task = progress.add_task(f"reading {path.name}", total=None)
        yield lambda read, whole: progress.update(task, completed=read, total=whole)


@contextmanager
def channel_by_channel(
    doing: str, channels: int
) -> Iterator[tuple[Callable[[str], None], Callable[[], None]]]:
    """What to call with each channel's name before its turn, and after it."""
    with _before_writing(), progress_bar() as progress:
        task = progress.add_task("reading", total=channels)

        def announce(name: str) -> None:
            progress.update(task, description=f"{doing} {printable(name)}")

        def done() -> None:
            progress.advance(task)

        yield announce, done
