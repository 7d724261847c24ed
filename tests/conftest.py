"""What every test shares."""

import os
import sys
from pathlib import Path

import jax
import pytest

# What one process compiles of the package the others read: those that test, and the commands and
# workers that tests start. Said before the package is imported.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from allanfit.compilation import shorten_compilation, wait_less  # noqa: E402

# Float64 throughout, as on the command line; tests of float32 turn it off for themselves.
jax.config.update("jax_enable_x64", True)
wait_less()


def pytest_configure(config: pytest.Config) -> None:
    folder = config.cache.mkdir("compiled")
    shorten_compilation(folder)
    # For the commands that tests start.
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(folder)
    # JAX keeps what takes a second; most programs here take less, and there are many of them.
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
    # For the processes that test side by side: of threads for small matrices one waits for another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of recordings beside a developer's checkout; tests that need it skip without."""
    folder = Path(__file__).parents[1].parent / "shared"
    if not folder.is_dir():
        pytest.skip("no shared recordings beside this checkout")
    return folder
