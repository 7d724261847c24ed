"""All recordings of a fleet, each once, in whatever order the workers take them."""

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from ._cluster import connected, leave_if_worker
from ._errors import FleetError, fleet_extra
from ._files import find_recordings
from ._options import Options
from ._rows import Row
from ._store import Store, holds_results, known_checksum, still_good
from ._task import Outcome, Task, analyse, failed

if TYPE_CHECKING:
    import distributed

_POLL_S = 0.1
# A cluster that grows when there is work has no worker at first.
_PATIENCE_S = 5.0


@dataclass(frozen=True)
class FleetRun:
    """What a run did, and the rows of its recordings, those of earlier runs among them."""

    recordings: tuple[Path, ...]
    rows: tuple[Row, ...]
    analysed: int
    """Recordings that this run analysed, or tried to."""
    unchanged: int
    """Recordings whose results were there already."""
    kept: tuple[tuple[Path, str], ...]
    """Recordings that could not be read again, whose earlier results stay, and why."""
    others: int
    """Recordings of earlier runs in the same folder that this run was not asked for."""
    failed: int = 0
    """How many of those that this run tried came to an error."""

    @property
    def errors(self) -> tuple[tuple[Path, str], ...]:
        """Recordings that could not be analysed, and why."""
        return tuple((Path(row["path"]), row["error"]) for row in self.rows if row["error"])


def run_fleet(
    files: Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    options: Options | None = None,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda recordings: None,
    done: Callable[[Path], None] = lambda recording: None,
    waiting: Callable[[str], None] = lambda sentence: None,
) -> FleetRun:
    """Fit many recordings side by side, each with a part of a Parquet dataset as its result.

    A recording that cannot be analysed is a row with its error, and the others go on. What has a
    result by the same options and version, and has not changed since (by SHA-256), is not done
    again, so that a run that was stopped in any way goes on where it was.

    **Arguments:**

    - `files`: recordings, folders of them, or patterns.
    - `output`: a folder; results go to `results` in it, one `.parquet` a recording.
    - `options`: of the fit, the same for all.
    - `scheduler`: the address of a dask scheduler; by default `workers` processes are started
      here, one a core, and a script that calls this does so below `if __name__ == "__main__":`,
      since each of them reads it. Workers elsewhere read recordings by their path.
    - `begin`, `done`: called with the number of recordings, and with each when it is done.
    - `waiting`: called with a sentence when there is no worker, which may come late or all be lost.

    **Raises** `FleetError` if there are no recordings, the folder cannot be written, no
    worker can be started, or the scheduler cannot be reached or is lost; and when it is
    interrupted.
    """
    leave_if_worker()
    with fleet_extra():
        import pyarrow.parquet  # noqa: F401 - found to be missing before the work
    if scheduler is not None and workers is not None:
        raise FleetError("The number of workers is the scheduler's: leave out --workers.")
    store = Store(Path(output).absolute())
    recordings = find_recordings(files, store.parts)
    options = options or Options()
    tasks = [_task(path, options, store, elsewhere=scheduler is not None) for path in recordings]
    begin(len(tasks))
    analysed, unchanged, failures, kept = 0, 0, 0, []
    try:
        with connected(scheduler, workers) as client:
            for outcome in _outcomes(client, tasks, waiting):
                if outcome.rows is None:
                    unchanged += 1
                elif _worse(outcome, store, options):
                    kept.append((outcome.path, str(outcome.error)))
                else:
                    store.write(outcome.path, outcome.rows)
                    analysed += 1
                    failures += outcome.error is not None
                done(outcome.path)
    except (KeyboardInterrupt, CancelledError) as stop:
        finished = analysed + unchanged + len(kept)
        what = "Interrupted" if isinstance(stop, KeyboardInterrupt) else "The scheduler is lost"
        raise FleetError(
            f"{what} with {finished} of {len(tasks)} recordings done; they are kept, and the same "
            "command goes on from there."
        ) from stop
    rows = tuple(store.read_all(recordings))
    others = store.others(recordings)
    return FleetRun(recordings, rows, analysed, unchanged, tuple(kept), others, failures)


def _task(path: Path, options: Options, store: Store, elsewhere: bool) -> Task:
    rows, ours = store.read(path), version("allanfit")
    known = known_checksum(rows) if still_good(rows, options.to_json(), ours) else None
    return Task(path, options, ours, known, elsewhere)


def _worse(outcome: Outcome, store: Store, options: Options) -> bool:
    """Whether a passing failure would take the place of a good result."""
    if outcome.final:
        return False
    rows = store.read(outcome.path)
    return holds_results(rows) and still_good(rows, options.to_json(), version("allanfit"))


def _outcomes(
    client: "distributed.Client", tasks: Iterable[Task], waiting: Callable[[str], None]
) -> Iterator[Outcome]:
    """Outcomes as they come.

    **Raises** `CancelledError` when the scheduler is lost.
    """
    from distributed import as_completed

    submitted = {client.submit(analyse, task, pure=False): task for task in tasks}
    ready = as_completed(list(submitted), loop=client.loop)
    while submitted:
        _await_one(client, ready, waiting)
        future = next(ready)
        task = submitted.pop(future)
        if future.status == "cancelled":
            raise CancelledError
        error = future.exception()
        yield future.result() if error is None else failed(task, _no_worker(task, error))
        # The scheduler keeps a result as long as somebody holds its future.
        future.release()


def _await_one(
    client: "distributed.Client",
    ready: "distributed.as_completed",
    waiting: Callable[[str], None],
) -> None:
    """Until a task is done; says once if nobody is there to do it."""
    began, said = time.monotonic(), False
    while not ready.has_ready():
        time.sleep(_POLL_S)
        if not said and time.monotonic() - began > _PATIENCE_S:
            began = time.monotonic()
            # One that does not answer is lost, which the tasks themselves tell.
            with suppress(OSError):
                said = not client.nthreads()
            if said:
                waiting(
                    "The scheduler has no worker: start one with `dask worker` and its address; "
                    "the recordings wait."
                )


def _no_worker(task: Task, error: BaseException) -> str:
    """Why no worker could do a task: its own errors are in its outcome."""
    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        return (
            f"{task.path.name}: every worker that took it died, as when memory runs out: give "
            "the workers more, by fewer of them (--workers), or divide the recording."
        )
    return f"{task.path.name}: {type(error).__name__}: {' '.join(str(error).split())}"
