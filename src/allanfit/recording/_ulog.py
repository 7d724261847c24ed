"""Logs of the PX4 autopilot (ULog): its inertial topics, raw or as the autopilot combines them."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Num

from ..extras import needs
from ._damage import careful
from ._recording import RecordingError, Table
from ._topics import Topic, choose_topic

Fields = dict[str, np.ndarray]
"""The fields of a topic by name, one value a message."""

_GYRO = {f"gyro_{axis}": "rad/s" for axis in "xyz"}
_ACCEL = {f"accel_{axis}": "m/s^2" for axis in "xyz"}
# Bytes before the first message, and the types of messages that follow the definitions.
_HEADER = 16
_DATA_BEGINS = (b"A", b"L", b"C")
# Fields of types in types multiply; no message of PX4 has more.
_MOST_FIELDS = 10_000


@dataclass(frozen=True)
class _Kind:
    """A topic that is read: its channels, and how they come from its fields."""

    units: dict[str, str]
    columns: Callable[[Fields], list[Num[np.ndarray, " samples"]]]
    """The channels in the order of `units`."""
    several: bool = False
    """Whether a message holds several samples."""


def _array(fields: Fields, name: str) -> list[np.ndarray]:
    return [fields[f"{name}[{axis}]"] for axis in range(3)]


def _combined(fields: Fields) -> list[np.ndarray]:
    return [*_array(fields, "gyro_rad"), *_array(fields, "accelerometer_m_s2")]


def _integrals(fields: Fields) -> list[np.ndarray]:
    """Increments of angle and velocity over their times in us, as rates."""
    return [
        increment / (1e-6 * fields[f"{name}_dt"])
        for name in ("delta_angle", "delta_velocity")
        for increment in _array(fields, name)
    ]


def _axes(fields: Fields) -> list[np.ndarray]:
    return [fields[axis] for axis in "xyz"]


def _fifo(fields: Fields) -> list[np.ndarray]:
    """Raw samples, of which a message holds as many as the sensor had stored."""
    filled = _filled(fields)
    scale = np.repeat(fields["scale"].astype(float), fields["samples"])
    return [np.stack(_slots(fields, axis), axis=1)[filled] * scale for axis in "xyz"]


def _slots(fields: Fields, axis: str) -> list[np.ndarray]:
    return [fields[name] for name in fields if name.startswith(f"{axis}[")]


def _filled(fields: Fields) -> np.ndarray:
    return np.arange(len(_slots(fields, "x"))) < fields["samples"][:, None]


_KINDS = {
    "sensor_combined": _Kind(_GYRO | _ACCEL, _combined),
    "vehicle_imu": _Kind(_GYRO | _ACCEL, _integrals),
    "sensor_gyro": _Kind(_GYRO, _axes),
    "sensor_accel": _Kind(_ACCEL, _axes),
    "sensor_gyro_fifo": _Kind(_GYRO, _fifo, several=True),
    "sensor_accel_fifo": _Kind(_ACCEL, _fifo, several=True),
}
_TYPES = " or ".join((", ".join(list(_KINDS)[:-1]), list(_KINDS)[-1]))


def ulog_topics(path: Path) -> tuple[Topic, ...]:
    """The inertial topics of a log, one for each sensor."""
    with _opened(path) as log:
        return _topics(log)


def read_ulog(path: Path, topic: str | None = None) -> Table:
    """A topic of a log: `sensor_combined` where it is there, unless another is asked for.

    **Raises** `RecordingError` when the log is damaged or it is not clear which topic is meant.
    """
    with _opened(path) as log:
        topics = _topics(log)
        others = [each.name for each in topics if each.name != "sensor_combined/0"]
        findings = ()
        if topic is None and others and len(others) < len(topics):
            topic = "sensor_combined/0"
            findings += (
                f"Read from sensor_combined, the means that the autopilot uses; {', '.join(others)}"
                " can be had with --topic.",
            )
        if topic is not None and "/" not in topic.strip("/"):
            topic = f"{topic}/0"
        chosen = choose_topic(path.name, topics, topic, _TYPES)
        fields = next(each.data for each in log.data_list if _name(each) == chosen.name)
        kind = _KINDS[chosen.kind]
        columns = {"time": _time(fields, kind)} | dict(
            zip(kind.units, kind.columns(fields), strict=True)
        )
        if "temperature" in fields:
            columns["temperature"] = fields["temperature"]
        if log.file_corruption:
            findings += ("Parts of the log are damaged and were skipped.",)
    units = kind.units | {"time": "us", "temperature": "degC"}
    return Table(columns, units, findings=findings)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with needs("allanfit[io]", "logs of PX4", RecordingError):
        from pyulog import ULog
    with careful(path, "an ULog file"):
        _require_definitions(path)
        with path.open("rb") as file:
            _refuse_vast_types(ULog(file, parse_header_only=True).message_formats)
        with path.open("rb") as file:
            yield ULog(file, list(_KINDS))


def _require_definitions(path: Path) -> None:
    """See that the messages before the data end within the file.

    From one that does not, pyulog steps back and comes to it again, for ever.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        file.seek(_HEADER)
        while head := file.read(3):
            if len(head) < 3 or head[2:] in _DATA_BEGINS:
                return
            if file.seek(int.from_bytes(head[:2], "little"), 1) > size:
                raise RecordingError(
                    f"{path.name} is not an ULog file that can be read: it ends, or is damaged, "
                    "before its data begin."
                )


def _refuse_vast_types(formats: dict[str, Any]) -> None:
    """Types that hold themselves, or hold so many that they would fill the memory."""

    def size(name: str, above: tuple[str, ...]) -> int:
        if name not in formats:
            return 1
        if name in above:
            raise RecordingError(f"The ULog file is damaged: its type {name} holds itself.")
        total = 1
        for kind, length, _ in formats[name].fields:
            total += max(length, 1) * size(kind, (*above, name))
            if total > _MOST_FIELDS:
                raise RecordingError(f"The ULog file is damaged: its type {name} is too large.")
        return total

    for name in formats:
        size(name, ())


def _name(data: Any) -> str:
    return f"{data.name}/{data.multi_id}"


def _topics(log: Any) -> tuple[Topic, ...]:
    found = []
    for data in log.data_list:
        kind = _KINDS[data.name]
        stamps = data.data["timestamp"].astype(np.int64)
        samples = int(data.data["samples"].sum()) if kind.several else stamps.size
        seconds = 1e-6 * float(stamps[-1] - stamps[0])
        rate_hz = samples / seconds if seconds > 0 else None
        found.append(Topic(_name(data), data.name, samples, rate_hz, dict(kind.units)))
    return tuple(found)


def _time(fields: Fields, kind: _Kind) -> np.ndarray:
    """In us: when the sensor was read, or where that is not logged, when it was published."""
    sampled = fields.get("timestamp_sample")
    stamps = fields["timestamp"] if sampled is None or not sampled.any() else sampled
    stamps = stamps.astype(np.int64)
    if not kind.several:
        return stamps
    filled = _filled(fields)
    # The stamp is that of the last sample, and `dt` is between two.
    before = fields["samples"][:, None] - 1 - np.arange(filled.shape[1])
    return (stamps[:, None] - before * fields["dt"].astype(float)[:, None])[filled]
