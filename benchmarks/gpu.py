"""How many sensors a second a GPU fits, beside the cores of the same machine in the same run.

    python -m benchmarks.gpu [--sensors 512] [--samples 60000]

Each platform is measured in a process of its own, compilation apart. Says so if there is no GPU.
"""

import argparse
import json
import os
import subprocess
import sys
import time

import jax
import numpy as np

import allanfit

from ._machine import machine
from .many import GROUP, RATE_HZ


def sensors_per_second(sensors: int, samples: int) -> float:
    """With fits and intervals, on whatever JAX computes with in this process."""
    data = np.random.default_rng(0).standard_normal((sensors, samples))
    warm = min(sensors, GROUP * len(jax.local_devices()))
    jax.block_until_ready(allanfit.fit_many(data[:warm], RATE_HZ).intervals)
    start = time.perf_counter()
    jax.block_until_ready(allanfit.fit_many(data, RATE_HZ).intervals)
    return sensors / (time.perf_counter() - start)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sensors", type=int, default=512)
    parser.add_argument("--samples", type=int, default=60_000)
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    if asked.here:
        print(json.dumps(sensors_per_second(asked.sensors, asked.samples)))
        return
    document = machine()
    if jax.default_backend() == "cpu":
        print("JAX finds no GPU here: nothing to compare.")
        return
    document["sensors_per_s"] = sensors_per_second(asked.sensors, asked.samples)
    command = [sys.executable, "-m", "benchmarks.gpu", "--here"]
    command += ["--sensors", str(min(asked.sensors, 128)), "--samples", str(asked.samples)]
    if hasattr(os, "sched_setaffinity"):
        command = ["taskset", "-c", "0,1", *command]
    environment = os.environ | {"JAX_PLATFORMS": "cpu"}
    output = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    document["sensors_per_s_of_two_cores"] = json.loads(output.stdout)
    document["ratio"] = document["sensors_per_s"] / document["sensors_per_s_of_two_cores"]
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
