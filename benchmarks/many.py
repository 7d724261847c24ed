"""What a batch costs: curves, fits and intervals of many recordings, part by part.

    python -m benchmarks.many [--sensors 1000] [--samples 60000] [--json FILE]

The samples lie in a file that is mapped and not read, so that the peak of memory shows what the
library itself needs. Compilation is counted by itself. Processor seconds are given beside seconds
by the clock: they say what the parts cost where other programs keep the cores busy.

The ratio is to the GMWM package (simts 0.2.4), which took 0.6 s to fit one recording of 60,000
samples and 3.5 s for its intervals on two cores: measured elsewhere, once, and not in this run.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import jax
import numpy as np

import allanfit

from ._machine import machine, peak_mib

RESULTS = Path(__file__).parent / "results" / "many.json"
GMWM_SECONDS = 4.1
RATE_HZ = 100.0
GROUP = 16


def cost(run: Callable[[], object]) -> dict[str, float]:
    """Seconds by the clock, and of all cores together."""
    clock, processor = time.perf_counter(), time.process_time()
    jax.block_until_ready(run())
    return {"s": time.perf_counter() - clock, "processor_s": time.process_time() - processor}


def write_recordings(path: Path, sensors: int, samples: int) -> np.memmap:
    """White noise and a random walk, of another strength for every sensor."""
    shape = (sensors, samples)
    data = np.lib.format.open_memmap(path, mode="w+", dtype=np.float64, shape=shape)
    for i in range(sensors):
        rng = np.random.default_rng((11, i))
        walk = np.cumsum(rng.standard_normal(samples)) * 10 ** rng.uniform(-6, -4)
        data[i] = 1e-2 * rng.standard_normal(samples) + walk
    data.flush()
    return np.load(path, mmap_mode="r")


def measure(sensors: int, samples: int) -> dict:
    """All parts over all recordings, the curves a group at a time."""
    with tempfile.TemporaryDirectory() as folder:
        data = write_recordings(Path(folder) / "recordings.npy", sensors, samples)

        def by_group(curve: Callable[[np.ndarray], object]) -> None:
            for first in range(0, sensors, GROUP):
                jax.block_until_ready(curve(data[first : first + GROUP]))

        def allan(group: np.ndarray):
            return allanfit.allan_variance(group, RATE_HZ)

        def density(group: np.ndarray):
            return allanfit.psd(group, RATE_HZ).density

        # Compiled beforehand, and all memory touched that does not grow with the batch.
        small = allanfit.fit_many(data[:GROUP], RATE_HZ)
        jax.block_until_ready((allan(data[:GROUP]), density(data[:GROUP])))
        jax.block_until_ready((small.coefficients, small.intervals))
        before = round(peak_mib() * 2**20)
        parts = {
            "allan_variance": cost(lambda: by_group(allan)),
            "psd": cost(lambda: by_group(density)),
        }
        fits = []
        parts["fit_many"] = cost(
            lambda: fits.append(allanfit.fit_many(data, RATE_HZ)) or fits[0].estimate
        )
        grown = round(peak_mib() * 2**20) - before
        parts["intervals"] = cost(lambda: (fits[0].coefficients, fits[0].intervals))
        leaves = jax.tree.leaves(fits[0].estimate)
        converged = int(np.sum(np.asarray(fits[0].converged)))
    total = {key: sum(part[key] for part in parts.values()) for key in ("s", "processor_s")}
    return {
        "sensors": sensors,
        "samples": samples,
        "converged": converged,
        "parts": {
            name: {f"{key}_per_recording": value / sensors for key, value in part.items()}
            for name, part in parts.items()
        },
        "s_per_recording": total["s"] / sensors,
        "processor_s_per_recording": total["processor_s"] / sensors,
        "sensors_per_s": sensors / total["s"],
        "gmwm_s_per_recording_measured_elsewhere": GMWM_SECONDS,
        "ratio_to_gmwm": GMWM_SECONDS / (total["s"] / sensors),
        "data_bytes": sensors * samples * 8,
        "result_bytes": sum(leaf.nbytes for leaf in leaves),
        "peak_bytes_above_warm": grown,
        "peak_bytes": round(peak_mib() * 2**20),
    }


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sensors", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=60_000)
    parser.add_argument("--json", type=Path, default=RESULTS)
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    start = time.perf_counter()
    allanfit.fit_many(np.random.default_rng(0).standard_normal((GROUP, asked.samples)), RATE_HZ)
    first = time.perf_counter() - start
    document = {"first_group_with_compilation_s": first}
    document |= measure(asked.sensors, asked.samples) | machine()
    asked.json.parent.mkdir(exist_ok=True)
    asked.json.write_text(json.dumps(document, indent=1) + "\n")
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
