"""How many messages a second are read from a bag, beside rosbags making an object of each.

python -m benchmarks.bags [--messages 200000] [--runs 3]
"""

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from allanfit.recording import load

from ._machine import fastest, machine

TYPE = "sensor_msgs/msg/Imu"
FORMATS = {
    "ROS 1": ("still.bag", None),
    "ROS 2, sqlite3": ("sqlite3", StoragePlugin.SQLITE3),
    "ROS 2, MCAP": ("mcap", StoragePlugin.MCAP),
}


def write(path, plugin, messages):
    """A still IMU at 400 Hz, noise from a list of a thousand messages."""
    store = get_typestore(Stores.ROS2_HUMBLE if plugin else Stores.ROS1_NOETIC)
    names = store.types
    encode = store.serialize_cdr if plugin else store.serialize_ros1
    vector, covariance = names["geometry_msgs/msg/Vector3"], np.zeros(9)
    attitude = names["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    noise = np.random.default_rng(0).standard_normal((1000, 6)).tolist()
    writer = (
        rosbag2.Writer(path, version=9, storage_plugin=plugin) if plugin else rosbag1.Writer(path)
    )
    with writer:
        connection = writer.add_connection("/imu", TYPE, typestore=store)
        for k in range(messages):
            stamp = names["builtin_interfaces/msg/Time"](k // 400, k % 400 * 2_500_000)
            count = {} if plugin else {"seq": k}
            header = names["std_msgs/msg/Header"](stamp=stamp, frame_id="imu_link", **count)
            row = noise[k % 1000]
            rate, force = vector(*row[:3]), vector(*row[3:])
            message = names[TYPE](header, attitude, covariance, rate, covariance, force, covariance)
            writer.write(connection, k * 2_500_000, encode(message, TYPE))
    return store


def one_by_one(path, store, plugin):
    """What reading with an object a message takes at least."""
    package = rosbag2 if plugin else rosbag1
    decode = store.deserialize_cdr if plugin else store.deserialize_ros1
    rows = []
    with package.Reader(path) as reader:
        for _, _, raw in reader.messages():
            message = decode(raw, TYPE)
            rate, force = message.angular_velocity, message.linear_acceleration
            rows.append((rate.x, rate.y, rate.z, force.x, force.y, force.z))
    return np.array(rows)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--messages", type=int, default=200_000)
    parser.add_argument("--runs", type=int, default=3)
    asked = parser.parse_args(arguments)
    found = {"machine": machine(), "messages": asked.messages}
    for name, (file, plugin) in FORMATS.items():
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / file
            store = write(path, plugin, asked.messages)
            ours = fastest(lambda path=path: load(path), asked.runs)
            theirs = fastest(lambda *a, p=path, s=store, g=plugin: one_by_one(p, s, g), 1)
            found[name] = {
                "messages_per_second": round(asked.messages / ours),
                "one_by_one": round(asked.messages / theirs),
                "ratio": round(theirs / ours, 1),
            }
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
