"""Bad files as the simulation that `explain` compares a good recording with."""

import json

import numpy as np
import pytest
from bad_coefficients import BAD as BAD_COEFFICIENTS
from bad_recordings import BAD as BAD_RECORDINGS
from bad_recordings import RATE, make


@pytest.fixture
def good(tmp_path):
    path = tmp_path / "good.npz"
    values = np.random.default_rng(1).standard_normal(400)
    np.savez(path, gyro_x=values, rate_hz=100.0, units=json.dumps({"gyro_x": "deg/s"}))
    return path


@pytest.mark.parametrize("case", BAD_COEFFICIENTS)
def test_coefficients(case, good, tmp_path, refused):
    content, _ = BAD_COEFFICIENTS[case]
    path = tmp_path / "c.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert refused("explain", str(good), "--simulation", str(path))


# What is wrong with the others is said on the command line, of the recording and not of this.
_IN_THE_FILE = [
    case
    for case, bad in BAD_RECORDINGS.items()
    if bad.options in ((), RATE)
    # What tells no rate has the recording's.
    and case not in ("no rate", "stamps in words")
]


@pytest.mark.parametrize("case", _IN_THE_FILE)
def test_recordings(case, good, tmp_path, refused):
    path = make(tmp_path, BAD_RECORDINGS[case])
    assert refused("explain", str(good), "--simulation", str(path))
