"""How long JAX compiles: settings of programs that start, compute and end, and of single functions.

A library leaves JAX's settings alone; the command line, the workers of a fleet and the tests, which
are programs, call `configure_program` or what it calls.
"""

import gc
import os
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from functools import cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
from jax.core import Tracer

# What it leaves out takes as long as the rest of compiling, and gains nothing in a program that
# ends within the minute.
_FEWER_OPTIMISATIONS = ("xla_backend_optimization_level", 1)
# XLA's newer way to write fused loops, which takes twice as long and makes them no faster here.
_OLDER_LOOPS = ("xla_cpu_use_fusion_emitters", False)
# Flags come and go, and one that XLA does not know ends the process: releases that know this one.
_KNOW_OLDER_LOOPS = ((0, 7), (0, 11))

# The programs of one fit take less than a megabyte; every new length adds a part of that.
_MOST_BYTES = 256 * 2**20


def configure_program() -> None:
    """Float64, and compiled programs kept for the user, in a process that is ours."""
    # It comes with the extras that make programs.
    from platformdirs import user_cache_path

    jax.config.update("jax_enable_x64", True)
    wait_less()
    shorten_compilation(user_cache_path("allanfit") / "compiled")


def wait_less() -> None:
    """Settings for many small computations."""
    # Each waits for the last: to wake another thread, on another core, takes longer than they do.
    jax.config.update("jax_cpu_enable_async_dispatch", False)
    # Tracing makes hundred thousands of objects that stay, and Python's usual numbers, 700, 10 and
    # 10, have it look for garbage among them a thousand times in a `fit`.
    gc.set_threshold(50_000, 10, 10)


def shorten_compilation(folder: Path) -> None:
    """Keep compiled programs in `folder`, and compile with fewer optimisations.

    What the user set in XLA_FLAGS or JAX_COMPILATION_CACHE_DIR stays; a folder that cannot be
    written is not used, and a program that cannot be read back is compiled again.
    """
    os.environ.setdefault("XLA_FLAGS", _flags(version("jaxlib")))
    if jax.config.jax_compilation_cache_dir is not None:  # pyright: ignore[reportAttributeAccessIssue]
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        warnings.filterwarnings("ignore", message="Error .* persistent compilation cache")
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
        with suppress(OSError):
            _forget_oldest(folder)


def quick_to_compile(
    jit: Callable[..., Callable[..., Any]],
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """A decorator like `jit`, for large functions that are called a few times with each shape.

    They compile in half of the time and run a third longer. That is so where they are called; as a
    part of what someone else compiles or differentiates, and on other devices than the CPU, they
    are compiled as all else is. What the user set in XLA_FLAGS stays.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        usual = jit(function)

        @cache
        def quick(on: str) -> Callable[..., Any]:
            return jit(function, compiler_options=_options(on))

        @wraps(function)
        def called(*arguments: Any) -> Any:
            traced = any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(arguments))
            return usual(*arguments) if traced else quick(platform())(*arguments)

        return called

    return decorate


def platform() -> str:
    """Where JAX computes what it is not told the place of: `cpu`, `gpu` or another."""
    chosen = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]
    if chosen is None:
        return jax.default_backend()
    return chosen if isinstance(chosen, str) else chosen.platform


def on_the_cpu() -> AbstractContextManager[Any]:
    """For thousands of small programs in turn: an accelerator takes longer to begin than they last.

    Where JAX was told to know nothing but an accelerator (`JAX_PLATFORMS`) they stay on that.
    """
    if platform() == "cpu":
        return nullcontext()
    try:
        cpu, *_ = jax.local_devices(backend="cpu")
    except RuntimeError:
        return nullcontext()
    return jax.default_device(cpu)


def _options(on: str) -> dict[str, int | bool]:
    """Those that the user has not set, for the CPU."""
    if on != "cpu":
        return {}
    chosen = os.environ.get("XLA_FLAGS", "")
    return {name: value for name, value in _settings(version("jaxlib")) if name not in chosen}


def _flags(jaxlib_version: str) -> str:
    """Those that make this version of XLA compile faster."""
    return " ".join(f"--{name}={str(on).lower()}" for name, on in _settings(jaxlib_version))


def _settings(jaxlib_version: str) -> list[tuple[str, int | bool]]:
    release = tuple(int(part) for part in jaxlib_version.split(".")[:2])
    first, beyond = _KNOW_OLDER_LOOPS
    known = first <= release < beyond
    return [_FEWER_OPTIMISATIONS, _OLDER_LOOPS] if known else [_FEWER_OPTIMISATIONS]


def _forget_oldest(folder: Path) -> None:
    # JAX's own bound needs a second file for each program, and fails for want of one when a
    # process was stopped between the two.
    found = []
    for path in folder.iterdir():
        # Another process may have removed it meanwhile.
        with suppress(OSError):
            status = path.stat()
            found.append((status.st_mtime, status.st_size, path))
    total = 0
    for _, size, path in sorted(found, reverse=True):
        total += size
        if total > _MOST_BYTES:
            path.unlink(missing_ok=True)
