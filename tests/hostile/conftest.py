"""How a refusal looks, whatever was refused."""

import re
import resource
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from allanfit.cli import main

# Where the writers of the formats are.
sys.path.append(str(Path(__file__).parents[1] / "recording"))

# Refusing takes a fraction of a second; a machine that is busy may take longer.
_PATIENCE_S = 20
_MOST_KB = 600_000


class Hung(BaseException):
    """Not an Exception, so that no handler of the program hides it."""


def _hung(*_: object) -> None:
    raise Hung


def everything(folder: Path) -> set[tuple[str, int]]:
    """Names and sizes of all that is in a folder."""
    return {(str(path), path.lstat().st_size) for path in folder.rglob("*")}


@pytest.fixture
def refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    """Run the command line; status 1, one clean line in time and memory, and nothing left behind.

    Returns the line.
    """
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> str:
        before = everything(tmp_path)
        handler = signal.signal(signal.SIGALRM, _hung)
        signal.alarm(_PATIENCE_S)
        most_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        try:
            status = main(arguments)
        finally:
            signal.alarm(0)
            signal.signal(signal.SIGALRM, handler)
        out, err = capsys.readouterr()
        assert (status, out) == (1, ""), (status, out, err)
        assert err.endswith("\n")
        line = err[:-1]
        assert line.isprintable(), line
        assert re.match(r"allanfit: \S.*[.!?]$", line), line
        assert len(line) < 700, line
        assert everything(tmp_path) == before
        most_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - most_kb
        assert most_kb < _MOST_KB
        return line

    return run
