"""What a file holds by the rate and the unit that a user gives, which come before its own."""

from collections.abc import Sequence
from dataclasses import replace

from ._channel_units import is_beside, units_of
from ._load import check_rate
from ._other_sensors import is_field_or_attitude
from ._recording import RecordingError, Table
from ._temperature import is_temperature
from ._topics import Topic


def as_given(topics: Sequence[Topic], rate_hz: float | None, unit: str | None) -> tuple[Topic, ...]:
    """Topics with this rate and, where it fits, this unit, as `load` would take them.

    **Raises** `RecordingError` for a rate that is none, and a unit that is unknown or fits nothing.
    """
    if rate_hz is not None:
        check_rate(rate_hz, "the rate given")
        topics = [replace(topic, rate_hz=rate_hz) for topic in topics]
    if unit is None:
        return tuple(topics)
    found, doubts = [], []
    for topic in topics:
        try:
            found.append(replace(topic, units=topic.units | _units(topic, unit)))
        except RecordingError as error:
            found.append(topic)
            doubts.append(error)
    # A unit of gyros does not fit a topic of temperatures beside them.
    if doubts and len(doubts) == len(topics):
        raise doubts[0]
    return tuple(found)


def _units(topic: Topic, unit: str) -> dict[str, str]:
    """The units of its channels."""
    table = Table({}, topic.units)
    names = [
        name
        for name, stated in topic.units.items()
        if not (
            is_temperature(name, stated, table)
            or is_field_or_attitude(name)
            or is_beside(name, table)
        )
    ]
    return {name: each.name for name, each in units_of(names, set(), table, unit).items()}
