"""Every effect, and the sealed set that is drawn from them."""

from dataclasses import asdict, dataclass
from itertools import combinations

import numpy as np

from ._converter import DroppedSamples, Outliers, OutputRounding, SampleHold, Saturation
from ._device import Device, Surroundings, draw_device
from ._effect import Effect, at_strength, truth
from ._outside import BandOfNoise, Chirp, Cyclostationary, ModulatedLine, Notch, WanderingCorner
from ._slow import (
    Disturbance,
    Step,
    Temperature,
    VarianceModulation,
    VibrationRectification,
    WarmUp,
)
from ._spectral import (
    DriftingLine,
    GaussMarkov,
    LowPass,
    PowerLaw,
    RandomTelegraph,
    Resonance,
    Sinusoid,
)

INSIDE: tuple[type[Effect], ...] = (
    GaussMarkov,
    Sinusoid,
    DriftingLine,
    Resonance,
    LowPass,
    PowerLaw,
    RandomTelegraph,
    Temperature,
    WarmUp,
    Step,
    Outliers,
    OutputRounding,
    SampleHold,
    DroppedSamples,
    Saturation,
    VarianceModulation,
    VibrationRectification,
    Disturbance,
)
OUTSIDE: tuple[type[Effect], ...] = (
    Chirp,
    ModulatedLine,
    Cyclostationary,
    Notch,
    BandOfNoise,
    WanderingCorner,
)
# What would hide one another's truth: two alike, or one that remakes the other's values.
APART = [
    {GaussMarkov, RandomTelegraph, PowerLaw, Temperature},
    {WarmUp, Temperature, Step},
    {LowPass, SampleHold, OutputRounding, Saturation},
    {VarianceModulation, VibrationRectification, Step, Outliers, Disturbance},
    {Outliers, Saturation, OutputRounding},
    {DroppedSamples, Sinusoid},  # Each loss turns the phase.
    {DroppedSamples, DriftingLine},
]
PAIRS = [pair for pair in combinations(INSIDE, 2) if not any(set(pair) <= group for group in APART)]
NOTHING, TWO, BEYOND = 0.42, 0.10, 0.05
"""Shares of recordings with nothing hidden, two effects, and one outside the catalogue."""
STRONG = 50
"""Least strength of each of two."""


@dataclass(frozen=True)
class Concealed:
    """One recording of the set."""

    device: Device
    effects: tuple[Effect, ...]
    surroundings: Surroundings
    seed: tuple[int, ...]

    def answer(self) -> dict:
        """Its entry in the key."""
        coefficients = {s: self.device.term(s) for s in "QNBKR"}
        for effect in self.effects:
            coefficients |= effect.coefficients(self.device)
        return {
            "device": asdict(self.device),
            "duration_s": self.device.duration,
            "surroundings": asdict(self.surroundings),
            "seed": list(self.seed),
            "effects": [truth(effect, self.device) for effect in self.effects],
            "coefficients": coefficients,
            "inexact": sorted({s for effect in self.effects for s in effect.inexact}),
        }


def plans(seed: int, recordings: int) -> list[tuple[type[Effect], ...]]:
    """The kinds of effect in each recording, in shuffled order, each kind equally often."""
    rng = np.random.default_rng((seed, 0))
    counts = [round(share * recordings) for share in (NOTHING, TWO, BEYOND)]
    pairs = [PAIRS[i] for i in rng.permutation(len(PAIRS))]
    every: list[tuple[type[Effect], ...]] = [()] * counts[0]
    every += [pairs[i % len(pairs)] for i in range(counts[1])]
    every += [(OUTSIDE[i % len(OUTSIDE)],) for i in range(counts[2])]
    every += [(INSIDE[i % len(INSIDE)],) for i in range(recordings - len(every))]
    return [every[i] for i in rng.permutation(recordings)]


def draw(kinds: tuple[type[Effect], ...], seed: tuple[int, ...]) -> Concealed:
    """A device with effects of these kinds; devices that cannot show one are drawn again."""
    rng = np.random.default_rng(seed)
    for _ in range(200):
        device = draw_device(rng)
        effects = [_sized(kind, rng, device, len(kinds) > 1) for kind in kinds]
        if all(effect is not None for effect in effects):
            break
    else:
        raise RuntimeError(f"No device shows {[kind.name for kind in kinds]}.")
    causes = [effect for effect in effects if isinstance(effect, Temperature)]
    stamps = DroppedSamples in kinds or rng.random() < 0.15
    rounded = OutputRounding in kinds or device.angle == "rounded" or rng.random() < 0.75
    surroundings = Surroundings(
        temperature=causes[0].logged if causes else bool(rng.random() < 0.3),
        stamps=stamps,
        jitter=float(rng.uniform(0, 0.02)) if stamps else 0.0,
        code_width=0.0 if rounded else float(rng.uniform(0.005, 0.02)),
    )
    return Concealed(device, tuple(e for e in effects if e is not None), surroundings, seed)


def _sized(kind, rng, device, in_company):
    levels = [level for level in kind.levels if not in_company or level >= STRONG]
    asked = float(rng.choice(levels))
    for _ in range(5):
        effect = at_strength(kind.draw(rng, device), device, asked)
        if effect is not None:
            return effect
    return None
