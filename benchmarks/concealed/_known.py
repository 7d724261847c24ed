"""Real recordings of which something is known: is it said, and is nothing said of clean ones?

One channel a file, without its thermometer: what the makers and the readers of these recordings
found (../shared/recordings/INDEX.md) is the answer. Two are made worse: a clean gyro loses one
sample in two hundred, once with and once without the time stamps that would tell.
"""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ._key import open_key, seal, write_recording
from ._real import SHARED
from ._row import Row

LINE = ["sinusoid", "drifting_line", "resonance"]
SLOW = ["warm_up", "temperature"]
REPEATS = ["sample_hold", "output_rounding"]
# File, channel, what is known: each entry's one name will do. Nothing known: nothing to be said.
KNOWN = (
    *(("vn100", f"gyro_{axis}", []) for axis in "xyz"),
    ("vn100", "accel_x", [["sinusoid", "drifting_line"]]),
    *(("vn100", f"accel_{axis}", []) for axis in "yz"),
    ("xsens_mtig_outliers", "gyro_x", [["outliers"]]),
    *(("bmi270", f"accel_{axis}", [["sample_hold"]]) for axis in "xyz"),
    *(("mpu6050", f"gyro_{axis}", [LINE]) for axis in "xyz"),
    ("adis16405_a", "gyro_x", [["low_pass"]]),
    ("adis16405_a", "gyro_z", [["low_pass"], LINE]),
    ("adis16405_b", "gyro_z", [["low_pass"], LINE]),
    ("adis16405_a", "accel_x", [["output_rounding"], LINE]),
    ("gyro_warmup.csv", "", [SLOW, LINE]),
    *(("phone_gyro", f"gyro_{axis}", [REPEATS]) for axis in "xyz"),
    ("seismometer", "velocity", [LINE, ["low_pass"]]),
    ("xsens_tstick", "gyro_x", [["low_pass"]]),
    ("xsens_dot_10_units", "accel_z_01", [["low_pass"]]),
)
WARM_UP_RATE_HZ = 95.2
DELETED = 0.005


def conceal(
    folder: Path, recordings: int, seed: int, workers: int, advance: Callable[[], object]
) -> str:
    """One channel a file, and the key; returns its digest."""
    (folder / "recordings").mkdir(parents=True, exist_ok=True)
    if (folder / "seal.txt").exists():
        open_key(folder)
        return (folder / "seal.txt").read_text().strip()
    answers = []
    for name, channel, known in KNOWN:
        if (found := _channel(name, channel)) is not None:
            _add(folder, answers, f"{name}:{channel}", known, {"data": found[0]}, *found[1:])
            advance()
    if (found := _channel("vn100", "gyro_y")) is not None:
        x, rate_hz, unit = found
        rng = np.random.default_rng(seed)
        kept = np.flatnonzero(rng.random(x.size) >= DELETED)
        stamped = {"data": x[kept], "time_s": kept / rate_hz}
        _add(folder, answers, "deleted, stamps", [["dropped_samples"]], stamped, rate_hz, unit)
        # Nobody can see it: a gyro's noise closed up is a gyro's noise.
        _add(folder, answers, "deleted, no stamps", [], {"data": x[kept]}, rate_hz, unit)
    if not answers:
        raise SystemExit(f"No recordings in {SHARED}: this tier needs them.")
    return seal(folder, answers)


def _channel(name: str, channel: str) -> tuple[np.ndarray, float, str] | None:
    file = SHARED / (name if name.endswith(".csv") else f"{name}.npz")
    if not file.exists():
        return None
    if name.endswith(".csv"):
        table = np.genfromtxt(file, delimiter=",", skip_header=1)
        x = table if table.ndim == 1 else table[:, -1]
        return x[np.isfinite(x)], WARM_UP_RATE_HZ, "deg/s"
    with np.load(file) as stored:
        units = json.loads(str(stored["units"]))
        return stored[channel], float(stored["rate_hz"]), units[channel]


def _add(folder, answers, name, known, log, rate_hz, unit):
    file = f"{len(answers):05d}"
    write_recording(folder / "recordings" / f"{file}.npz", log, rate_hz, unit)
    answers.append({"recording": file, "background": name, "known": known})


def score(rows: list[Row]) -> dict:
    """By recording: what is known, what was said."""
    return {
        "recordings": len(rows),
        "rows": [
            {
                "recording": row.truth["background"],
                "known": [" or ".join(names) for names in row.truth["known"]],
                "verdict": row.verdict,
                "named": row.named,
                "agrees": agrees(row),
                "seconds": row.seconds,
            }
            for row in rows
        ],
    }


def agrees(row: Row) -> bool:
    known = row.truth["known"]
    if not known:
        return row.verdict == "consistent"
    return all(set(names) & set(row.named) for names in known)


def markdown(scores: dict) -> str:
    lines = ["| recording | known | verdict | named | agrees | s |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {row['recording']} | {', '.join(row['known']) or 'nothing'} | {row['verdict']} "
        f"| {', '.join(row['named'])} | {'yes' if row['agrees'] else '**no**'} "
        f"| {row['seconds']:.0f} |"
        for row in scores["rows"]
    ]
    return "\n".join(lines)
