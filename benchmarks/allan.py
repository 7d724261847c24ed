"""How fast the overlapping Allan variance is, beside allantools on the same data in the same run.

    python -m benchmarks.allan [--channels 6] [--samples 2000000] [--sizes 50] [--runs 5]

Compilation is counted by itself. The roofline is one copy of the data: no exact answer can be had
without reading it once.
"""

import argparse
import json
import time
from pathlib import Path

import allantools
import jax
import jax.numpy as jnp
import numpy as np

import allanfit

from ._machine import fastest, machine

RESULTS = Path(__file__).parent / "results" / "allan.json"


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--channels", type=int, default=6)
    parser.add_argument("--samples", type=int, default=2_000_000)
    parser.add_argument("--sizes", type=int, default=50)
    parser.add_argument("--runs", type=int, default=5)
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    x = np.random.default_rng(0).standard_normal((asked.channels, asked.samples))
    sizes, more = np.zeros(0, int), asked.sizes
    while sizes.size < asked.sizes:  # Rounding makes neighbours equal: ask for more.
        sizes = np.unique(np.geomspace(1, asked.samples // 3, more).astype(int))
        more += 1
    data = jnp.asarray(x)

    def ours():
        return allanfit.allan_variance(data, 1.0, sizes).block_until_ready()

    def theirs():
        return [allantools.oadev(row, data_type="freq", taus=sizes)[1] for row in x]

    start = time.perf_counter()
    found = np.asarray(ours())
    first = time.perf_counter() - start
    fast, slow = fastest(ours, asked.runs), fastest(theirs, max(asked.runs // 2, 1))
    copy = fastest(lambda: x.copy(), asked.runs)
    document = {
        "channels": asked.channels,
        "samples": asked.samples,
        "sizes": int(sizes.size),
        "allanfit_s": fast,
        "compilation_s": first - fast,
        "allantools_s": slow,
        "ratio": slow / fast,
        "one_copy_s": copy,
        "copies": fast / copy,
        "largest_relative_difference": float(np.max(np.abs(found / np.array(theirs()) ** 2 - 1))),
    } | machine("allantools")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(document, indent=1) + "\n")
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
