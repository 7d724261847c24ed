"""How long the first calls in a new process take, and the first commands of a new user.

    python -m benchmarks.cold

White noise, a flicker floor and a random walk at 50 Hz. In Python: the import, the first fit, and
one of another length, with nothing kept from other processes. On the command line: `fit` without
emcee and `explain`, with an empty folder of compiled programs, and again with what that left.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import allanfit

from ._machine import machine

RESULTS = Path(__file__).parent / "results" / "cold.json"
LENGTHS = (36_000, 30_000)
COMMANDS = (("fit", "--no-posterior"), ("explain",))

IN_PYTHON = """
import time
begin = time.perf_counter()
import allanfit, json, sys
told = {"import": time.perf_counter() - begin}
for name, samples in zip(("first fit", "fit of another length"), json.loads(sys.argv[1])):
    noise = {"N": 5e-3, "B": 2e-3, "K": 1e-4}
    x = allanfit.simulate(noise, duration_s=samples / 50, rate_hz=50.0, seed=1)
    begin = time.perf_counter()
    allanfit.fit(x, 50.0).coefficients["N"].block_until_ready()
    told[name] = time.perf_counter() - begin
print(json.dumps(told))
"""


def in_python() -> dict[str, float]:
    """Seconds of each, in a new process without a cache."""
    quiet = {key: each for key, each in os.environ.items() if key != "JAX_COMPILATION_CACHE_DIR"}
    command = [sys.executable, "-c", IN_PYTHON, json.dumps(LENGTHS)]
    told = subprocess.run(command, check=True, capture_output=True, env=quiet)
    return json.loads(told.stdout)


def commands(folder: Path) -> dict[str, float]:
    """Seconds of each command, the first time and again."""
    recording = folder / "gyro.npz"
    noise = {"N": 5e-3, "B": 2e-3, "K": 1e-4}
    x = np.asarray(allanfit.simulate(noise, duration_s=720, rate_hz=50.0, seed=1))
    np.savez(recording, gyro_x=x, rate_hz=50.0, units='{"gyro_x": "deg/s"}')
    env = {**os.environ, "JAX_COMPILATION_CACHE_DIR": str(folder / "compiled")}
    env |= {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    found = {}
    for turn in ("first", "again"):
        for name, *options in COMMANDS:
            command = [sys.executable, "-m", "allanfit", name, str(recording), *options]
            begin = time.perf_counter()
            subprocess.run(command, check=True, capture_output=True, env=env)
            found[f"{name}, {turn}"] = time.perf_counter() - begin
    return found


def main():
    seconds = in_python()
    with tempfile.TemporaryDirectory() as folder:
        seconds |= commands(Path(folder))
    for name, each in seconds.items():
        print(f"{name:24s}{each:6.1f} s")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps({"seconds": seconds, **machine()}, indent=1) + "\n")


if __name__ == "__main__":
    main()
