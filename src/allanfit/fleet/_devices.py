"""Which channels are one quantity on several devices."""

import os
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

_NUMBERED = re.compile(r"(?P<stem>.+)_(?P<number>\d+)")
# What columns without a name are called: they number axes, not devices.
_MADE_UP = "channel"


class Place(NamedTuple):
    """Where a channel stands in the fleet."""

    quantity: str
    """What is compared over devices, such as `accel_z`."""
    device: str
    """Which device it is of: the recording's stem, and the number of the channel if it has one."""


def places(recording: str, channels: Sequence[str]) -> dict[str, Place]:
    """The quantity and the device of each channel of a recording.

    As a rule a recording is one device and a channel's name is the quantity. Channels that
    differ by a number at the end alone, `accel_z_01` and `accel_z_02`, are one quantity on as
    many devices.
    """
    matches = {name: _NUMBERED.fullmatch(name) for name in channels}
    stems = Counter(match["stem"] for match in matches.values() if match)
    # Twice, since a name may end in ".csv.gz".
    own = Path(Path(recording).stem).stem
    found = {}
    for name, match in matches.items():
        if match and stems[match["stem"]] > 1 and match["stem"] != _MADE_UP:
            found[name] = Place(match["stem"], f"{own}/{match['number']}")
        else:
            found[name] = Place(name, own)
    return found


def labels(devices: Iterable[tuple[str, str]]) -> dict[tuple[str, str], str]:
    """A short name for each (path of the recording, device), no two the same.

    The devices of one recording go by their numbers, and recordings of one name in different
    folders by as much of their paths as differs.
    """
    devices = dict.fromkeys(devices)
    paths = {path for path, _ in devices}
    if len(paths) < 2:
        return {(path, name): name.rpartition("/")[2] for path, name in devices}
    times = Counter(name for _, name in devices)
    common = os.path.commonpath([Path(path).parent for path in paths])
    found = {}
    for path, name in devices:
        folder = Path(path).parent.relative_to(common).as_posix()
        found[path, name] = name if times[name] == 1 else f"{folder}/{name}".removeprefix("./")
    # Files that differ by their type alone go by their whole names.
    times = Counter(found.values())
    return {
        (path, name): label if times[label] == 1 else _whole(path, name)
        for (path, name), label in found.items()
    }


def _whole(path: str, device: str) -> str:
    _, slash, number = device.rpartition("/")
    return f"{path}{slash}{number}" if slash else path
