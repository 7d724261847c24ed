"""Workers: processes of this machine, or those of a scheduler that is running."""

import logging
import multiprocessing
import os
import re
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING

from ._errors import FleetError, fleet_extra

if TYPE_CHECKING:
    import distributed

_PATIENCE_S = 10  # for a scheduler to answer
_ADDRESS = re.compile(r"(?:\w+://)?\[?(?P<host>[^\s/\[\]]+?)\]?:(?P<port>\d+)")
_NOBODY = (
    "No scheduler answers at {}: start one with `dask scheduler` and give the address that it "
    "prints, such as tcp://10.0.0.5:8786."
)


@contextmanager
def connected(scheduler: str | None, workers: int | None) -> "Iterator[distributed.Client]":
    """A client of the scheduler at that address, or of `workers` processes started here.

    A worker is a process with one thread, so that it holds one recording at a time, and may take
    its share of the machine's memory. By default there is one a core.

    **Raises** `FleetError` if the scheduler cannot be reached.
    """
    with fleet_extra():
        import distributed
    if scheduler is not None:
        _knock(scheduler)
        with _client(distributed, scheduler) as client:
            yield client
        return
    with _started(distributed, workers) as cluster, _client(distributed, cluster) as client:
        yield client


@contextmanager
def _started(distributed, workers: int | None) -> "Iterator[distributed.LocalCluster]":
    """Processes of this machine, which end with this one, and not at a Ctrl-C of their own."""
    with _interrupts_held() as let_go:
        try:
            cluster = distributed.LocalCluster(
                n_workers=workers or _cores(),
                threads_per_worker=1,
                processes=True,
                dashboard_address="127.0.0.1:0",  # any port that is free
                silence_logs=logging.CRITICAL,
            )
        except RuntimeError as error:
            raise FleetError(
                "No worker process could be started. Each reads the script that calls run_fleet, "
                "if there is one: it has to do so below a line `if __name__ == '__main__':`."
            ) from error
        with cluster:
            let_go()
            yield cluster


@contextmanager
def _interrupts_held() -> Iterator[Callable[[], None]]:
    """Hold Ctrl-C back until what this gives is called, or the end.

    A terminal sends it to all processes of a command. Those started meanwhile hold it back for
    ever, and so do those that dask starts in place of a lost one, from a thread started meanwhile:
    it is for this process to end them.
    """
    if sys.platform == "win32":  # has no such masks
        yield lambda: None
        return
    # Left to start when it is needed, it would let interrupts through in the thread that does.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

    def let_go() -> None:
        # Where one waits it is raised here.
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

    try:
        yield let_go
    finally:
        let_go()


def leave_if_worker() -> None:
    """End this process where it is a worker that reads the script which started it.

    Such a script would start workers of workers; `connected` tells its user why.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)


def silence() -> None:
    """No logs of a cluster, in this process: what concerns the user is said by the command.

    Also what its threads would tell after the end.
    """
    with fleet_extra():
        import distributed  # noqa: F401  (sets the levels of its own)
    for name in ("distributed", "distributed.client", "tornado", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _cores() -> int:
    """The cores that this process may use, which a batch system may limit."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _knock(address: str) -> None:
    """A client that nobody answers stays behind and complains later: whether somebody does."""
    if address.startswith("inproc://"):
        return
    found = _ADDRESS.fullmatch(address)
    if found is None:
        raise FleetError(
            f"{address!r:.60} is no address of a scheduler: give the one that `dask scheduler` "
            "prints, such as tcp://10.0.0.5:8786."
        )
    try:
        socket.create_connection((found["host"], int(found["port"])), _PATIENCE_S).close()
    except (OSError, OverflowError) as error:
        raise FleetError(_NOBODY.format(address)) from error


def _client(distributed, where) -> "distributed.Client":
    try:
        return distributed.Client(where, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise FleetError(_NOBODY.format(where)) from error
