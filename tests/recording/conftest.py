"""Files of white noise in the formats that are read."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

RATE_HZ = 100.0


@pytest.fixture
def noise() -> np.ndarray:
    """400 samples of three channels, in as many digits as a logger would write."""
    return np.random.default_rng(1).standard_normal((400, 3)).round(6)


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, str | bytes], Path]:
    """Write text or bytes to a file of the given name."""

    def write_file(name: str, content: str | bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write_file


@pytest.fixture
def archive(tmp_path: Path) -> Callable[..., Path]:
    """Store arrays in an `.npz` file, at 100 Hz in deg/s unless told otherwise."""

    def store(**arrays: object) -> Path:
        path = tmp_path / "recording.npz"
        units = {name: "deg/s" for name in arrays if name.startswith(("gyro", "data"))}
        defaults = {"rate_hz": RATE_HZ, "units": str(units).replace("'", '"')}
        entries = {name: value for name, value in (defaults | arrays).items() if value is not None}
        np.savez(path, **entries)
        return path

    return store
