"""How often intervals of N hold where quantization rules: ends of the record evened, or not.

    python -m benchmarks.ends                 # 40 records a row, three minutes
    python -m benchmarks.ends --records 200

Records of N = 1 beside the differences of errors of an angle, Q times N a sample, fitted with the
errors at both ends evened (`curves/_ends.py`), as `allanfit.fit` does, and as they are.
"""

import jax
import jax.numpy as jnp
import numpy as np
from rich.console import Console
from rich.progress import track

import allanfit
from allanfit.curves import design
from allanfit.identify import Fit
from allanfit.identify._estimate import estimate

from ._records import keep, record_options

SAMPLES = 60_000
RATIOS = (1.0, 20.0, 100.0, 300.0)


def holds(fit) -> bool:
    """Whether the 95 % interval of N holds it."""
    low, high = np.asarray(fit.intervals["N"]).reshape(2)
    return bool(low <= 1 <= high)


def main(arguments=None):
    options = record_options(__doc__, 40, arguments)
    layout, rows = design((SAMPLES,)), []
    for ratio in RATIOS:
        evened = as_it_is = 0
        for seed in track(range(options.records), f"Q/N {ratio:g}", console=Console(stderr=True)):
            rng = np.random.default_rng((7, int(ratio), seed))
            angle = ratio * rng.standard_normal(SAMPLES + 1)
            x = rng.standard_normal(SAMPLES) + np.diff(angle)
            evened += holds(allanfit.fit(x, 1.0))
            plain = estimate((jnp.asarray(x),), layout, 1.0, jax.random.key(0))
            as_it_is += holds(Fit(plain, layout, 1.0))
        rows.append({"ratio": ratio, "evened": evened, "as it is": as_it_is})
    print(f"| Q/N | evened | as it is | of\n|{'---|' * 4}")
    for row in rows:
        print(f"| {row['ratio']:g} | {row['evened']} | {row['as it is']} | {options.records} |")
    keep(options, "ends", rows)


if __name__ == "__main__":
    main()
