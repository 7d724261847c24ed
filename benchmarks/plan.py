"""Do records of the planned length tell the coefficients as well as the plan says?

    python -m benchmarks.plan                  # three minutes, most of it compiling
    python -m benchmarks.plan --records 400

Simulates each sensor for the length that its wish takes, in the time domain and by other means
than the library's, fits, and compares the root mean square error with the plan's.
"""

import argparse

import jax
import numpy as np

import allanfit

from .generators import record

# rate [Hz], coefficients, what is wanted.
SENSORS = {
    "consumer gyro": (50.0, {"N": 5e-3, "B": 2e-3, "K": 3e-4}, {"N": 0.01, "B": 0.1}),
    "old MEMS gyro, large Q": (
        50.0, {"Q": 3e-4, "N": 1e-3, "B": 6e-4, "K": 8e-5}, {"N": 0.01, "K": 0.3},
    ),
    "accelerometer without flicker": (20.0, {"N": 5e-3, "K": 5e-4}, {"K": 0.1}),
    "flicker and a ramp": (20.0, {"N": 5e-3, "B": 2e-3, "R": 1e-5}, {"B": 0.05, "R": 0.1}),
}  # fmt: skip
_CHUNK = 40
_NOTES = """
Where a ratio is not near one: errors are told to first order, and at 30 % the least-squares value
of a record in twenty is zero; medians stand up to that. The angle error of these records is a
uniform one, whose squares scatter less than a normal one's, so that Q does better than planned.
Least squares pays for seeking an absent Q (a factor of 1.4 in N), which medians hardly do; the
plan counts on medians.
The interval of a ramp allows for a random walk that is not there."""


def fitted(rate_hz, coefficients, samples, records):
    """Least-squares values, medians and 68 % half-widths by symbol, shape (records,) each."""
    found = {}
    for first in range(0, records, _CHUNK):
        data = np.stack(
            [
                record(np.random.default_rng((11, i)), samples, 1 / rate_hz, coefficients)
                for i in range(first, min(first + _CHUNK, records))
            ]
        )
        fits = allanfit.fit_many(data, rate_hz, seed=first)
        for symbol in coefficients:
            low, high = fits.interval(0.68)[symbol].T
            numbers = fits.least_squares[symbol], fits.coefficients[symbol], (high - low) / 2
            found.setdefault(symbol, []).append(np.stack(numbers))
    return {symbol: np.concatenate(parts, axis=1) for symbol, parts in found.items()}


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=100)
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    print(
        f"{options.records} records a sensor; the standard error of a ratio is "
        f"{(2 * options.records) ** -0.5:.2f}. A * marks what sets the length.\n\n"
        "| sensor | length | term | wanted | planned error | least squares / planned "
        "| median / planned | 68 % half-width / planned |\n|---|---|---|---|---|---|---|---|"
    )
    for name, (rate_hz, coefficients, want) in SENSORS.items():
        planned = allanfit.plan(coefficients, rate_hz, want)
        assert planned.duration_s is not None
        samples = round(planned.duration_s * rate_hz)
        found = fitted(rate_hz, coefficients, samples, options.records)
        for symbol, (least_squares, median, half_width) in found.items():
            error = planned.relative_standard_error[symbol]
            truth = coefficients[symbol]
            ratios = [
                np.sqrt(np.mean((least_squares / truth - 1) ** 2)) / error,
                np.sqrt(np.mean((median / truth - 1) ** 2)) / error,
                np.median(half_width) / truth / error,
            ]
            mark = "*" if symbol == planned.set_by else ""
            wish = f"{want[symbol]:.0%}{mark}" if symbol in want else ""
            print(
                f"| {name} | {planned.duration_s / 3600:.2f} h | {symbol} | {wish} | {error:.2%} | "
                + " | ".join(f"{ratio:.2f}" for ratio in ratios) + " |"
            )  # fmt: skip
    print(_NOTES)


if __name__ == "__main__":
    main()
