"""Ctrl-C, from the program's first moment on.

Importing this is enough where allanfit is the program; in any other, signals are left alone.
"""

import _thread
import os
import signal
import sys
import threading
from itertools import pairwise
from types import FrameType

#: The exit status of what was interrupted, as shells say it.
INTERRUPTED = 130
# What swallows an interrupt is done by then [s].
_AGAIN_S = 0.05


def is_program(argv: list[str], started_as: list[str]) -> bool:
    """Whether these are `sys.argv` and `sys.orig_argv` of the command, not of its workers.

    While a package is imported for `python -m`, its name stands in the second alone.
    """
    command = argv[0] if argv else ""
    if command == "-m":
        return ("-m", "allanfit") in pairwise(started_as)
    return os.path.basename(command) in ("allanfit", "allanfit.exe") and command in started_as


def interrupts_at_work() -> None:
    """From now on Ctrl-C raises KeyboardInterrupt, for what is at work to tidy up.

    Where that is swallowed, as by what JAX has the garbage collector call, it is raised again.
    """
    if signal.getsignal(signal.SIGINT) is _end_at_once:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.unraisablehook = _raise_again


def _end_at_once(number: int, frame: FrameType | None) -> None:
    """Nothing has begun, and an interrupt amid an import would come out as anything."""
    os.write(2, b"allanfit: Interrupted; nothing was written.\n")
    os._exit(INTERRUPTED)


def _raise_again(ignored: "sys.UnraisableHookArgs") -> None:
    if not issubclass(ignored.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(ignored)
        return
    timer = threading.Timer(_AGAIN_S, _interrupt_again)
    timer.daemon = True
    timer.start()


def _interrupt_again() -> None:
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        # A signal to the thread itself ends what it waits for.
        signal.pthread_kill(main, signal.SIGINT)
    else:
        _thread.interrupt_main()


# A shell's background jobs ignore it, and shall.
if (
    is_program(sys.argv, sys.orig_argv)
    and signal.getsignal(signal.SIGINT) is signal.default_int_handler
):
    signal.signal(signal.SIGINT, _end_at_once)
