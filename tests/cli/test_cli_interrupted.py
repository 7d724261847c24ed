"""Ctrl-C: one line and status 130, whenever it comes."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from allanfit import _interrupt
from allanfit._interrupt import is_program
from allanfit.cli import main

TOLD = "allanfit: Interrupted; nothing was written.\n"


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "gyro.npz"
    np.savez(path, gyro_x=np.random.default_rng(1).standard_normal(4096), rate_hz=50.0)
    return path


@pytest.fixture
def script(tmp_path):
    """The command as pip installs it."""
    path = tmp_path / "allanfit"
    path.write_text("import sys\nfrom allanfit.cli import run\nsys.exit(run())\n")
    return path


@pytest.mark.parametrize("module", [True, False])
@pytest.mark.parametrize("loaded", ["numpy", "jax._src"])
def test_while_it_loads(script, module, loaded):
    command = ["-m", "allanfit"] if module else [str(script)]
    process = subprocess.Popen(
        [sys.executable, "-X", "importtime", *command, "fit", "none.npz"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    for line in process.stderr:
        if f"| {loaded}" in line.replace("  ", ""):
            break
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    told = [line for line in err.splitlines() if "import time:" not in line]
    assert (out, told) == ("", [TOLD.strip()])


@pytest.mark.parametrize("command", ["fit", "explain"])
@pytest.mark.parametrize("place", ["reading", "working"])
def test_while_it_reads_and_works(command, place, recording, monkeypatch, tmp_path, capsys):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    module, name = "allanfit.cli._progress", "load"
    if place == "working":
        module, name = {
            "fit": ("allanfit.cli", "fit_recording"),
            "explain": ("allanfit.explain", "explain_recording"),
        }[command]
    # By name, since the package's `explain` is the function.
    monkeypatch.setattr(sys.modules[module], name, interrupted)
    target = tmp_path / "out.json"
    assert main([command, str(recording), "--json", str(target)]) == 130
    assert capsys.readouterr() == ("", TOLD)
    assert not target.exists()


@pytest.mark.parametrize("where", ["contents", "configure_program"])
def test_elsewhere(where, recording, monkeypatch, capsys):
    """What a command has written by then is not known."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"allanfit.cli.{where}", interrupted)
    assert main(["fit", str(recording), "--list"]) == 130
    assert capsys.readouterr() == ("", "allanfit: Interrupted.\n")


def test_what_is_swallowed_comes_again():
    """As JAX's callback of the garbage collector swallows it; at once, if threads take signals."""
    code = f"""
import gc, importlib.util, time
spec = importlib.util.spec_from_file_location("interrupt", {_interrupt.__file__!r})
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
module.interrupts_at_work()
def swallowing(phase, info):
    gc.callbacks.clear()
    raise KeyboardInterrupt
gc.callbacks.append(swallowing)
begin = time.monotonic()
try:
    gc.collect()
    time.sleep(30)
except KeyboardInterrupt:
    print("again", "at once" if time.monotonic() - begin < 10 else "late")
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    when = "at once" if hasattr(signal, "pthread_kill") else "late"
    assert (done.stdout, done.stderr) == (f"again {when}\n", "")


@pytest.mark.parametrize(
    ("argv", "started_as", "expected"),
    [
        (["-m"], ["python", "-m", "allanfit", "fit", "x"], True),
        (["-m"], ["python", "-X", "dev", "-m", "allanfit"], True),
        (["/bin/allanfit", "fit"], ["python", "/bin/allanfit", "fit"], True),
        # What imports allanfit: another module or script, a shell, and a worker of the command.
        (["-m"], ["python", "-m", "other", "allanfit"], False),
        (["study.py"], ["python", "study.py"], False),
        (["-c"], ["python", "-c", "import allanfit"], False),
        (["/bin/allanfit"], ["python", "-c", "from multiprocessing.spawn import x"], False),
        ([""], ["python"], False),
        ([], ["python"], False),
    ],
)
def test_only_the_command_itself_takes_signals(argv, started_as, expected):
    assert is_program(argv, started_as) == expected
    assert signal.getsignal(signal.SIGINT) is not _interrupt._end_at_once


def test_a_background_job_of_a_shell_ignores_it_still(script):
    """A shell has its background jobs ignore what is meant for those in front."""
    command = f"trap '' INT; exec {sys.executable} -X importtime {script} --version"
    process = subprocess.Popen(
        ["sh", "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    for line in process.stderr:
        if "numpy" in line:
            break
    os.kill(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert out.startswith("allanfit ")
