"""Does explain find what is wrong with a simulation? Recordings beside simulations of them.

    python -m benchmarks.simulations [--pairs 140] [--seed 1] [--folder DIR]

Each pair is a device of `benchmarks.concealed` and what its engineer believes of it: the same; one
coefficient off by a factor; an effect of the catalogue that the simulation lacks, that only the
simulation has, that both have, or that both have in different sizes; a coefficient off and an
effect absent. A simulation is a recording of its own, or a file of coefficients where it has no
effect. A pair is right when `explain --simulation` blames the coefficients, or the effect, that are
off and no other, and says of physics that it is absent where it is absent. It goes on where it
stopped.
"""

import argparse
import json
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import jax
import numpy as np
from rich.progress import track

import allanfit
from allanfit.explain import explain_recording
from allanfit.whole_file import replacing

from .concealed._catalogue import INSIDE
from .concealed._converter import SampleHold
from .concealed._device import Device, Surroundings, draw_device, simulate
from .concealed._effect import Effect, at_strength
from .concealed._key import write_recording
from .concealed._slow import Temperature
from .concealed._strength import bins, five_terms

RESULTS = Path(__file__).parent / "results" / "simulations"
KINDS = ("same", "coefficient", "absent", "extra", "both", "coefficient, absent", "size")
# A strength at which nearly every effect is found, and one from which a coefficient is plainly off.
STRENGTH, PLAIN = 400.0, 400.0
# Effects of another size are as many times as strong in the simulation, and are of these.
STRONGER = 6.0
SIZED = ("gauss_markov", "power_law", "resonance", "sinusoid", "step", "warm_up", "low_pass")


@dataclass(frozen=True)
class Pair:
    """A device, the device that its engineer believes in, and the effects of either."""

    kind: str
    device: Device
    believed: Device
    wrong: str
    effect: Effect | None
    believed_effect: Effect | None
    has_recording: bool
    """Whether the simulation is a recording; coefficients else."""

    @property
    def effects(self) -> tuple[tuple[Effect, ...], tuple[Effect, ...]]:
        """Of the recording, and of the simulation."""
        one = (self.effect,) if self.effect else ()
        other = (self.believed_effect,) if self.believed_effect else ()
        return (() if self.kind == "extra" else one), other

    @property
    def absent_from(self) -> list[str]:
        if self.kind == "extra":
            return ["recording"]
        return ["simulation"] if "absent" in self.kind else []


def draw(seed: int, index: int) -> Pair:
    kind = KINDS[index % len(KINDS)]
    rng = np.random.default_rng((seed, 0, index))
    while True:
        device = draw_device(rng)
        wrong, believed = _mistaken(rng, device) if "coefficient" in kind else ("", device)
        effect = None if kind in ("same", "coefficient") else _effect(rng, device)
        other = effect if kind in ("extra", "both", "size") else None
        if kind == "size" and effect is not None:
            known = effect.name in SIZED
            other = at_strength(effect, device, STRONGER * STRENGTH) if known else None
            effect = effect if other is not None else None
        if believed is not None and (effect is None) == (kind in ("same", "coefficient")):
            if effect is not None and "absent" in kind:
                believed = _as_seen(believed, device, effect)
            drawn = other is not None or bool(rng.random() < 0.5)
            return Pair(kind, device, believed, wrong, effect, other, drawn)


def _mistaken(rng: np.random.Generator, device: Device) -> tuple[str, Device | None]:
    """The device with one coefficient off by so much that it is plain."""
    symbol = str(rng.choice([s for s, value in device.coefficients.items() if value and s != "R"]))
    factor = float(np.exp(rng.choice([-1, 1]) * rng.uniform(np.log(1.1), np.log(4))))
    off = {**device.coefficients, symbol: factor * device.coefficients[symbol]}
    believed = replace(device, coefficients=off)
    grid = bins(device)
    ratio = five_terms(device)(grid.frequency) / five_terms(believed)(grid.frequency)
    plain = np.sum(grid.count * (ratio - 1 - np.log(ratio))) > PLAIN
    return symbol, believed if plain else None


def _as_seen(believed: Device, device: Device, effect: Effect) -> Device:
    """Believed coefficients as those of the device show beside an effect: behind a filter, say."""
    seen = dict(believed.coefficients)
    for symbol, value in effect.coefficients(device).items():
        seen[symbol] *= value / device.term(symbol)
    if isinstance(effect, SampleHold):
        # At low frequency, as a data sheet has it.
        seen["N"] *= float(np.sqrt((1 + effect.chance) / (1 - effect.chance)))
    return replace(believed, coefficients=seen)


