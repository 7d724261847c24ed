"""Recordings that are written: what comes back, and what is refused before a file is there."""

import numpy as np
import pytest

from allanfit.recording import RecordingError, load, save

LINE = np.arange(400.0) % 7


@pytest.mark.parametrize("ending", ["npz", "npy", "csv"])
def test_what_is_written_comes_back(ending, tmp_path, noise):
    path = tmp_path / f"a.{ending}"
    save(path, {"gyro_x": noise[:, 0], "gyro_y": noise[:, 1]}, {"gyro_x": "deg/s"}, 50.0)
    recording = load(path, rate_hz=50.0 if ending == "npy" else None)
    assert (recording.rate_hz, len(recording.channels)) == (50.0, 2)
    for channel, column in zip(recording.channels, noise.T, strict=False):
        np.testing.assert_array_equal(channel.samples, column * channel.factor)


@pytest.mark.parametrize("ending", ["npz", "npy", "csv"])
@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({}, "without a channel: give one at least"),
        ({"x": LINE, "y": LINE[:300]}, "equally many samples, but x has 400 and y has 300"),
        (
            {"x": LINE.reshape(4, 100)},
            r"channel x has the shape \(4, 100\), and a channel is a 1-D",
        ),
    ],
)
def test_channels_that_do_not_go_together_are_refused(ending, columns, message, tmp_path):
    with pytest.raises(RecordingError, match=rf"Cannot write a\.{ending}.*{message}"):
        save(tmp_path / f"a.{ending}", columns, {}, 50.0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["file", "allow_pickle", "rate_hz", "units"])
def test_names_that_an_archive_has_no_room_for(name, tmp_path):
    with pytest.raises(RecordingError, match=f"cannot hold a channel named {name}: rename it"):
        save(tmp_path / "a.npz", {name: LINE}, {}, 50.0)
    assert list(tmp_path.iterdir()) == []
    save(tmp_path / "a.csv", {name: LINE}, {}, 50.0)


@pytest.mark.parametrize(
    ("columns", "name"),
    [({"time_s": LINE}, "time_s"), ({"x": LINE, "x [g]": LINE}, r"x \[g\]")],
)
def test_no_column_of_a_table_replaces_another(columns, name, tmp_path):
    with pytest.raises(RecordingError, match=rf"two columns named {name}: rename one"):
        save(tmp_path / "a.csv", columns, {"x": "g"}, 50.0)
