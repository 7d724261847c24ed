"""Compilation made short for programs that start, compute and end.

A library leaves JAX's settings alone; the command line and the tests, which are programs, call
this.
"""

import os
from pathlib import Path

import jax

# A fit's programs take less than a megabyte; lengths and numbers of channels add to them.
_MOST_BYTES = 256 * 2**20


def shorten_compilation(folder: Path) -> None:
    """Keep compiled programs in `folder`, and compile with fewer optimisations.

    The optimisations left out take as long as the rest of compiling and gain nothing here. What
    the user set in XLA_FLAGS or JAX_COMPILATION_CACHE_DIR stays; a folder that cannot be written
    is not used.
    """
    os.environ.setdefault("XLA_FLAGS", "--xla_backend_optimization_level=1")
    if jax.config.jax_compilation_cache_dir is not None:  # pyright: ignore[reportAttributeAccessIssue]
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_compilation_cache_max_size", _MOST_BYTES)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
