"""What numbers were measured on, and how time is taken."""

import os
import platform
import time
from collections.abc import Callable
from importlib.metadata import version

import jax


def machine(*peers: str) -> dict:
    """Machine and versions, those of packages that were compared with among them."""
    return {
        "machine": platform.platform(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "devices": [device.device_kind for device in jax.local_devices()],
        "versions": {name: version(name) for name in ("allanfit", "jax", "numpy", *peers)},
    }


def fastest(run: Callable[[], object], times: int) -> float:
    """Seconds of the fastest of several runs."""
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def peak_mib() -> float:
    """Most memory that this process has held.

    Not `ru_maxrss`, which a process inherits from the one that started it.
    """
    with open("/proc/self/status") as status:
        return int(next(line for line in status if line.startswith("VmHWM")).split()[1]) / 1024
