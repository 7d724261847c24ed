"""What every test shares."""

from pathlib import Path

import jax
import pytest

# Float64 throughout, as on the command line; tests of float32 turn it off for themselves.
jax.config.update("jax_enable_x64", True)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of recordings beside a developer's checkout; tests that need it skip without."""
    folder = Path(__file__).parents[1].parent / "shared"
    if not folder.is_dir():
        pytest.skip("no shared recordings beside this checkout")
    return folder
