"""What a longer record would do for the coefficients of a fit."""

from collections.abc import Mapping

from ..formatting import duration
from ..physics import SYMBOLS, Sampling
from ._errors import relative_errors
from ._length import LONGEST_YEARS, shortest_samples

# Full width of a 95 % interval over the value, above which a longer record is worth a sentence.
_WIDE = 0.2
_WIDTH_95 = 2 * 1.96


def advice(
    coefficients: Mapping[str, float],
    resolved: Mapping[str, bool],
    duration_s: float,
    rate_hz: float,
    sampling: Sampling = "point",
    intervals: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[str, ...]:
    """How much longer to record for intervals half as wide, a sentence for each that is wide.

    **Arguments:**

    - `coefficients`, `resolved`: of one channel, by symbol; only resolved terms count as present,
      and of a term that is not resolved nothing is said, since its size is not known.
    - `duration_s`, `rate_hz`, `sampling`: of the record that was fitted.
    - `intervals`: the 95 % intervals of the fit, which tell the wide ones; without them, their
      expected widths do.

    **Returns:** sentences for those of Q, N, B and K whose 95 % interval is wider than 20 % of
    the value; none when nothing is resolved.
    """
    present = {s: float(coefficients[s]) for s in SYMBOLS if resolved.get(s) and coefficients[s]}
    noise = [symbol for symbol in present if symbol != "R"]
    if not noise:
        return ()
    errors = relative_errors(present, rate_hz, round(duration_s * rate_hz), sampling)
    found = []
    for symbol in noise:
        width = _WIDTH_95 * errors[symbol]
        if intervals is not None:
            low, high = intervals[symbol]
            width = (high - low) / present[symbol]
        if width > _WIDE:
            samples = shortest_samples(symbol, errors[symbol] / 2, present, rate_hz, sampling)
            found.append(_sentence(symbol, samples, rate_hz, duration_s))
    return tuple(found)


def _sentence(symbol: str, samples: int | None, rate_hz: float, duration_s: float) -> str:
    if samples is None:
        return f"No record of less than {LONGEST_YEARS} years would halve the interval of {symbol}."
    total = samples / rate_hz
    return (
        f"To halve the interval of {symbol} record {duration(total - duration_s)} more "
        f"({duration(total)} in all)."
    )
