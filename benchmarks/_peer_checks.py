"""Is each tool's coefficient read with the right factor? Every wrong one is off by 5 % or more."""

import numpy as np

from ._peer_tools import SYMBOLS, Tool
from .generators import record

TRUTH = {"Q": 3e-4, "N": 5e-3, "B": 1e-3, "K": 1e-4, "R": 1e-5}
_RATE_HZ = 100.0
_WHITE = "white record"
_CURVE_TOLERANCE = 2e-3
_RECORD_TOLERANCE = 0.04  # seven standard errors of the widest: N read at 1 s of 3 h of white noise


def textbook(symbol: str, tau: np.ndarray) -> np.ndarray:
    """Allan variance of one term (IEEE Std 952-1997, annex C)."""
    return {
        "Q": 3 * TRUTH["Q"] ** 2 / tau**2,
        "N": TRUTH["N"] ** 2 / tau,
        "B": 2 * np.log(2) / np.pi * TRUTH["B"] ** 2 * np.ones_like(tau),
        "K": TRUTH["K"] ** 2 * tau / 3,
        "R": TRUTH["R"] ** 2 * tau**2 / 2,
    }[symbol]


def ratios(tool: Tool) -> dict[str, float]:
    """Read over true, by term alone, and of the N of a long white record; of what is given.

    A tool that reads a curve gets the textbook's, without noise, from 64 samples up, where
    sampled data and textbook agree. The others get a record of each term.
    """
    if tool.from_curve:
        tau = np.exp2(np.arange(6, 15)) / _RATE_HZ
        alone = {
            symbol: tool.from_curve(tau, textbook(symbol, tau), _RATE_HZ)[i] / TRUTH[symbol]
            for i, symbol in enumerate(SYMBOLS)
        }
    else:
        alone = {symbol: _of_a_record(tool, symbol, 2**17) for symbol in SYMBOLS}
    given = {symbol: float(ratio) for symbol, ratio in alone.items() if np.isfinite(ratio)}
    return {**given, _WHITE: _of_a_record(tool, "N", 2**20)}


def wrong(tool: Tool, found: dict[str, float]) -> list[str]:
    """The terms that are off by more than noise explains, or missing; slopes give no Q and R."""
    tolerance = dict.fromkeys(SYMBOLS, _CURVE_TOLERANCE if tool.from_curve else _RECORD_TOLERANCE)
    tolerance[_WHITE] = _RECORD_TOLERANCE
    asked = {"N", "B", "K", _WHITE} | set(found)
    return sorted(t for t in asked if not abs(found.get(t, np.nan) - 1) <= tolerance[t])


def table(found: dict[str, dict[str, float]]) -> str:
    """Markdown; one line a tool."""
    terms = [*SYMBOLS, _WHITE]
    lines = [f"| read / true | {' | '.join(terms)} |", "|---" * (len(terms) + 1) + "|"]
    for name, row in found.items():
        cells = [f"{row[t]:.4f}" if t in row else "" for t in terms]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _of_a_record(tool: Tool, symbol: str, samples: int) -> float:
    coefficients = {symbol: TRUTH[symbol]}
    if symbol == "R":  # a ramp needs something to stand out from
        coefficients |= {"N": 1e-4}
    data = record(
        np.random.default_rng((17, *map(ord, symbol))), samples, 1 / _RATE_HZ, coefficients
    )
    reading, *_ = tool.read(data[None], _RATE_HZ)
    i = SYMBOLS.index(symbol)
    value = reading.value[0, i]
    if reading.interval is not None:
        low, high = reading.interval[0, i]
        if not low <= value <= high:
            raise ValueError(f"{tool.name}: {symbol} = {value} outside its interval {low}..{high}")
    return float(value / TRUTH[symbol])
