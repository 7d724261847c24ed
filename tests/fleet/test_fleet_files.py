"""What is meant by files, folders and patterns, and what devices are called."""

import pytest

from allanfit.fleet import FleetError
from allanfit.fleet._devices import labels, places
from allanfit.fleet._files import find_recordings
from allanfit.fleet._task import _checksum


@pytest.fixture
def tree(tmp_path):
    for name in ("b.npz", "a.csv.gz", "notes.md", ".hidden.npz", "low/a.npz", "out/results/c.npz"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


def test_a_folder_stands_for_the_recordings_in_it(tree):
    found = find_recordings([tree], tree / "out" / "results")
    assert [path.name for path in found] == ["a.csv.gz", "b.npz"]


def test_a_pattern_reaches_below_but_not_into_the_results(tree):
    found = find_recordings([f"{tree}/**/*.npz"], tree / "out" / "results")
    assert {str(path.relative_to(tree)) for path in found} == {"b.npz", "low/a.npz"}


def test_each_recording_once_in_the_order_given(tree):
    (tree / "link.npz").symlink_to(tree / "b.npz")
    given = [tree / "low" / "a.npz", tree / "b.npz", tree / "link.npz", tree / "low/../b.npz"]
    assert find_recordings(given, tree / "out") == (tree / "low" / "a.npz", tree / "b.npz")


def test_a_file_that_is_not_there_is_kept(tree):
    assert find_recordings([tree / "gone.npz"], tree / "out") == (tree / "gone.npz",)


@pytest.mark.parametrize(
    ("given", "message"),
    [("*.npy", r"No recording has a name like .*\*\.npy"), ("out", r"give a pattern")],
)
def test_nothing_found_is_said(tree, given, message):
    with pytest.raises(FleetError, match=message):
        find_recordings([tree / given], tree / "out" / "results")


def test_numbers_at_the_end_tell_devices_apart_only_if_there_are_several():
    names = ["accel_z_01", "accel_z_02", "gyro_x", "gyro_2", "channel_1", "channel_2"]
    found = places("bench.csv.gz", names)
    assert found["accel_z_02"] == ("accel_z", "bench/02")
    assert {name: tuple(found[name]) for name in names[2:]} == {
        name: (name, "bench") for name in names[2:]
    }


def test_labels_are_short_and_never_the_same():
    one = {("/a/bench.npz", "bench/01"): "01", ("/a/bench.npz", "bench/02"): "02"}
    assert labels(one) == one
    assert labels([]) == {}
    assert labels([("/a/1/still.npz", "still"), ("/a/2/still.npz", "still")]) == {
        ("/a/1/still.npz", "still"): "1/still",
        ("/a/2/still.npz", "still"): "2/still",
    }
    assert labels([("/a/x.npz", "x"), ("/a/x.csv", "x"), ("/a/y.csv", "y")]) == {
        ("/a/x.npz", "x"): "/a/x.npz",
        ("/a/x.csv", "x"): "/a/x.csv",
        ("/a/y.csv", "y"): "y",
    }


def test_a_ros_2_bag_is_one_recording(tmp_path):
    bag = tmp_path / "still"
    bag.mkdir()
    (bag / "still_0.mcap").touch()
    (bag / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  version: 9\n")
    (tmp_path / "other.parquet").touch()
    names = [path.name for path in find_recordings([tmp_path], tmp_path / "out")]
    assert names == ["other.parquet", "still"]
    assert find_recordings([bag], tmp_path / "out") == (bag,)
    assert find_recordings([f"{tmp_path}/**/*"], tmp_path / "out") == (
        tmp_path / "other.parquet",
        bag,
    )


def test_the_checksum_of_a_bag_is_of_its_files(tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"one")
    first = _checksum(tmp_path)
    (tmp_path / "a.mcap").write_bytes(b"two")
    assert _checksum(tmp_path) != first
