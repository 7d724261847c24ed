"""How often does a fleet without an odd device have one named, and how often is one found?

    python -m benchmarks.fleet                    # twenty minutes of one core
    python -m benchmarks.fleet --fleets 50

Two studies. The rule alone: N of devices that differ by tau, each with an error of its own, is
drawn from the model of the test. The whole way: recordings are simulated in the time domain by
other means than the library's, from devices whose N and B differ, fitted, and compared as
`allanfit fleet` does. Devices that do not differ are among the fleets, and fleets of few.
"""

import argparse
import json
from pathlib import Path

import jax
import numpy as np

import allanfit
from allanfit.fleet import compare
from allanfit.fleet._compare import FALSE_ALARM
from allanfit.fleet._outliers import outliers
from allanfit.fleet._rows import columns
from allanfit.physics import SYMBOLS

from ._machine import machine
from .generators import record

RESULTS = Path(__file__).parent / "results" / "fleet.json"
_RATE_HZ = 50.0
_SAMPLES = 4096
_TRUTH = {"N": 5e-3, "B": 4e-3}
_ALPHA = 0.05
_ODD = 1.5  # times the fleet's N


def rule_alone(fleets):
    """Share of fleets with an outlier named by the rule at 5 %."""
    rows = []
    for devices in (5, 10, 20, 50):
        for tau in (0.0, 0.05):
            rng = np.random.default_rng((devices, round(1000 * tau)))
            named = 0
            for _ in range(fleets):
                errors = 0.02 * np.exp(0.3 * rng.standard_normal(devices))
                values = np.hypot(tau, errors) * rng.standard_normal(devices)
                named += bool(outliers(values, errors, _ALPHA))
            rows.append({"devices": devices, "tau": tau, "named": named, "fleets": fleets})
            print(f"{devices:3d} devices, tau {tau:4.2f}: named in {named} of {fleets} at {_ALPHA}")
    return rows


def rows_of(fits, devices):
    """The rows of `allanfit fleet` for a batch of one channel of each device."""
    rows = []
    for k in range(devices):
        row = {
            "path": f"/{k}", "channel": "gyro_x", "quantity": "gyro_x", "device": str(k),
            "unit": "deg/s", "si_unit": "rad/s", "si_factor": np.pi / 180, "status": "converged",
            "findings": [], "p_value": float(fits.goodness_of_fit[k]),
            "nyquist_score": float(fits.estimate.quantization_score[k]),
        }  # fmt: skip
        for symbol in SYMBOLS:
            resolved = bool(fits.resolved[symbol][k])
            low, high = map(float, fits.intervals[symbol][k])
            limit = None if resolved else float(fits.upper_limits[symbol][k])
            values = {
                "value": float(fits.coefficients[symbol][k]), "resolved": resolved,
                "upper_limit": limit, "low": low, "high": high, "unit": "",
            }  # fmt: skip
            row |= {name: values[what] for what, name in columns(symbol).items()}
        rows.append(row)
    return rows


def whole_way(fleets, devices, tau):
    """Fleets with anything named, without an odd device and with one whose N is larger."""
    named = found = beside = 0
    for number in range(fleets):
        rng = np.random.default_rng((17, devices, round(1000 * tau), number))
        factors = np.exp(tau * rng.standard_normal(devices))
        data = np.stack(
            [
                record(rng, _SAMPLES, 1 / _RATE_HZ, {s: v * f for s, v in _TRUTH.items()})
                for f in factors
            ]
        )
        healthy = compare(rows_of(allanfit.fit_many(data, _RATE_HZ, seed=number), devices))
        named += bool(healthy.outliers)
        data[0] *= _ODD / factors[0]
        odd = compare(rows_of(allanfit.fit_many(data, _RATE_HZ, seed=number), devices))
        devices_named = {each.device for each in odd.outliers}
        found += "0" in devices_named
        beside += bool(devices_named - {"0"})
    print(
        f"{devices:3d} devices, tau {tau:4.2f}: {fleets} fleets; named without an odd device "
        f"{named} (allowed {FALSE_ALARM:.0%}), N of {_ODD} times found {found}, others beside it "
        f"{beside}"
    )
    return {
        "devices": devices, "tau": tau, "fleets": fleets, "named": named, "found": found,
        "others_named": beside,
    }  # fmt: skip


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fleets", type=int, default=200)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    document = {
        "odd_factor": _ODD,
        "rule_alone": rule_alone(options.fleets),
        "whole_way": [
            whole_way(options.fleets, devices, tau)
            for devices, tau in ((8, 0.05), (16, 0.0), (16, 0.05))
        ],
    } | machine("scipy")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
