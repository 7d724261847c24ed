"""Records longer than memory: how fast, how near, and how much room a whole fit takes.

    python -m benchmarks.long [--samples 200000000] [--records 60] [--fit 17280000]
        [--files npy:100000000 csv:10000000 npz:10000000 parquet:10000000 h5:10000000]

Blocks come from a file of float64 that is mapped, as a user's would. What leaving out positions
does is told in standard errors of the variance, found from as many records.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import jax
import numpy as np
import polars as pl

import allanfit
from allanfit.curves import LongStatistics, design, statistics

from ._machine import machine, peak_mib

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
    before = peak_mib()
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
        "rise_of_peak_mib": peak_mib() - before,
    }


def whole_file(folder: Path, ending: str, samples: int) -> dict:
    """Both curves of a file of one channel, in a process of its own, beside reading it alone."""
    path = folder / f"one.{ending}"
    _write(path, samples)
    start = time.perf_counter()
    with path.open("rb", buffering=0) as file:
        while file.read(1 << 24):
            pass
    bytes_alone = time.perf_counter() - start
    found = {}
    for name, work in (
        ("blocks_alone", "sum(run.samples.size for run in read_in_blocks(path, **given))"),
        ("curves", "curves_of_file(path, **given)"),
    ):
        code = (
            "import sys, time\n"
            "from benchmarks._machine import peak_mib\n"
            "from allanfit import curves_of_file\n"
            "from allanfit.recording import read_in_blocks\n"
            "path, given = sys.argv[1], dict(rate_hz=100.0, unit='deg/s')\n"
            f"start = time.perf_counter()\n{work}\n"
            "print(time.perf_counter() - start, peak_mib())"
        )
        told = subprocess.run(
            [sys.executable, "-c", code, str(path)], check=True, capture_output=True, text=True
        )
        seconds, peak = map(float, told.stdout.split())
        # The peak holds JAX and, for .npy, the pages of the file that are mapped.
        found[name] = {"seconds": seconds, "samples_a_s": samples / seconds, "peak_mib": peak}
    size = path.stat().st_size
    path.unlink()
    return {
        "format": ending,
        "samples": samples,
        "bytes": size,
        "bytes_alone_s": bytes_alone,
    } | found


def _write(path: Path, samples: int) -> None:
    rng = np.random.default_rng(0)
    if path.suffix == ".npy":
        mapped = np.lib.format.open_memmap(path, "w+", np.float64, (samples,))
        for start in range(0, samples, BLOCK):
            stop = min(start + BLOCK, samples)
            mapped[start:stop] = rng.standard_normal(stop - start)
        return
    x = rng.standard_normal(samples).round(6)
    if path.suffix == ".csv":
        pl.DataFrame({"x": x}).write_csv(path)
    elif path.suffix == ".npz":
        np.savez(path, x=x)
    elif path.suffix == ".parquet":
        pl.DataFrame({"x": x}).write_parquet(path)
    else:
        import h5py

        with h5py.File(path, "w") as file:
            file["x"] = x


def one_pass_against_memory(samples: int) -> dict:
    """How far the curves are from those of the samples in memory, for each kind of noise.

    The density in standard errors of its bins, as far as each is from what its own design expects.
    """
    rng = np.random.default_rng(3)
    white = rng.standard_normal(samples + 1)
    order = np.fft.rfftfreq(2 * samples)
    shape = np.append(0, order[1:] ** -0.5)
    flicker = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * samples)) * shape)[:samples]
    kinds = {
        "quantization": (np.diff(white), 0),
        "white": (white[1:], 1),
        "flicker": (flicker, 2),
        "walk": (np.cumsum(white)[1:], 3),
        "white and ramp": (white[1:] + 1e-5 * np.arange(samples), 1),
    }
    whole, found = design((samples,)), {}
    for name, (x, term) in kinds.items():
        taken = LongStatistics()
        for start in range(0, samples, BLOCK):
            taken.add(x[start : start + BLOCK])
        taken.end_stretch()
        value, layout = taken.value()
        known = statistics((jax.numpy.asarray(x),), whole)
        level = np.asarray(known.density) / whole.density[:, term]
        other = np.asarray(value.density) / layout.density[:, term]
        apart = (other - level) / np.median(level) * np.sqrt(whole.ordinates / 2)
        small = whole.cluster_sizes <= 8192
        allan = np.abs(np.asarray(value.allan) / np.asarray(known.allan) - 1)
        found[name] = {
            "allan_to_8192": float(allan[small].max()),
            "density_rms_se": float(np.sqrt(np.mean(apart**2))),
            "density_max_se": float(np.abs(apart).max()),
        }
    return {"samples": samples, "kinds": found}


def nearness(records: int) -> dict:
    """The rms of what is lost, in standard errors, largest over sizes above 8192."""
    sizes = allanfit.cluster_sizes(RECORD)
    large = sizes > 8192
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
    code = (
        "import sys\n"
        "from allanfit.cli import main\n"
        "from benchmarks._machine import peak_mib\n"
        "assert main(sys.argv[1:]) == 0\n"
        "print(peak_mib())"
    )
    start = time.perf_counter()
    told = subprocess.run(
        [sys.executable, "-c", code, "fit", str(path), "--no-posterior", "--json", os.devnull],
        check=True,
        capture_output=True,
        text=True,
    )
    return {
        "samples": samples,
        "channels": len(CHANNELS),
        "seconds": time.perf_counter() - start,
        "peak_mib": float(told.stdout.split()[-1]),
        "float64_of_the_samples_mib": 8 * samples * len(CHANNELS) / 2**20,
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=200_000_000)
    parser.add_argument("--records", type=int, default=60)
    parser.add_argument("--fit", type=int, default=17_280_000, help="samples a channel; 0: no fit")
    parser.add_argument(
        "--files",
        nargs="*",
        default=[
            "npy:100000000",
            *(f"{e}:10000000" for e in ("npy", "csv", "npz", "parquet", "h5")),
        ],
        help="formats and samples of files to read in blocks",
    )
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        document = {
            "one_pass": speed(folder, asked.samples) if asked.samples else None,
            "lost_in_standard_errors": nearness(asked.records) if asked.records else None,
            "files": [
                whole_file(folder, ending, int(samples))
                for ending, _, samples in (each.partition(":") for each in asked.files)
            ],
            "one_pass_against_memory": one_pass_against_memory(3_000_000),
            "fit": whole_fit(folder, asked.fit) if asked.fit else None,
        }
    document |= machine()
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(document, indent=1) + "\n")
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
