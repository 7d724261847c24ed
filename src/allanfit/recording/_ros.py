"""ROS 1 bags, ROS 2 bags (a folder, or an `.db3` file) and MCAP, read without ROS."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from ..extras import needs
from ._damage import careful
from ._recording import Progress, RecordingError, Table
from ._ros1 import ros1_counts, ros1_messages, ros1_reader
from ._ros2 import chunks_within_bounds, messages_apart, refuse_swelling_files, refuse_unfinished
from ._ros_messages import LAYOUTS, Layout, decode
from ._topics import Topic, choose_topic
from ._wording import count

# Messages of two minutes or so: enough to be quick, few enough to hold.
_BLOCK = 32_768
# Of a message: its numbers take 300 bytes, and the rest is a name.
_LONGEST = 1 << 16
_BAG = b"rosbag2_bagfile_information"
_TYPES = "sensor_msgs/Imu"
# Messages are late by less than this; further back, a clock was set.
_LATE = 1024
# An auxiliary value stands for so many of its intervals, and after that is missing.
_STALE = 10


def is_ros2_bag(path: Path) -> bool:
    """Whether a folder is a ROS 2 bag."""
    metadata = path / "metadata.yaml"
    if not metadata.is_file():
        return False
    with metadata.open("rb") as file:
        return _BAG in file.read(4096)


def ros_topics(path: Path) -> tuple[Topic, ...]:
    """The topics of a recording of ROS, whatever their type."""
    with _opened(path) as reader:
        return _topics(path, reader)


def read_ros(path: Path, topic: str | None = None, progress: Progress | None = None) -> Table:
    """An IMU's messages, with a temperature and a magnetometer recorded beside it.

    **Raises** `RecordingError` when the recording is damaged or it is not clear which topic is
    meant.
    """
    with _opened(path) as reader:
        topics = _topics(path, reader)
        chosen = choose_topic(path.name, topics, topic, _TYPES)
        columns, units, findings = _read(path, reader, chosen, progress)
        for kind in LAYOUTS:
            others = [other for other in topics if other.kind == kind and other.samples]
            if LAYOUTS[kind].inertial or chosen.kind == kind or not others:
                continue
            if len(others) > 1:
                names = ", ".join(other.name for other in others)
                findings += (f"None of the topics {names} is used: which belongs to the IMU?",)
                continue
            beside, its_units, doubts = _read(path, reader, others[0], None)
            held = _held(beside.pop("time"), columns["time"])
            columns |= {name: _taken(column, held) for name, column in beside.items()}
            units |= its_units
            findings += tuple(f"{others[0].name}: {doubt}" for doubt in doubts)
    return Table(columns, units | {"time": "ns"}, findings=findings)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with needs("allanfit[io]", "recordings of ROS", RecordingError):
        from rosbags import rosbag2
    with careful(path, "a recording of ROS"):
        if _is_ros1(path):
            with ros1_reader(path) as reader:
                yield reader
            return
        refuse_unfinished(path)
        refuse_swelling_files(path)
        with chunks_within_bounds(path), rosbag2.Reader(path) as reader:
            yield reader


def _is_ros1(path: Path) -> bool:
    return path.suffix.lower() == ".bag" and not path.is_dir()


def _topics(path: Path, reader: Any) -> tuple[Topic, ...]:
    seconds = reader.duration * 1e-9
    counts = ros1_counts(reader) if _is_ros1(path) else None
    found = {}
    for connection in reader.connections:
        name, kind = connection.topic, connection.msgtype
        messages = connection.msgcount if counts is None else counts[connection.id]
        known, before = found.get(name, (kind, 0))
        found[name] = (kind if kind == known else f"{known} and {kind}", before + messages)
    return tuple(
        Topic(
            name,
            kind,
            messages,
            (messages - 1) / seconds if messages > 1 and seconds > 0 else None,
            dict(LAYOUTS[kind].units) if kind in LAYOUTS else {},
            kind in LAYOUTS and LAYOUTS[kind].inertial,
        )
        for name, (kind, messages) in sorted(found.items())
    )


def _read(
    path: Path, reader: Any, topic: Topic, progress: Progress | None
) -> tuple[dict[str, np.ndarray], dict[str, str], tuple[str, ...]]:
    layout = LAYOUTS[topic.kind]
    try:
        received, stamps, values = _decoded(reader, topic, layout, _is_ros1(path), progress)
    except RecordingError as error:
        raise RecordingError(f"{path.name}, topic {topic.name}: {error}.") from error
    findings = ()
    if not stamps.any():
        stamps = received
        findings += (
            "The headers carry no time stamps, so the times at which the messages were recorded "
            "are used.",
        )
    order = np.argsort(stamps, kind="stable")
    moved = np.abs(order - np.arange(order.size))
    if 0 < moved.max(initial=0) <= _LATE:
        late = int(np.count_nonzero(np.diff(stamps) < 0))
        stamps, values = stamps[order], values[order]
        findings += (
            f"Messages that came after later ones: {count(late, 'time')}; they are put in the "
            "order of their time stamps.",
        )
    columns = {"time": stamps} | dict(zip(layout.columns, values.T.copy(), strict=True))
    return columns, dict(layout.units), findings


def _decoded(
    reader: Any, topic: Topic, layout: Layout, ros1: bool, progress: Progress | None
) -> tuple[
    Int64[np.ndarray, " messages"],
    Int64[np.ndarray, " messages"],
    Float64[np.ndarray, "messages columns"],
]:
    """Times of receipt and stamps in ns, and the columns, in the order of receipt."""
    decoded, times, block = [], [], []

    def finish_block() -> None:
        if block:
            decoded.append((np.array(times, np.int64), *decode(block, layout, ros1)))
            times.clear()
            block.clear()

    for read, (time, message) in enumerate(_messages(reader, topic, ros1), start=1):
        if len(message) > _LONGEST:
            raise RecordingError("a message is longer than any of its type")
        times.append(time)
        block.append(message)
        if read % _BLOCK == 0:
            finish_block()
            if progress is not None:
                progress(read, topic.samples)
    finish_block()
    if not decoded:
        raise RecordingError("no message is there, though the index counts some")
    received, stamps, values = map(np.concatenate, zip(*decoded, strict=True))
    return received, stamps, values


def _messages(reader: Any, topic: Topic, ros1: bool) -> Iterator[tuple[int, bytes]]:
    connections = [each for each in reader.connections if each.topic == topic.name]
    if ros1:
        yield from ros1_messages(reader, {each.id for each in connections})
    else:
        unpack = messages_apart(reader)
        yield from ((time, unpack(message)) for _, time, message in reader.messages(connections))


def _held(
    at: Int64[np.ndarray, " values"], time: Int64[np.ndarray, " samples"]
) -> Int64[np.ndarray, " samples"]:
    """Which value was the latest at each time, -1 where there was none for long."""
    latest = np.searchsorted(at, time, side="right") - 1
    interval = np.median(np.diff(at)) if at.size > 1 else 0
    age = time - at[np.maximum(latest, 0)]
    return np.where(age <= max(_STALE * interval, 0), latest, -1)


def _taken(
    column: Float64[np.ndarray, " values"], held: Int64[np.ndarray, " samples"]
) -> Float64[np.ndarray, " samples"]:
    return np.where(held >= 0, column[held], np.nan)
