"""Records longer than memory: how fast, how near, and how much room a whole fit takes.

    python -m benchmarks.long [--samples 200000000] [--records 60] [--fit 17280000]

Blocks come from a file of float64 that is mapped, as a user's would. What leaving out positions
does is told in standard errors of the variance, found from as many records.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import jax
import numpy as np

import allanfit

from ._machine import machine

RESULTS = Path(__file__).parent / "results" / "long.json"
BLOCK = 1 << 20
RECORD = 400_000
CHANNELS = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]


def pass_over(x: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    variance = allanfit.LongAllanVariance(sizes)
    for start in range(0, x.size, BLOCK):
        variance.add(x[start : start + BLOCK])
    return variance.value()


def speed(folder: Path, samples: int) -> dict:
    path = folder / "long.npy"
    mapped = np.lib.format.open_memmap(path, "w+", np.float64, (samples,))
    rng = np.random.default_rng(0)
    for start in range(0, samples, BLOCK):
        stop = min(start + BLOCK, samples)
        mapped[start:stop] = rng.standard_normal(stop - start)
    mapped.flush()
    sizes = allanfit.cluster_sizes(samples)
    # Compiled before the clock runs.
    pass_over(np.asarray(mapped[: 2 * BLOCK]), sizes)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    sum(float(mapped[at : at + BLOCK].sum()) for at in range(0, samples, BLOCK))
    read = time.perf_counter() - start
    start = time.perf_counter()
    pass_over(mapped, sizes)
    taken = time.perf_counter() - start
    return {
        "samples": samples,
        "sizes": int(sizes.size),
        "seconds": taken,
        "reading_alone_s": read,
        "ns_a_sample": 1e9 * taken / samples,
        # Pages of the mapped file among it.
        "rise_of_peak_mib": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024,
    }


def nearness(records: int) -> dict:
    """The rms of what is lost, in standard errors, largest over sizes above 2048."""
    sizes = allanfit.cluster_sizes(RECORD)
    large = sizes >= 2048
    found = {}
    for kind in ("white", "walk", "quantization"):
        every, fewer = [], []
        for seed in range(records):
            x = np.random.default_rng(seed).standard_normal(RECORD + 1)
            x = {"white": x[1:], "walk": np.cumsum(x)[1:], "quantization": np.diff(x)}[kind]
            every.append(np.asarray(allanfit.allan_variance(x, 1.0, sizes))[large])
            fewer.append(pass_over(x, sizes)[large])
        every, fewer = np.array(every), np.array(fewer)
        error = np.sqrt(np.mean((fewer - every) ** 2, axis=0)) / every.std(axis=0)
        found[kind] = float(error.max())
    return found


def whole_fit(folder: Path, samples: int) -> dict:
    """`allanfit fit --no-posterior` on six channels, in a process of its own."""
    path = folder / "six.npz"
    rng = np.random.default_rng(0)
    units = {name: "rad/s" if name.startswith("gyro") else "m/s^2" for name in CHANNELS}
    columns = {name: rng.standard_normal(samples).astype(np.float32) for name in CHANNELS}
    np.savez(path, rate_hz=400.0, units=json.dumps(units), **columns)
    code = "import sys; from allanfit.cli import main; sys.exit(main(sys.argv[1:]))"
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", code, "fit", str(path), "--no-posterior", "--json", os.devnull],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return {
        "samples": samples,
        "channels": len(CHANNELS),
        "seconds": time.perf_counter() - start,
        "peak_mib": resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024,
        "float64_of_the_samples_mib": 8 * samples * len(CHANNELS) / 2**20,
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=200_000_000)
    parser.add_argument("--records", type=int, default=60)
    parser.add_argument("--fit", type=int, default=17_280_000, help="samples a channel; 0: no fit")
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        document = {
            "one_pass": speed(folder, asked.samples),
            "lost_in_standard_errors": nearness(asked.records),
            "fit": whole_fit(folder, asked.fit) if asked.fit else None,
        }
    document |= machine()
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(document, indent=1) + "\n")
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
