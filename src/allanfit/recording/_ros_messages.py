"""Messages of ROS as bytes: a header with a stamp, then numbers of double precision to the end.

Only the name of the frame in the header has no fixed length. So the stamp is found from the start
of a message and the numbers from its end, and a million messages are read at once, without an
object for each. Both encodings are published: http://wiki.ros.org/msg and the Common Data
Representation of the Object Management Group (DDSI-RTPS 2.5, 10).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from ._recording import RecordingError


@dataclass(frozen=True)
class Layout:
    """A type of message."""

    doubles: int
    """How many numbers follow the header."""
    columns: dict[str, int]
    """Where among them each channel stands."""
    units: dict[str, str]
    """The unit of each channel, by the definition of the type."""
    inertial: bool = False


_IMU = {"gyro": (13, "rad/s"), "accel": (25, "m/s^2")}

LAYOUTS = {
    # Orientation (4), its covariance (9), angular velocity (3), covariance (9), acceleration (3),
    # covariance (9).
    "sensor_msgs/msg/Imu": Layout(
        37,
        {
            f"{name}_{axis}": at + k
            for name, (at, _) in _IMU.items()
            for k, axis in enumerate("xyz")
        },
        {f"{name}_{axis}": unit for name, (_, unit) in _IMU.items() for axis in "xyz"},
        inertial=True,
    ),
    "sensor_msgs/msg/Temperature": Layout(2, {"temperature": 0}, {"temperature": "degC"}),
    "sensor_msgs/msg/MagneticField": Layout(
        12, {"mag_x": 0, "mag_y": 1, "mag_z": 2}, {"mag_x": "T", "mag_y": "T", "mag_z": "T"}
    ),
}


def decode(
    messages: Sequence[bytes], layout: Layout, ros1: bool
) -> tuple[Int64[np.ndarray, " messages"], Float64[np.ndarray, "messages columns"]]:
    """The stamps in ns and the columns of messages of one type, `ros1` or in CDR.

    **Raises** `RecordingError` when a message is none of that type.
    """
    sizes = np.fromiter(map(len, messages), int, len(messages))
    order = "<" if ros1 else _byte_order(messages)
    stamps = np.empty(sizes.size, np.int64)
    values = np.empty((sizes.size, len(layout.columns)))
    for size in np.unique(sizes).tolist():
        chosen = np.flatnonzero(sizes == size).tolist()
        alike = messages if len(chosen) == len(messages) else [messages[k] for k in chosen]
        rows = np.frombuffer(b"".join(alike), _row_type(size, layout.doubles, order, ros1))
        # The frame's name fills what is between, in CDR up to the next multiple of 8.
        between = size - 8 * layout.doubles - (16 if ros1 else 4)
        named = rows["frame_length"].astype(np.int64)
        filled = named if ros1 else -(-(12 + named) // 8) * 8
        if np.any(filled != between):
            raise _another(size)
        stamps[chosen] = rows["sec"].astype(np.int64) * 1_000_000_000 + rows["nsec"]
        values[chosen] = rows["numbers"][:, list(layout.columns.values())]
    return stamps, values


def _row_type(size: int, doubles: int, order: str, ros1: bool) -> np.dtype:
    start = size - 8 * doubles
    if start < 16:
        raise _another(size)
    # ROS 1 counts messages first; CDR begins with four bytes that say how it is encoded.
    return np.dtype(
        {
            "names": ["sec", "nsec", "frame_length", "numbers"],
            "formats": [
                f"{order}u4" if ros1 else f"{order}i4",
                f"{order}u4",
                f"{order}u4",
                (f"{order}f8", (doubles,)),
            ],
            "offsets": [4, 8, 12, start],
            "itemsize": size,
        }
    )


def _byte_order(messages: Sequence[bytes]) -> str:
    kinds = {bytes(message[:2]) for message in messages}
    if kinds == {b"\0\1"}:
        return "<"
    if kinds == {b"\0\0"}:
        return ">"
    raise RecordingError("its messages are not in plain CDR, the encoding of ROS 2")


def _another(size: int) -> RecordingError:
    return RecordingError(f"a message of {size} bytes is not of the type that is stated")
