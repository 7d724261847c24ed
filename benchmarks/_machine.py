"""What numbers were measured on."""

import os
import platform
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
