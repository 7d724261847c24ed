"""Recordings written by the formats' own libraries, or byte by byte where they have no writer."""

import struct
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
SECOND = 1_000_000_000


def header(store, stamp: int, frame: str):
    names = store.types
    time = names["builtin_interfaces/msg/Time"](stamp // SECOND, stamp % SECOND)
    # ROS 1 counts messages in the header.
    counted = {"seq": 7} if store is ROS1 else {}
    return names["std_msgs/msg/Header"](stamp=time, frame_id=frame, **counted)


def imu(store, stamp: int, row, frame: str = "imu_link"):
    """A message with numbers everywhere, so that a wrong offset shows."""
    names = store.types
    vector, covariance = names["geometry_msgs/msg/Vector3"], np.arange(9.0) + 500
    return names["sensor_msgs/msg/Imu"](
        header(store, stamp, frame),
        names["geometry_msgs/msg/Quaternion"](901.0, 902.0, 903.0, 904.0),
        covariance,
        vector(*map(float, row[:3])),
        covariance,
        vector(*map(float, row[3:])),
        covariance,
    )


def temperature(store, stamp: int, value: float):
    return store.types["sensor_msgs/msg/Temperature"](header(store, stamp, ""), value, 0.5)


def magnetic(store, stamp: int, row):
    vector = store.types["geometry_msgs/msg/Vector3"](*map(float, row))
    kind = store.types["sensor_msgs/msg/MagneticField"]
    return kind(header(store, stamp, "mag"), vector, np.zeros(9))


def write_bag(path: Path, kind: str, messages: list[tuple[str, int, object]]) -> Path:
    """Messages as (topic, time of receipt in ns, message), to `bag`, `sqlite3` or `mcap`."""
    store = ROS1 if kind == "bag" else ROS2
    if kind == "bag":
        writer = Writer1(path)
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(path, version=9, storage_plugin=plugin)
    connections = {}
    with writer:
        for topic, time, message in messages:
            name = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            encode = store.serialize_ros1 if kind == "bag" else store.serialize_cdr
            writer.write(connections[topic], time, encode(message, name))
    return path


def write_ulog(path: Path, topics: dict[str, tuple[str, list[tuple]]], cut: int = 0) -> Path:
    """A log by the published format: topics as (fields, rows of their values in order)."""

    def record(kind: str, data: bytes) -> bytes:
        return struct.pack("<HB", len(data), ord(kind)) + data

    codes = {"uint64_t": "Q", "uint32_t": "I", "uint8_t": "B", "int16_t": "h", "float": "f"}
    content = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    content += record("B", bytes(40))
    for name, (fields, _) in topics.items():
        content += record("F", f"{name.partition('/')[0]}:{fields}".encode())
    for number, name in enumerate(topics):
        kind, _, instance = name.partition("/")
        content += record("A", struct.pack("<BH", int(instance or 0), number) + kind.encode())
    for number, (fields, rows) in enumerate(topics.values()):
        code = "<H"
        for field in fields.strip(";").split(";"):
            kind, _, length = field.split(" ")[0].strip("]").partition("[")
            code += (length or "1") + codes[kind]
        for row in rows:
            content += record("D", struct.pack(code, number, *row))
    path.write_bytes(content[: len(content) - cut])
    return path
