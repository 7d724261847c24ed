"""allanfit and other tools side by side, on the same records, in one run.

    python -m benchmarks.peers             # 60 records; the bootstrap of ntpstats takes most of it
    python -m benchmarks.peers --quick     # 6 records, without that bootstrap

Other tools come from benchmarks/requirements-peers.txt; one that is not installed is said to be
so. First every tool must read known coefficients right. Writes one JSON file a tool and block of
records, so that an interrupted run goes on where it stopped, and prints the tables.
"""

import argparse
import json
import os
import platform
import sys
import time
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path

import jax
import numpy as np

from allanfit.whole_file import replacing

from . import _peer_checks
from ._peer_tools import SYMBOLS, Tool, tools
from .generators import record
from .truth import bound

RATE_HZ = 100.0
SAMPLES = 360_000
COEFFICIENTS = {"N": 5e-3, "B": 1e-3, "K": 1e-4}
_TERMS = [SYMBOLS.index(symbol) for symbol in COEFFICIENTS]
_TRUTH = np.array(list(COEFFICIENTS.values()))
_CASE = f"{SAMPLES}-at-{RATE_HZ:g}-Hz-" + "-".join(f"{s}{v:g}" for s, v in COEFFICIENTS.items())
_BLOCK = 10
_QUOTED = (
    "| simts 0.2.4 (GMWM), quoted | ×1.01 | absent | ×3.24 | | .82, –, .40 | | 3.5 | |",
    "| the same without intervals, quoted | ×1.01 | absent | ×3.24 | | | | 0.6 | |",
)


@dataclass(frozen=True)
class Block:
    """What one tool found in records `first` to `stop`; `values` and `intervals` by row."""

    first: int
    stop: int
    first_call_s: float
    seconds: float
    values: dict[str, list]
    intervals: dict[str, list | None]


def simulated(first: int, stop: int) -> np.ndarray:
    """The records that every tool gets, shape (stop - first, SAMPLES)."""
    return np.stack(
        [
            record(np.random.default_rng((13, i)), SAMPLES, 1 / RATE_HZ, COEFFICIENTS)
            for i in range(first, stop)
        ]
    )


def measure(tool: Tool, data: np.ndarray, first: int, first_call_s: float | None) -> Block:
    """Run a tool; its first call in this process is timed apart, as it may compile."""
    if first_call_s is None:
        start = time.perf_counter()
        tool.read(data if tool.batched else data[:1], RATE_HZ)
        first_call_s = time.perf_counter() - start
    start = time.perf_counter()
    readings = dict(zip(tool.rows, tool.read(data, RATE_HZ), strict=True))
    seconds = (time.perf_counter() - start) / len(data)
    return Block(
        first, first + len(data), first_call_s, seconds,
        {row: _listed(reading.value) for row, reading in readings.items()},
        {
            row: None if reading.interval is None else _listed(reading.interval)
            for row, reading in readings.items()
        },
    )  # fmt: skip


def study(chosen: list[Tool], records: int, folder: Path) -> dict[str, list[Block]]:
    """The blocks of each tool, from its files where they are."""
    found: dict[str, list[Block]] = {tool.name: [] for tool in chosen}
    first_calls: dict[str, float] = {}
    for first in range(0, records, _BLOCK):
        stop = min(first + _BLOCK, records)
        files = {t: folder / f"{t.name}-{t.fingerprint}-{first}-{stop}.json" for t in chosen}
        data = None
        for tool, file in files.items():
            if not file.exists():
                data = simulated(first, stop) if data is None else data
                block = measure(tool, data, first, first_calls.get(tool.name))
                first_calls[tool.name] = block.first_call_s
                with replacing(file) as part:
                    part.write_text(json.dumps(asdict(block)))
            found[tool.name].append(Block(**json.loads(file.read_text())))
            progress = f"{stop} of {records} records, {found[tool.name][-1].seconds:.2f} s each"
            print(f"{tool.name}: {progress}", file=sys.stderr)
    return found


def row(label: str, blocks: list[Block], bounds: np.ndarray) -> str:
    """One line of the table."""
    value = np.concatenate([np.array(b.values[label], dtype=float) for b in blocks])[:, _TERMS]
    cells = [_error(v, truth, b) for v, truth, b in zip(value.T, _TRUTH, bounds, strict=True)]
    cells.append(_triple(np.mean((value == 0) | np.isnan(value), axis=0)))
    if all(b.intervals[label] is not None for b in blocks):
        limits = np.concatenate([np.array(b.intervals[label], dtype=float) for b in blocks])
        low, high = np.moveaxis(limits[:, _TERMS], -1, 0)
        cells.append(_triple(np.mean((low <= _TRUTH) & (high >= _TRUTH), axis=0)))
        cells.append(_triple(np.mean(low == 0, axis=0)))
    else:
        cells += ["none", ""]
    cells.append(f"{np.median([b.seconds for b in blocks]):.3f}")
    cells.append(f"{max(b.first_call_s for b in blocks):.1f}")
    return f"| {label} | {' | '.join(cells)} |"


