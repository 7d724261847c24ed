"""What a file holds, and which part of it is meant."""

from collections.abc import Sequence
from dataclasses import dataclass

from ._recording import RecordingError, Table
from ._timestamps import read_clock, time_columns
from ._wording import count


@dataclass(frozen=True)
class Topic:
    """Channels that a file holds together: all of it, or one part of several."""

    name: str
    """What `topic` asks for; empty where the file is one table."""
    kind: str
    """The type of its messages; empty where there are none."""
    samples: int
    """How many, or how many messages."""
    rate_hz: float | None
    """Samples a second, roughly where there are messages; None if it cannot be told."""
    units: dict[str, str]
    """The unit of each channel, "" if unknown; no channels at all where the type is not read."""
    inertial: bool = True
    """Whether it is read without being asked for."""


def topic_of(table: Table, name: str = "") -> Topic:
    """What a table holds."""
    times = time_columns(table.columns, table.units)
    stamps = next(iter(times), None)
    rate_hz = table.rate_hz
    if rate_hz is None and stamps is not None:
        try:
            values, unit = table.columns[stamps], table.units.get(stamps, "")
            rate_hz = read_clock(values, stamps, unit, None).rate_hz
        except RecordingError:
            rate_hz = None
    channels = [column for column in table.columns if column not in times]
    samples = max((table.columns[column].size for column in channels), default=0)
    units = {column: table.unit(column) for column in channels}
    return Topic(name, "", samples, rate_hz, units)


def choose_topic(file: str, topics: Sequence[Topic], asked: str | None, types: str) -> Topic:
    """The topic called `asked`, or the only one that has inertial channels.

    **Arguments:** `types` names what can be read, for the error.

    **Raises** `RecordingError` when there is none or there are several, naming all.
    """
    if asked is None:
        found = [topic for topic in topics if topic.inertial and topic.units and topic.samples]
        if not found:
            raise RecordingError(
                f"{file} holds no messages of {types}: it has {_told(topics) or 'no topics'}."
            )
        if len(found) > 1:
            raise RecordingError(
                f"{file} holds {len(found)} topics, choose one with --topic: {_told(found)}."
            )
        return found[0]
    found = [topic for topic in topics if topic.name.strip("/") == asked.strip("/")]
    if not found:
        raise RecordingError(f"{file} has no topic {asked}; it has {_told(topics) or 'none'}.")
    if not found[0].units:
        raise RecordingError(
            f"{file}: the topic {asked} holds {found[0].kind}, which is not read; {types} is."
        )
    if not found[0].samples:
        raise RecordingError(f"{file}: the topic {asked} has no messages.")
    return found[0]


def _told(topics: Sequence[Topic]) -> str:
    return ", ".join(
        f"{topic.name} ({topic.kind}, {count(topic.samples, 'message')})" for topic in topics
    )
