"""Real recordings as backgrounds: what does the tool say more, once an effect is put in?

What is unknown of the real sensor stays in, so only differences count: a name that appears with
the effect and does not without it. Recordings are read from ../shared and stay there.
"""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np
from scipy.fft import dct

from ._catalogue import Concealed
from ._converter import DroppedSamples, Outliers, SampleHold
from ._device import SUB, Device, Surroundings, convert
from ._effect import Effect, at_strength
from ._key import open_key, seal, write_recording
from ._row import Figure, Row, share
from ._score import confusion, failures
from ._slow import Disturbance, Step, Temperature, WarmUp
from ._spectral import DriftingLine, GaussMarkov, RandomTelegraph, Resonance, Sinusoid
from ._strength import basis, best_five_terms, bins
from ._tables import markdown as markdown

SHARED = Path(__file__).parents[3] / "shared" / "recordings"
BACKGROUNDS = ("vn100", "xsens_dot_10_units", "memsense_11_power_cycles", "xsens_mtig_outliers")
# Those that add to a recording or drop from it: nothing that needs the sensor's inside.
KINDS: tuple[type[Effect], ...] = (
    GaussMarkov,
    Sinusoid,
    DriftingLine,
    Resonance,
    RandomTelegraph,
    Temperature,
    WarmUp,
    Step,
    Outliers,
    SampleHold,
    DroppedSamples,
    Disturbance,
)
STRENGTHS = (100.0, 400.0)


def backgrounds() -> list[tuple[str, np.ndarray, float, str]]:
    """Name, samples, rate and unit of the channels of motion."""
    found = []
    for name in BACKGROUNDS:
        file = SHARED / f"{name}.npz"
        if not file.exists():
            continue
        with np.load(file) as stored:
            rate, units = float(stored["rate_hz"]), json.loads(str(stored["units"]))
            for channel in stored.files:
                if channel.startswith(("gyro", "accel")):
                    x = stored[channel].astype(float)
                    found.append((f"{name}:{channel}", x, rate, units[channel]))
    return found


def as_device(name: str, x: np.ndarray, rate_hz: float, unit: str) -> Device:
    """The five terms closest to a recording's spectrum, so that strengths mean something."""
    blank = Device(name, unit, rate_hz, x.size, False, "", "white", {}, float(x.mean()))
    grid = bins(blank)
    power = dct(x - x.mean(), norm="ortho") ** 2 * 2 * blank.dt
    mean = np.add.reduceat(power[: grid.first[-1] + grid.count[-1]], grid.first) / grid.count
    design = basis(blank, grid.frequency)
    model = best_five_terms(design, mean, grid.count)
    squares = np.linalg.lstsq((design / model).T, np.ones_like(model), rcond=None)[0]
    coefficients = dict(zip("QNBK", np.sqrt(np.maximum(squares, 0)).tolist(), strict=True))
    # Sizes are bracketed about the white noise.
    coefficients["N"] = max(coefficients["N"], float(np.sqrt(mean.min() / 2)))
    return Device(name, unit, rate_hz, x.size, False, "", "white", coefficients, float(x.mean()))


def inject(device: Device, x: np.ndarray, effect: Effect, seed: tuple[int, ...]) -> dict:
    """A log of the recording with the effect in it; what is lost shortens it."""
    streams = iter(np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(8))
    x = x + convert(device, effect.signal(next(streams), device, np.zeros(x.size * SUB)))
    x = effect.converter(next(streams), device, effect.slow(next(streams), device, x))
    x = x[effect.hold(next(streams), device, np.arange(x.size))]
    kept = effect.keep(next(streams), device, np.arange(x.size))
    log = {"data": x[kept].astype(np.float32)}
    if effect.lost(device):
        log["time_s"] = kept * device.dt
    temperature = effect.temperature(device)
    if isinstance(effect, Temperature) and effect.logged and temperature is not None:
        log["temperature"] = (25 + temperature).astype(np.float32)
    return log


def conceal(
    folder: Path, recordings: int, seed: int, workers: int, advance: Callable[[], object]
) -> str:
    """Half of the recordings as they are, half with an effect; returns the key's digest."""
    there = backgrounds()
    if not there:
        raise SystemExit(f"No recordings in {SHARED}: this tier needs them.")
    (folder / "recordings").mkdir(parents=True, exist_ok=True)
    if (folder / "seal.txt").exists():
        open_key(folder)
        for _ in range(recordings):
            advance()
        return (folder / "seal.txt").read_text().strip()
    rng = np.random.default_rng((seed, 3))
    chosen = rng.permutation(len(there))[: max(1, min(len(there), recordings // 2))]
    answers = []
    for index in range(recordings):
        name, x, rate_hz, unit = there[chosen[index % chosen.size]]
        device = as_device(name, x, rate_hz, unit)
        effects: tuple[Effect, ...] = ()
        if index >= chosen.size:
            effects = (_sized(KINDS[index % len(KINDS)], rng, device),)
        log = inject(device, x, effects[0] if effects else Effect(), (seed, 4, index))
        answer = Concealed(device, effects, Surroundings(), (seed, 4, index)).answer()
        file = f"{index:05d}"
        write_recording(folder / "recordings" / f"{file}.npz", log, rate_hz, unit)
        answers.append({"recording": file, "background": name, **answer})
        advance()
    return seal(folder, answers)


def _sized(kind, rng, device):
    for _ in range(100):
        effect = at_strength(kind.draw(rng, device), device, float(rng.choice(STRENGTHS)))
        if effect is not None:
            return effect
    raise RuntimeError(f"{device.profile} cannot show {kind.name}.")


def score(rows: list[Row]) -> dict:
    """What is said with the effect and not without it."""
    plain = {row.truth["background"]: row for row in rows if not row.effects}
    pairs = [row for row in rows if row.effects and row.truth["background"] in plain]

    def new(row):
        return set(row.named) - set(plain[row.truth["background"]].named)

    def right(row):
        return bool(new(row) & set(row.effects[0]["accepted"]))

    figures: list[Figure] = [
        share("an alarm on the recording as it is", plain.values(), lambda r: r.alarm),
        share("the effect put in is newly named", pairs, right),
        share("... and nothing else is", pairs, lambda r: right(r) and len(new(r)) == 1),
        share("an alarm with the effect", pairs, lambda r: r.alarm),
    ]
    return {
        "recordings": len(rows),
        "figures": [
            asdict(f) | {"share": f.share if f.total else None, "bar_95": f.bar, "met": f.met}
            for f in figures
        ],
        "numbers": [],
        "power": {},
        "confusion": confusion(rows),
        "failures": failures(pairs),
    }
