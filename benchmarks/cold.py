"""How long the first calls in a new process take, and the first commands of a new user.

    python -m benchmarks.cold

White noise, a flicker floor and a random walk at 50 Hz. In Python: the import, the first fit, and
one of another length, with nothing kept from other processes. On the command line: `fit` and
`explain` of 36,000 and of 360,000 samples, with an empty folder of compiled programs, and again
with what that left; the longer `fit` over what it takes to import JAX and to read the file.
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
RECORDINGS = {"short": 36_000, "long": 360_000}
COMMANDS = (("fit", "--no-posterior"), ("fit",), ("explain",))
LEAST = "import jax, sys, numpy; numpy.load(sys.argv[1])['gyro_x'].sum()"

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
    noise = {"N": 5e-3, "B": 2e-3, "K": 1e-4}
    env = {**os.environ, "JAX_COMPILATION_CACHE_DIR": str(folder / "compiled")}
    env |= {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    found = {}
    for length, samples in RECORDINGS.items():
        recording = folder / f"{length}.npz"
        x = np.asarray(allanfit.simulate(noise, duration_s=samples / 50, rate_hz=50.0, seed=1))
        np.savez(recording, gyro_x=x, rate_hz=50.0, units='{"gyro_x": "deg/s"}')
        for turn in ("first", "again"):
            for name, *options in COMMANDS:
                command = ["-m", "allanfit", name, str(recording), *options]
                label = f"{' '.join([name, *options])}, {length}, {turn}"
                found[label] = _seconds(command, env)
        found[f"import jax and read, {length}"] = _seconds(["-c", LEAST, str(recording)], env)
    return found


def _seconds(arguments: list[str], env: dict[str, str]) -> float:
    begin = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=env)
    return time.perf_counter() - begin


def main():
    seconds = in_python()
    with tempfile.TemporaryDirectory() as folder:
        seconds |= commands(Path(folder))
    for name, each in seconds.items():
        print(f"{name:36s}{each:6.1f} s")
    ratio = seconds["fit, long, again"] / seconds["import jax and read, long"]
    print(f"{'the longer fit over the least':36s}{ratio:6.1f}")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(
        json.dumps({"seconds": seconds, "ratio": ratio, **machine()}, indent=1) + "\n"
    )


if __name__ == "__main__":
    main()