def table(offered: tuple[Tool, ...], found: dict[str, list[Block]], bounds: np.ndarray) -> str:
    """Markdown; one line an estimate."""
    head = (
        "tool", *(f"{s}: error (×bound)" for s in COEFFICIENTS), "zero or missing, N, B, K",
        "95 % intervals hold, N, B, K", "interval starts at 0", "s a record", "first call, s",
    )  # fmt: skip
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    lines.append(f"| Cramér-Rao bound | {' | '.join(f'{b:.4f}' for b in bounds)} | | | | | |")
    for tool in offered:
        for label in tool.rows:
            if tool.installed:
                lines.append(row(label, found[tool.name], bounds))
            else:
                lines.append(f"| {label} | not installed |" + " |" * (len(head) - 2))
    return "\n".join([*lines, *_QUOTED])


def check(chosen: list[Tool], folder: Path) -> dict[str, dict[str, float]]:
    """Read over true of known coefficients; raises ValueError where a factor is wrong."""
    found = {}
    for tool in chosen:
        file = folder / f"check-{tool.name}-{tool.fingerprint}.json"
        if not file.exists():
            ratios = _peer_checks.ratios(tool)
            with replacing(file) as part:
                part.write_text(json.dumps(ratios))
        found[tool.name] = json.loads(file.read_text())
        print(f"{tool.name}: checked on known coefficients", file=sys.stderr)
        if terms := _peer_checks.wrong(tool, found[tool.name]):
            raise ValueError(
                f"{tool.name} reads {', '.join(terms)} wrong: {found[tool.name]}; "
                "correct its conversion in benchmarks/_peer_tools.py before comparing"
            )
    return found


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="6 records, no bootstrap")
    parser.add_argument("--records", type=_positive)
    parser.add_argument(
        "--resamples", type=partial(_positive, least=0),
        help="of ntpstats' bootstrap; 0 leaves it out; by default 40, of --quick 0",
    )  # fmt: skip
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/peers"))
    options = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    records = options.records or (6 if options.quick else 60)
    resamples = options.resamples
    offered = tools((0 if options.quick else 40) if resamples is None else resamples)
    chosen = [tool for tool in offered if tool.installed]
    folder = options.output / _CASE
    folder.mkdir(parents=True, exist_ok=True)
    # Bootstrap intervals come with the same coefficients, and are no shorter to check.
    checked = check([t for t in chosen if "bootstrap" not in t.name], folder)
    found = study(chosen, records, folder)
    bounds = np.array(list(bound(SAMPLES, RATE_HZ, COEFFICIENTS, "point").values()))
    print(f"\n{_preface(chosen, records)}\n\n{table(offered, found, bounds)}\n\n{_NOTES}\n")
    print(_peer_checks.table(checked))


_NOTES = """\
Error: relative root mean square, over the records in which a coefficient is given; one that is
exactly 0 counts as an error of 1. A posterior median is never 0; where its interval starts at 0
the term is reported as an upper limit. allanfit works on blocks of ten records, the others on one
record at a time; the first call holds what is compiled or cached, for allanfit that of a block.
ntpstats is given the power laws of Q, N, B and K and a drift; slopes are read at 12 times a decade.
Quoted: measured elsewhere on 10 min at 100 Hz with Q 1e-4, N 1e-3, K 2e-4 and no flicker, as
error over that case's bound; 4 % of fits ended in a wrong optimum, 65,536 samples failed."""


def _preface(chosen: list[Tool], records: int) -> str:
    versions = {t.distribution: t.installed for t in chosen} | {
        name: version(name) for name in ("jax", "numpy", "scipy")
    }
    plural = "record" if records == 1 else "records"
    return (
        f"{records} {plural} of {SAMPLES / RATE_HZ / 3600:g} h at {RATE_HZ:g} Hz, "
        f"{', '.join(f'{s} {v:g}' for s, v in COEFFICIENTS.items())}; the standard error of an "
        f"error is about {(2 * records) ** -0.5:.0%} of it. {platform.machine()}, "
        f"{os.cpu_count()} cores, Python {platform.python_version()}, "
        f"{', '.join(f'{name} {v}' for name, v in versions.items())}."
    )


def _error(values: np.ndarray, truth: float, least: float) -> str:
    given = values[~np.isnan(values)]
    if not len(given):
        return "missing"
    error = np.sqrt(np.mean((given / truth - 1) ** 2))
    return f"{error:.4f} (×{error / least:.2f})"


def _listed(values: np.ndarray) -> list:
    """Lists for JSON, which has no NaN."""
    plain = values.astype(object)
    plain[~np.isfinite(values)] = None
    return plain.tolist()


def _triple(fractions: np.ndarray) -> str:
    return ", ".join(f"{f:.2f}" for f in fractions)


def _positive(text: str, least: int = 1) -> int:
    number = int(text)
    if number < least:
        raise argparse.ArgumentTypeError(f"needs a whole number of at least {least}; got {text}")
    return number


if __name__ == "__main__":
    main()
