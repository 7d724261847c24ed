"""Rows that were written twice, and what only looks so."""

import numpy as np
import pytest

from allanfit.recording import load, read_in_blocks
from allanfit.recording._copies import copies

ROWS = 5_000


def rows(seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return np.arange(ROWS) / 100, rng.standard_normal(ROWS)


@pytest.mark.parametrize("every", [1, 10, 100])
def test_copies_are_left_out_and_said(every, archive):
    time, x = rows()
    twice = np.repeat(np.arange(ROWS), 1 + (np.arange(ROWS) % every == 0))
    path = archive(time=time[twice], gyro_x=x[twice], temperature=np.full(twice.size, 20.0))
    recording = load(path, unit="deg/s")
    assert recording.rate_hz == pytest.approx(100, rel=1e-9)
    np.testing.assert_allclose(recording.channels[0].samples, x * np.pi / 180, rtol=1e-15)
    assert recording.auxiliary[0].samples.size == ROWS
    told = [line for line in recording.findings if "copies of the row before" in line]
    assert f"{twice.size - ROWS} rows" in told[0]
    blocks = read_in_blocks(path, unit="deg/s")
    read = np.concatenate([run.samples for run in blocks])
    np.testing.assert_allclose(read, x * np.pi / 180, rtol=1e-15)
    assert told[0] in blocks.findings


def test_a_coarse_clock_makes_no_copies():
    """Stamps of 0.1 s, and codes so wide that one value in three equals the one before."""
    time, x = rows()
    assert not copies(np.floor(time * 10) / 10, [np.round(x)]).any()
    assert not copies(time, [np.round(x)]).any()
    assert not copies(time, []).any()
