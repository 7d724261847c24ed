"""Processes that are really killed, and the run that goes on after them.

A named pipe in place of a recording holds a worker for as long as the test needs: what is killed
is killed in the middle of the work, on any machine. There are two workers, since tasks come in any
order: the other one does the rest.
"""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import polars
import psutil
import pytest
from fleet_recordings import write_recording

from allanfit.fleet import run_fleet

_PATIENCE_S = 300
_COMMAND = [sys.executable, "-c", "from allanfit.cli import run; run()", "fleet"]


def wait_for(condition):
    """Come back with the first true value of the condition."""
    end = time.monotonic() + _PATIENCE_S
    while not (value := condition()):
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)
    return value


@pytest.fixture
def start(tmp_path):
    """Start a program in a process group of its own, killed at the end if it still runs."""
    started = []
    # Small programs too are taken from the folder that the tests share.
    environment = os.environ | {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}

    def launch(*command):
        with (tmp_path / f"{len(started)}.log").open("wb") as log:
            process = subprocess.Popen(
                command, stderr=log, stdout=log, start_new_session=True, env=environment
            )
        process.log = tmp_path / f"{len(started)}.log"
        started.append(process)
        return process

    yield launch
    for process in started:
        for child in [*_children(process), process]:
            child.kill()
        process.wait()


@pytest.fixture
def files(recordings):
    """The recordings, and a pipe that holds the worker which opens it."""
    pipe = recordings[0].with_name("unit_3.npz")
    os.mkfifo(pipe)
    return [*recordings, pipe]


def _children(process):
    try:
        return psutil.Process(process.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []


def _parts(output):
    return {path: path.stat().st_mtime_ns for path in (output / "results").glob("*.parquet")}


def _let_go(files):
    """Put a recording in place of the pipe; who holds the pipe open goes on waiting."""
    write_recording(files[2].with_name("new.npz"), seed=3).replace(files[2])


def _two_done(output):
    """The parts of the first two; the third task is the only one left, and cannot end."""
    return wait_for(lambda: (done := _parts(output)) and len(done) == 2 and done)


def _held(pipe):
    """A descriptor, once a worker has the pipe open; None before."""
    try:
        return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
    except OSError:
        return None


def _holder(command, pipe):
    """The worker that has the pipe open, once it has."""
    for child in _children(command):
        with suppress(OSError):
            if any(
                os.path.samefile(each, pipe) for each in Path(f"/proc/{child.pid}/fd").iterdir()
            ):
                return child
    return None


def _complete(output):
    data = polars.read_parquet(output / "results" / "*.parquet")
    return sorted(data["recording"]) == ["unit_1.npz", "unit_2.npz", "unit_3.npz"]


def test_a_killed_worker_is_replaced_and_a_killed_command_goes_on_where_it_was(
    files, tmp_path, start, scheduler
):
    """The worker while the pipe holds it, and the command while the next one is held."""
    output = tmp_path / "fleet"
    command = start(*_COMMAND, *map(str, files), "--output", str(output), "--workers", "2")
    before = _two_done(output)
    held = wait_for(lambda: _held(files[2]))
    worker = wait_for(lambda: _holder(command, files[2]))
    worker.kill()
    # The one in its place takes up what it was at.
    wait_for(lambda: (found := _holder(command, files[2])) and found.pid != worker.pid)
    assert "Traceback" not in command.log.read_text()
    workers = _children(command)
    command.kill()
    command.wait(_PATIENCE_S)
    os.close(held)
    # No worker outlives its command.
    wait_for(lambda: not any(each.is_running() for each in workers))
    _let_go(files)
    run = run_fleet(files, output, scheduler=scheduler)
    assert (run.analysed, run.unchanged) == (1, 2)
    assert before.items() <= _parts(output).items()
    assert _complete(output)


def test_an_interrupted_command_says_how_to_go_on(files, tmp_path, start):
    pipe = files[2]
    command = start(*_COMMAND, str(pipe), "--output", str(tmp_path / "fleet"), "--workers", "1")
    held = wait_for(lambda: _held(pipe))
    workers = _children(command)
    # A worker leaves it to the command: dask would tell of each that is interrupted by itself.
    worker = wait_for(lambda: _holder(command, pipe))
    worker.send_signal(signal.SIGINT)
    # As a terminal does: to the command and its workers alike.
    os.killpg(command.pid, signal.SIGINT)
    assert command.wait(_PATIENCE_S) == 130
    os.close(held)
    told = command.log.read_text()
    assert "allanfit: Interrupted with 0 of 1 recordings done; they are kept" in told
    assert len(told.splitlines()) == 1, told
    wait_for(lambda: not any(each.is_running() for each in workers))


def test_a_killed_scheduler_is_said_and_another_goes_on(files, tmp_path, start, scheduler):
    output, address_file = tmp_path / "fleet", tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    quiet = ["--no-dashboard", "--host", "127.0.0.1"]
    boss = start(*dask, "scheduler", *quiet, "--port", "0", "--scheduler-file", str(address_file))
    wait_for(lambda: address_file.exists() and address_file.read_text().strip().endswith("}"))
    address = json.loads(address_file.read_text())["address"]
    for _ in range(2):
        start(*dask, "worker", *quiet, address, "--nthreads", "1", "--no-nanny")
    command = start(
        *_COMMAND, *map(str, files), "--output", str(output), "--scheduler", address
    )  # fmt: skip
    before = _two_done(output)
    boss.kill()
    assert command.wait(_PATIENCE_S) == 1
    told = command.log.read_text()
    assert "allanfit: The scheduler is lost with 2 of 3 recordings done" in told
    assert len(told.splitlines()) == 1, told
    _let_go(files)
    run = run_fleet(files, output, scheduler=scheduler)
    assert (run.analysed, run.unchanged) == (1, 2)
    assert before.items() <= _parts(output).items()
    assert _complete(output)
