"""Are lines, lines that wander and resonances told apart? One of them in each recording.

    python -m benchmarks.narrow [--recordings 96] [--seed 1] [--folder DIR]

Devices and effects are those of `benchmarks.concealed`, with lambda from 36 to 400. Printed are how
often each is called what, and whether the probabilities told are true: of names told with .9 nine
in ten are right, and the mean log-probability of the truth is as near to zero as can be. It goes on
where it stopped.
"""

import argparse
import json
from itertools import pairwise
from pathlib import Path

import jax
import numpy as np
from rich.progress import track

import allanfit
from allanfit.explain import explain_recording
from allanfit.whole_file import replacing

from .concealed._device import Surroundings, draw_device, simulate
from .concealed._effect import at_strength
from .concealed._key import write_recording
from .concealed._outside import BandOfNoise
from .concealed._spectral import DriftingLine, Resonance, Sinusoid

RESULTS = Path(__file__).parent / "results" / "narrow"
KINDS = (DriftingLine, Resonance, DriftingLine, Resonance, Sinusoid, BandOfNoise)
NAMES = ("sinusoid", "drifting_line", "resonance", "bump", "other", "nothing")
WEAKEST, STRONGEST = 36.0, 400.0
# Probabilities are told in these ranges.
RANGES = (0.5, 0.7, 0.9, 0.97, 1.0)
# What is given to a truth that is not among the names told.
LEAST = 0.01


def explained(folder: Path, seed: int, index: int) -> dict:
    """Make one recording, explain it, and set what is said beside the truth."""
    rng = np.random.default_rng((seed, 0, index))
    size = np.exp(rng.uniform(np.log(WEAKEST), np.log(STRONGEST)))
    effect = None
    while effect is None:
        device = draw_device(rng)
        effect = at_strength(KINDS[index % len(KINDS)].draw(rng, device), device, size)
    log = simulate(device, [effect], Surroundings(), (seed, 1, index))
    file = folder / f"{index:04d}.npz"
    write_recording(file, log, device.rate_hz, device.unit)
    entry = explain_recording(allanfit.load(file), posterior=False).channels[0].to_dict()
    file.unlink()
    chances: dict[str, float] = {}
    for said in entry["effects"]:
        for each in (said, *said["alternatives"]):
            chances[each["name"]] = max(chances.get(each["name"], 0.0), each["probability"])
    return {
        "truth": effect.name,
        "lambda": float(size),
        "effect": {key: value for key, value in vars(effect).items() if np.isscalar(value)},
        "rate_hz": device.rate_hz,
        "samples": device.samples,
        "named": [said["name"] for said in entry["effects"]],
        "probabilities": [said["probability"] for said in entry["effects"]],
        "chances": chances,
    }


def table(rows: list[dict]) -> str:
    lines = ["| truth \\ called | " + " | ".join(NAMES) + " | of |", "|---" * 8 + "|"]
    for truth in dict.fromkeys(row["truth"] for row in rows):
        group = [row for row in rows if row["truth"] == truth]
        called = [set(row["named"]) or {"nothing"} for row in group]
        called = [names & set(NAMES) or {"other"} for names in called]
        counts = [sum(name in names for names in called) for name in NAMES]
        lines.append(f"| {truth} | " + " | ".join(map(str, counts)) + f" | {len(group)} |")
    inside = [row for row in rows if row["truth"] in NAMES and row["named"]]
    lines += ["", "| probability told | names | right |", "|---|---|---|"]
    told = [
        (chance, name == row["truth"])
        for row in inside
        for name, chance in zip(row["named"], row["probabilities"], strict=True)
    ]
    for low, high in pairwise(RANGES):
        right = [hit for chance, hit in told if low <= chance < high]
        share = f"{np.mean(right):.2f}" if right else ""
        lines.append(f"| {low} to {high} | {len(right)} | {share} |")
    given = [max(row["chances"].get(row["truth"], 0.0), LEAST) for row in inside]
    lines += ["", f"mean log-probability of the truth: {np.mean(np.log(given)):.3f}"]
    return "\n".join(lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--recordings", type=int, default=96)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=RESULTS)
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    folder = asked.folder / f"{asked.seed}"
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for index in track(range(asked.recordings)):
        result = folder / f"{index:04d}.json"
        if not result.exists():
            row = explained(folder, asked.seed, index)
            with replacing(result) as part:
                part.write_text(json.dumps(row))
        rows.append(json.loads(result.read_text()))
    for index, row in enumerate(rows):
        if row["truth"] not in row["named"] and row["truth"] in NAMES:
            print(index, json.dumps(row))
    print(table(rows))


if __name__ == "__main__":
    main()
