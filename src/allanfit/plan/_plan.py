"""How long a still record must be for coefficients to be known as well as wanted."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..formatting import listed
from ..physics import SYMBOLS, Sampling, check_sampling
from ._errors import relative_errors
from ._length import LONGEST_YEARS, longest_samples, shortest_samples
from ._want import checked_want

# The slowest rate at which ten years hold enough samples for a fit; no sensor reaches the other.
_SLOWEST_HZ, _FASTEST_HZ = 1e-6, 1e6
# Fourth powers and their ratios must stay numbers, and no unit makes a sensor's coefficient so.
_SMALLEST, _LARGEST = 1e-40, 1e40


@dataclass(frozen=True)
class Plan:
    """Lengths of one still record without gaps, and what it will tell.

    Every error is a relative standard error, the half-width of a 68 % interval over the value; a
    95 % interval is twice as wide.
    """

    coefficients: dict[str, float]
    """What the sensor is taken to have, in its unit and seconds, without the zeros."""
    rate_hz: float
    sampling: Sampling
    want: dict[str, float]
    """Relative standard error that is wanted, by symbol."""
    durations_s: dict[str, float | None]
    """Length that each wanted error takes [s]; None where ten years are not enough."""
    at_s: float
    """Length of `relative_standard_error` [s]: the longest that is not out of reach."""
    relative_standard_error: dict[str, float]
    """Of each coefficient that is not zero, wanted or not, after `at_s`."""

    @property
    def duration_s(self) -> float | None:
        """Length that serves every wish [s]; None if one of them is out of reach."""
        lengths = [length for length in self.durations_s.values() if length is not None]
        return max(lengths) if len(lengths) == len(self.durations_s) else None

    @property
    def set_by(self) -> str | None:
        """The coefficient that sets `duration_s`."""
        by_symbol = self.durations_s
        return next((s for s in by_symbol if by_symbol[s] == self.duration_s is not None), None)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is out of reach and what counts as absent, a sentence each."""
        found = [
            f"{symbol} to {percent(self.want[symbol])} is out of reach: it would take more than "
            f"{LONGEST_YEARS} years."
            for symbol, length in self.durations_s.items()
            if length is None
        ]
        absent = [symbol for symbol in SYMBOLS if symbol not in self.coefficients]
        if absent:
            found.append(
                f"Zero, unresolved or not given, and so taken as absent: {listed(absent)}."
            )
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """The plan as plain data, for JSON."""
        return {
            "rate_hz": self.rate_hz,
            "sampling": self.sampling,
            "coefficients": self.coefficients,
            "want": self.want,
            "duration_s": self.duration_s,
            "set_by": self.set_by,
            "durations_s": self.durations_s,
            "evaluated_at_s": self.at_s,
            "relative_standard_error": self.relative_standard_error,
            "notes": list(self.notes),
        }

    def _repr_html_(self) -> str:
        """The plan as a table, for a notebook."""
        # The words know this class.
        from ._text import plan_html

        return plan_html(self)


def plan(
    coefficients: Mapping[str, float],
    rate_hz: float,
    want: Mapping[str, float],
    sampling: Sampling = "point",
) -> Plan:
    """How long a still record must be to tell each coefficient to a relative standard error.

    The errors are those that the fit's likelihood allows: the inverse of its Fisher information
    (the Cramér-Rao bound) on the squared coefficients, and, since the fit seeks absent terms too,
    what these cost their neighbours. A ramp, if wanted, is told against the noise by generalised
    least squares; its error falls as 1/sqrt(T) where a random walk makes slopes of its own. The
    estimates reach these errors from about 20 % down; cruder ones scatter otherwise.

    **Arguments:**

    - `coefficients`: by symbol Q, N, B, K, R, in the unit u of the sensor and seconds; what is
      not named is zero.
    - `rate_hz`: samples per second.
    - `want`: relative standard error by symbol, as a fraction: the half-width of a 68 % interval,
      half that of a 95 % interval.
    - `sampling`: "point" or "averaged", see `allanfit.physics`.

    **Raises:** `ValueError` for a coefficient that is unknown, negative, above zero but outside
    1e-40 to 1e40, or absent though wanted, a wanted error that is not between 0 and 1, and a rate
    outside 1e-6 to 1e6 Hz.

    >>> plan({"N": 5e-3, "B": 1e-3}, 50.0, {"B": 0.1}).set_by
    'B'
    """
    check_sampling(sampling)
    if not _SLOWEST_HZ <= rate_hz <= _FASTEST_HZ:
        raise ValueError(
            f"The rate must be from {_SLOWEST_HZ:g} to {_FASTEST_HZ:g} samples per second; "
            f"got {rate_hz:g}."
        )
    present = _present(coefficients)
    want = checked_want(want)
    for symbol in want:
        if symbol not in present:
            raise ValueError(
                f"{symbol} is wanted but absent from the coefficients: an error relative to zero "
                f"means nothing; give {symbol} a value or leave it out."
            )
    lengths = {
        symbol: shortest_samples(symbol, error, present, rate_hz, sampling)
        for symbol, error in want.items()
    }
    reached = [length for length in lengths.values() if length is not None]
    at = max(reached, default=longest_samples(rate_hz))
    return Plan(
        coefficients=present,
        rate_hz=float(rate_hz),
        sampling=sampling,
        want=want,
        durations_s={s: None if n is None else n / rate_hz for s, n in lengths.items()},
        at_s=at / rate_hz,
        relative_standard_error=relative_errors(present, rate_hz, at, sampling),
    )


def percent(fraction: float) -> str:
    """Two significant digits: `0.35 %`, `12 %`, and no more than `> 100 %`."""
    shown = 100 * fraction
    if shown > 100:
        return "> 100 %"
    return f"{shown:.0f} %" if shown >= 10 else f"{shown:.2g} %"


def _present(coefficients: Mapping[str, float]) -> dict[str, float]:
    for symbol, value in coefficients.items():
        if symbol not in SYMBOLS:
            raise ValueError(f"Unknown coefficient {symbol!r}; the five are {', '.join(SYMBOLS)}.")
        if not (value >= 0 and math.isfinite(value)):
            raise ValueError(f"Coefficient {symbol} must be zero or more; got {value}.")
        if value and not _SMALLEST <= value <= _LARGEST:
            raise ValueError(
                f"Coefficient {symbol} must be zero, or from {_SMALLEST:g} to {_LARGEST:g}; "
                f"got {value:g}."
            )
    present = {s: float(coefficients[s]) for s in SYMBOLS if coefficients.get(s)}
    if not set(present) - {"R"}:
        raise ValueError(
            "A plan needs noise: at least one of Q, N, B and K must be above zero, for without "
            "noise any record will do."
        )
    return present
