"""How long `explain` takes, and how much room, as a record grows.

    python -m benchmarks.long_explain [--samples 360000 2000000 17280000]

A gyro at 400 Hz with white noise and a random walk, and in it a line, a warm-up of a twentieth of
the record and a step: lines and courses are what costs most in long records. Each length runs in a
process of its own, with the command line's folder of compiled programs.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from allanfit.compilation import configure_program
from allanfit.explain import explain_recording
from allanfit.recording import Channel, Recording

from ._machine import machine, peak_mib

RESULTS = Path(__file__).parent / "results" / "long_explain.json"
RATE = 400.0


def recording(samples: int) -> Recording:
    """Noise of N = 0.005 and K = 2e-5, a line, a warm-up and a step, in deg/s."""
    rng, time_s = np.random.default_rng(5), np.arange(samples) / RATE
    end = samples / RATE
    x = 0.005 * RATE**0.5 * rng.standard_normal(samples)
    x += np.cumsum(rng.standard_normal(samples)) * 2e-5 * RATE**-0.5
    x += 0.004 * np.sin(2 * np.pi * 37.123 * time_s) + 0.02 * np.exp(-time_s / (end / 20))
    x += 0.004 * (time_s > 0.6 * end)
    unit = np.pi / 180
    channel = Channel("gyro_x", "deg/s", unit, "rad/s", "gyro", x * unit, ((0, samples),), ())
    return Recording("long", RATE, (channel,), (), (), "")


def measured(samples: int) -> dict:
    configure_program()
    whole = recording(samples)
    start = time.perf_counter()
    (channel,) = explain_recording(whole, posterior=False).to_dict()["channels"]
    return {
        "samples": samples,
        "seconds": time.perf_counter() - start,
        "peak_mib": peak_mib(),
        "effects": [effect["name"] for effect in channel["effects"]],
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, nargs="+", default=[360_000, 2_000_000, 17_280_000])
    asked = parser.parse_args(arguments)
    rows = []
    for samples in asked.samples:
        code = f"from benchmarks.long_explain import *; print(json.dumps(measured({samples})))"
        told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
        rows.append(json.loads(told.stdout))
        print(rows[-1], flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps({"lengths": rows, **machine()}, indent=1) + "\n")


if __name__ == "__main__":
    main()
