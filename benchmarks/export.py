"""How well, and with how many states, do Gauss-Markov sums stand for flicker in a Kalman filter?

    python -m benchmarks.export                # a minute
    python -m benchmarks.export --records 40   # and the round trip with more records

The first table fits sums to bands of one to seven decades, for each number of states, and gives
the largest error of the Allan deviation within the band. The second simulates the exported
matrices by the filter's own equations, fits the records, and compares with what was exported.
"""

import argparse
import json
import tempfile
from pathlib import Path

import jax
import numpy as np

import allanfit
from allanfit.export import ExportError, export, fit_relaxations
from allanfit.export._parts import flicker_variance

_DT = 0.01
_FIRST = 4  # samples, where the band starts
_ERRORS = (0.2, 0.1, 0.05, 0.02, 0.01)
_TRUTH = {"N": 5e-3, "B": 4e-3, "K": 2e-3}
_RATE, _SAMPLES = 50.0, 30_000


def states_table():
    print("Fewest states for a largest error of the Allan deviation (error reached in brackets)\n")
    print("| band | " + " | ".join(f"{error:.0%}" for error in _ERRORS) + " |")
    print("|---" * (len(_ERRORS) + 1) + "|")
    target = flicker_variance(_DT, "point")
    for decades in range(1, 8):
        band = (_FIRST * _DT, _FIRST * _DT * 10.0**decades)
        cells = [_cell(target, band, error) for error in _ERRORS]
        print(f"| {band[0]:g} s to {band[1]:g} s | " + " | ".join(cells) + " |")


def _cell(target, band, error):
    try:
        found = fit_relaxations(target, _DT, band, error)
    except ExportError:
        return "-"
    return f"{len(found.relaxations)} ({found.worst_error:.1%})"


def round_trip(records):
    entry = _exported()
    discrete = {name: np.array(matrix) for name, matrix in entry["discrete"].items()}
    data = _simulated(discrete, entry, records)
    fits = allanfit.fit_many(np.ascontiguousarray(data.T), _RATE)
    print(
        f"\n{records} records of {_SAMPLES / _RATE:g} s at {_RATE:g} Hz from Phi, Qd, H and Rd, "
        "fitted again\n\n| term | exported | mean of the fits | standard error of it "
        "| inside the 95 % intervals |\n|---|---|---|---|---|"
    )
    for symbol, true in _TRUTH.items():
        values = np.asarray(fits.least_squares[symbol])
        low, high = np.asarray(fits.intervals[symbol]).T
        inside = np.mean((low <= true) & (true <= high))
        error = values.std(ddof=1) / np.sqrt(records)
        print(f"| {symbol} | {true:.3g} | {values.mean():.3g} | {error:.2g} | {inside:.2f} |")


def _exported():
    """The filter of a fit made by hand."""
    coefficients = {
        symbol: {
            "name": symbol, "unit": "", "value": _TRUTH.get(symbol, 0.0),
            "resolved": symbol in _TRUTH, "upper_limit_95": None, "intervals": {},
        }
        for symbol in "QNBKR"
    }  # fmt: skip
    channel = {
        "channel": "x", "unit": "deg/s", "rate_hz": _RATE, "samples": _SAMPLES,
        "coefficients": coefficients,
    }  # fmt: skip
    document = {"schema": "allanfit.fit/1", "recording": "by hand", "channels": [channel]}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fit.json"
        path.write_text(json.dumps(document))
        return json.loads(export(path, "kalman").text)["channels"][0]


def _simulated(discrete, entry, records):
    random = np.random.default_rng(0)
    starts = np.array([state["initial_variance"] or 0.0 for state in entry["states"]])
    x = np.sqrt(starts)[:, None] * random.standard_normal((len(starts), records))
    root = np.linalg.cholesky(discrete["Qd"])
    out = np.empty((_SAMPLES, records))
    for k in range(_SAMPLES):
        out[k] = (discrete["H"] @ x)[0]
        x = discrete["Phi"] @ x + root @ random.standard_normal(x.shape)
    return out + np.sqrt(discrete["Rd"][0, 0]) * random.standard_normal(out.shape)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=20)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    states_table()
    round_trip(options.records)


if __name__ == "__main__":
    main()
