"""Effects in words: what stands after "the five-term model leaves out", and what is not told."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from ..formatting import listed

# An effect that is not here goes by its own name, so that a new one needs no entry.
_WORDS = {
    "gauss_markov": "exponentially correlated noise (Gauss-Markov)",
    "sinusoid": "a sinusoid",
    "drifting_line": "a line of drifting frequency",
    "resonance": "a resonance",
    "low_pass": "a low-pass filter",
    "power_law": "power-law noise",
    "random_telegraph": "random telegraph noise",
    "temperature": "an effect of temperature",
    "warm_up": "a warm-up",
    "step": "steps of the mean",
    "outliers": "outliers",
    "output_rounding": "rounding of the output",
    "sample_hold": "repeated samples (sample and hold)",
    "dropped_samples": "dropped samples",
    "saturation": "saturation",
    "variance_modulation": "a changing noise level",
    "vibration_rectification": "vibration rectification",
    "disturbance": "disturbances",
    "bump": "a smooth bump, which has no name",
}


#: What has no name and is no bump, by the flag that says so.
UNNAMED_SHAPES = {"notch": "a notch", "echo": "an echo"}

# Names of effects in a legend that are names of people too.
_LABELS = {"gauss_markov": "Gauss-Markov"}


def label(name: str) -> str:
    """An effect's name in a legend: "drifting line 2" for the second `drifting_line`."""
    effect, space, number = name.partition(" ")
    return _LABELS.get(effect, effect.replace("_", " ")) + space + number


def words(name: str) -> str:
    """An effect's name as a phrase: "a sinusoid" for `sinusoid`."""
    return _WORDS.get(name, name.replace("_", " "))


def phrase(effect: Mapping[str, Any]) -> str:
    """An effect as a phrase, as its name says, but for those whose shape is no bump."""
    for flag, shape in UNNAMED_SHAPES.items():
        if flag in effect["parameters"]:
            return f"{shape}, which has no name"
    return words(effect["name"])


def counted(phrases: Sequence[str]) -> str:
    """Phrases as in a sentence, "a, b and c"; one that comes more than once with its number."""
    counts = Counter(phrases)
    return listed(
        f"{phrase} ({count} of them)" if count > 1 else phrase for phrase, count in counts.items()
    )


def capitalised(phrase: str) -> str:
    """A phrase as a heading; `str.capitalize` would make small letters of the names in it."""
    return phrase[:1].upper() + phrase[1:]


def idle_parameters(effect: Mapping[str, Any]) -> tuple[str, ...]:
    """Those that say nothing to a reader beside the others.

    A bump of no height is described in words alone, unless something is missing toward zero; and of
    an output that is clipped on one side, or unevenly, `low` and `high` say where.
    """
    shown = effect["parameters"]
    if effect["name"] == "bump" and shown.get("height", {}).get("value") == 0:
        return ("height",) if "high_pass" in shown else tuple(shown)
    if "echo" in shown:
        return ("width",)
    return ("limit",) if {"low", "high"} & set(shown) else ()
