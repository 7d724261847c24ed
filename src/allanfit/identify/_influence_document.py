"""What drives each coefficient as plain data, and as sentences where a stretch stands out."""

from typing import Any

import numpy as np

from ..physics import STANDARD_TERMS, SYMBOLS, coefficient_unit
from ._fit import Fit
from ._influence import EXPONENTS, Influence, change

# Relative change of a coefficient that is worth a sentence.
_MATTERS = 0.05


def influence_document(found: Influence, fit: Fit) -> dict[str, Any]:
    """The `influence` of the fit JSON: shares of the resolved terms, their sum being one."""
    rows = _resolved_rows(fit)
    return {
        "time_s": np.asarray(found.time_s, float).tolist(),
        "share": _by_symbol(found.share, rows),
        "expected": _by_symbol(found.expected, rows),
        "stands_out": _by_symbol(found.stands_out, rows),
    }


def influence_findings(found: Influence, fit: Fit, unit: str, factor: float) -> list[str]:
    """One sentence a term: the stretch that stands out and moves the coefficient the furthest.

    A stretch that stands out is passed over where the coefficient without it stays within its
    68 % interval or changes by less than a twentieth: nobody would do anything about it.
    """
    rows = _resolved_rows(fit)
    sentences = (_sentence(found, fit, row, unit, factor) for row in rows.values())
    return [sentence for sentence in sentences if sentence]


def _sentence(found: Influence, fit: Fit, row: int, unit: str, factor: float) -> str:
    term = STANDARD_TERMS[row]
    value = float(fit.coefficients[term.symbol]) / factor
    low, high = np.asarray(fit.interval(0.68)[term.symbol], float) / factor
    candidates = []
    for first, stop in _runs(np.asarray(found.stands_out)[row]):
        share = float(np.sum(found.share[row, first:stop]))
        expected = float(np.sum(found.expected[row, first:stop]))
        without = value * float(change(share, expected, EXPONENTS[row]))
        if not low <= without <= high and abs(without / value - 1) > _MATTERS:
            candidates.append((abs(without - value), first, stop, share, expected, without))
    if not candidates:
        return ""
    _, first, stop, share, expected, without = max(candidates)
    span = _span(float(found.time_s[first]), float(found.time_s[stop]))
    others = f" There are {len(candidates)} such stretches." if len(candidates) > 1 else ""
    return (
        f"{span} {_contribution(share, term.symbol)} ({_percent(expected)} expected): without them "
        f"{term.symbol} would be about {_number(without, coefficient_unit(term, unit))} "
        f"(predicted), not {value:.3g}.{others}"
    )


def _contribution(share: float, symbol: str) -> str:
    if share < 0:
        return f"draw {symbol} down"
    return f"supply {'all' if share > 0.995 else _percent(share)} of {symbol}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"


def _span(start: float, stop: float) -> str:
    """`Minutes 41 to 43`, or seconds or hours, whichever makes numbers easy to say."""
    units = ((3600.0, "Hours"), (60.0, "Minutes"), (1.0, "Seconds"))
    size, name = next((unit for unit in units if stop >= 10 * unit[0]), units[-1])
    first, last = (f"{time / size:.1f}".removesuffix(".0") for time in (start, stop))
    return f"{name} {first} to {last}"


def _number(value: float, unit: str) -> str:
    return f"{value:.3g} {unit}".rstrip()


def _runs(marked: np.ndarray) -> list[tuple[int, int]]:
    """First and one past the last of each run of marked pieces."""
    steps = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(int), [0]])))
    return list(zip(steps[::2].tolist(), steps[1::2].tolist(), strict=True))


def _resolved_rows(fit: Fit) -> dict[str, int]:
    # A coefficient of exactly zero in the least squares has no shares, whatever the posterior says.
    shown = np.asarray(fit.estimate.resolved) & (np.asarray(fit.estimate.least_squares) != 0)
    return {symbol: row for row, symbol in enumerate(SYMBOLS) if shown[row]}


def _by_symbol(values: Any, rows: dict[str, int]) -> dict[str, list[Any]]:
    return {symbol: np.asarray(values)[row].tolist() for symbol, row in rows.items()}