def _effect(rng: np.random.Generator, device: Device) -> Effect | None:
    kind = INSIDE[rng.integers(len(INSIDE))]
    return at_strength(kind.draw(rng, device), device, max(STRENGTH, min(kind.levels)))


def made(pair: Pair, folder: Path, seed: tuple[int, ...]) -> tuple[Path, Path]:
    """The files of recording and simulation."""
    files = folder / "recording.npz", folder / "simulation.npz"
    for which, (file, device, effects) in enumerate(
        zip(files, (pair.device, pair.believed), pair.effects, strict=True)
    ):
        stamped = any(effect.name == "dropped_samples" for effect in effects)
        logged = any(isinstance(each, Temperature) and each.logged for each in effects)
        around = Surroundings(temperature=logged, stamps=stamped)
        log = simulate(device, effects, around, (*seed, which))
        write_recording(file, log, device.rate_hz, device.unit)
    if pair.has_recording:
        return files
    lines = "".join(f"{s}: {value!r}\n" for s, value in pair.believed.coefficients.items())
    believed = folder / "believed.yaml"
    believed.write_text(lines)
    return files[0], believed


def judged(pair: Pair, entry: dict) -> dict:
    """What one channel's explanation says of the simulation, beside the truth."""
    causes = entry["mismatch"]
    blamed = {each["coefficient"] for each in causes if each["coefficient"]}
    absent = {each["absent_from"] for each in causes if each["absent_from"]}
    # The white noise of a sensor that is louder at times has no single value, and a filter that
    # only the simulation has changes it.
    free = set()
    if pair.effect:
        free = {*pair.effect.inexact}
        if pair.kind == "extra":
            free |= pair.effect.coefficients(pair.device).keys()
    return {
        "kind": pair.kind,
        "effect": pair.effect.name if pair.effect else None,
        "form": "recording" if pair.has_recording else "coefficients",
        "profile": pair.device.profile,
        "wrong": pair.wrong,
        "factor": pair.believed.term(pair.wrong) / pair.device.term(pair.wrong)
        if pair.wrong
        else 1.0,
        "verdict": entry["verdict"],
        "effects": [each["name"] for each in entry["effects"]],
        "said": [each["sentence"] for each in causes],
        "coefficients_right": blamed - free == {pair.wrong} - {""} - free
        if pair.kind != "size"
        else blamed - free == {pair.effect.name if pair.effect else ""},
        "physics_right": sorted(absent) == pair.absent_from,
        "blamed": sorted(blamed),
        "absent_from": sorted(absent),
    }


def table(rows: list[dict]) -> str:
    lines = ["| kind | pairs | coefficients right | physics right | both |", "|---" * 5 + "|"]
    for kind in (*KINDS, "all"):
        group = [row for row in rows if kind in (row["kind"], "all")]
        right = Counter(
            {
                "c": sum(row["coefficients_right"] for row in group),
                "p": sum(row["physics_right"] for row in group),
                "both": sum(row["coefficients_right"] and row["physics_right"] for row in group),
            }
        )
        lines.append(f"| {kind} | {len(group)} | {right['c']} | {right['p']} | {right['both']} |")
    return "\n".join(lines)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pairs", type=int, default=140)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=RESULTS)
    asked = parser.parse_args(arguments)
    jax.config.update("jax_enable_x64", True)
    rows = []
    for index in track(range(asked.pairs)):
        folder = asked.folder / f"{asked.seed}" / f"{index:04d}"
        result = folder / "result.json"
        if not result.exists():
            folder.mkdir(parents=True, exist_ok=True)
            pair = draw(asked.seed, index)
            recording, simulation = made(pair, folder, (asked.seed, 1, index))
            loaded = allanfit.load(recording)
            found = explain_recording(loaded, simulation=simulation, posterior=False)
            row = judged(pair, found.channels[0].to_dict())
            with replacing(result) as part:
                part.write_text(json.dumps(row))
            for file in (recording, simulation, folder / "simulation.npz"):
                file.unlink(missing_ok=True)
        rows.append(json.loads(result.read_text()))
    for row in rows:
        if not (row["coefficients_right"] and row["physics_right"]):
            print(json.dumps(row, indent=1))
    print(table(rows))


if __name__ == "__main__":
    main()
