"""Sentences about effects, as an engineer would say them."""

import re
from collections.abc import Callable
from typing import Any

from ..formatting import reading
from ._effect import Effect
from .lines._harmonics import Family
from .values._spikes import USUAL

Parameters = dict[str, dict[str, Any]]

# "..., and `allanfit explain` tells by how much".
_POINTER = re.compile(r"[,:] (?:and )?`allanfit explain` tells [^.]*")


def effect_sentence(effect: Effect, shown: Parameters) -> str:
    """What the recording holds, with numbers in the user's unit."""

    def told(name: str) -> str:
        return " ".join(part for part in (_number(shown[name]), _unit(shown[name])) if part)

    def per_cent(name: str) -> str:
        return f"{_number(shown[name], 100.0)} %"

    count = len(effect.lists.get("intervals", effect.lists.get("times", [])))
    sentences = {
        "gauss_markov": lambda: (
            f"Exponentially correlated noise of {told('sigma')} with a correlation time of "
            f"{told('correlation_time')}: the bias wanders and returns."
        ),
        "random_telegraph": lambda: (
            f"The output switches between two levels {told('amplitude')} apart and stays at each "
            f"for {told('dwell_time')} on average{_unequal(shown)}."
        ),
        "sinusoid": lambda: (
            f"A sinusoid of amplitude {told('amplitude')} at {told('frequency')}{effect.note}."
        ),
        "drifting_line": lambda: (
            f"A line of amplitude {told('amplitude')} whose frequency wanders by "
            f"{told('width')} about {told('frequency')}{effect.note}."
        ),
        "resonance": lambda: (
            f"A resonance of {told('sigma')} rms at {told('frequency')} with a quality factor of "
            f"{told('quality_factor')}{_hardly_swings(shown)}{effect.note}."
        ),
        "low_pass": lambda: (
            f"A low-pass filter at {told('cutoff_frequency')}"
            + (f", {effect.note}" if effect.note else f" of order {told('order')}")
            + _folding(shown["cutoff_frequency"], effect.band_hz)
            + ": noise above it is missing, and N, B and K are misread without it."
        ),
        "power_law": lambda: (
            f"Noise whose density falls as f^-{told('exponent')}, which is neither "
            "white, flicker nor random walk."
        ),
        "temperature": lambda: (
            _followed(shown, told, effect.note)
            if "sensitivity" in shown
            else f"A slow swing with a period of {told('time_scale')}, as temperature makes; "
            + (
                "the one that was recorded does not tell all of it."
                if effect.felt
                else "no temperature was recorded to tell. What a temperature does beside a swing "
                "looks like K, which is a limit."
            )
        ),
        "warm_up": lambda: (
            f"A warm-up of {told('amplitude')} that dies out with a time constant of "
            f"{told('time_constant')}."
        ),
        "step": lambda: (
            f"The mean jumps by {told('amplitude')} at {effect.lists['times'][0]:.6g} s."
            if count == 1
            else f"The mean jumps {count} times, {_direction(effect)}, by "
            f"{told('amplitude').lstrip('-')} on average."
        ),
        "outliers": lambda: (
            f"{per_cent('fraction')} of the samples have spikes of size "
            f"{told('amplitude')} added, "
            + ("all of them alike, " if "alike" in shown else "")
            + "which inflate N."
            if shown["fraction"]["value"] <= USUAL
            else "The noise has longer tails than normal noise, as if "
            f"{per_cent('fraction')} of the samples had noise of "
            f"{told('amplitude')} added; N is that of all of it."
        ),
        "output_rounding": lambda: (
            f"The output is rounded to steps of {told('lsb')}, which are not small beside the "
            "noise: rounding adds noise that is not the sensor's N, and may hide what is."
        ),
        "sample_hold": lambda: (
            f"Each fresh value is repeated, {told('repeat')} samples of it on average: the sensor "
            + (f"measures by a clock of its own, at {effect.note}, and " if effect.note else "")
            + "is read faster than it measures. N is that of the fresh values at the rate of the "
            "log; at low frequency, which is what a data sheet means and a filter that takes all "
            f"samples meets, N is {effect.held:.3g} times as large."
        ),
        "saturation": lambda: (
            "The output is clipped at "
            + " and at ".join(told(each) for each in ("low", "high") if each in shown)
            + (f"{told('limit')} to either side" if not {"low", "high"} & set(shown) else "")
            + ", which hides part of the noise."
        ),
        "variance_modulation": lambda: (
            f"The strength of the noise changes all the time, by a factor of {told('ratio')} "
            "between its extremes; N is that of the quiet times, on average."
            if "strengths" in effect.lists
            else f"The noise is {told('ratio')} times as strong in {count} "
            f"interval{'s' if count != 1 else ''} as in the rest; N is that of the quiet times."
        ),
        "vibration_rectification": lambda: (
            f"The mean shifts with the strength of the noise by {told('coefficient')}: vibration "
            "is rectified."
        ),
        "disturbance": lambda: (
            "The sensor was moved or knocked in "
            + ("one interval, which is" if count == 1 else f"{count} intervals, which are")
            + " left out of the better model."
        ),
        "dropped_samples": lambda: (
            f"{per_cent('fraction')} of the samples were lost on the way, "
            + (
                f"as the line at {effect.note} tells, whose phase jumps ahead each time by what it "
                "turns in a sample. No time stamp tells of them: log a counter of samples."
                if effect.note
                else "by the time stamps."
            )
        ),
        "bump": lambda: (
            f"The catalogue has no name for it: {effect.note}."
            if effect.note
            else "Nothing of the catalogue explains a "
            f"{'surplus' if _height(shown) > 0 else 'lack'} of power about {told('frequency')}; "
            "a smooth bump stands for it."
        ),
    }
    return sentences[effect.name]()


def _number(entry: dict[str, Any], factor: float = 1.0) -> str:
    """The value with the digits that its interval supports, as in a table beside it."""
    interval = [factor * end for end in entry["intervals"].get("0.95", ())]
    return reading(factor * entry["value"], interval, "").value


def _unit(entry: dict[str, Any]) -> str:
    return "" if entry["unit"] == "1" else entry["unit"]


def family_sentence(family: Family) -> str:
    """What lines that belong together say of their cause."""
    *most, last = (f"{frequency:.5g}" for frequency in family.lines)
    sentence = (
        f"The lines at {', '.join(most)} and {last} Hz are multiples of {family.fundamental:.5g} "
        "Hz: look for one cause that repeats as often, a motor, mains or a task of the logger."
    )
    if family.folded:
        where = ", ".join(f"{frequency:.5g}" for frequency in family.folded)
        sentence += f" Those beyond half the sampling rate fold to {where} Hz."
    return sentence


def _folding(cutoff: dict[str, Any], band: tuple[float, float] | None) -> str:
    """That a corner may lie beyond the Nyquist frequency, which ends the band of a filter."""
    interval = cutoff["intervals"].get("0.95", (0.0, 0.0))
    if band is None or interval[1] <= band[1]:
        return ""
    low, high = reading(cutoff["value"], interval, "").interval.strip("[]").split(", ")
    return (
        f", or any corner from {low} to {high} {cutoff['unit']} (of those beyond half the sampling "
        "rate only what folds is seen)"
    )


def _followed(shown: Parameters, told: Callable[[str], str], note: str) -> str:
    """How temperature moves the output."""
    if note:
        return (
            f"The output follows {note}, as that of a fibre gyro does; of temperature itself it "
            "follows nothing that is seen."
        )
    if "quadratic" not in shown:
        return f"The output follows temperature by {told('sensitivity')}."
    low, high = shown["sensitivity"]["intervals"]["0.95"]
    square = f"the square of its distance from its mean by {told('quadratic')}"
    if low < 0 < high:
        return f"The output follows not temperature but {square}."
    return f"The output follows temperature by {told('sensitivity')} at its mean, and {square}."


def _unequal(shown: Parameters) -> str:
    """How long each level is held, if not alike."""
    if "upper_share" not in shown:
        return ""
    share, dwell = (float(shown[name]["value"]) for name in ("upper_share", "dwell_time"))
    return f": {2 * share * dwell:.3g} s at the upper, {2 * (1 - share) * dwell:.3g} s at the lower"


def _hardly_swings(shown: Parameters) -> str:
    """What a resonance without a peak looks like."""
    if float(shown["quality_factor"]["value"]) ** 2 > 0.5:
        return ""
    return ", too low for a peak: white noise behind two lags in a row is the same"


def _direction(effect: Effect) -> str:
    """Which way several steps go."""
    heights = effect.lists["heights"]
    if all(height > 0 for height in heights):
        return "each time up"
    return "each time down" if all(height < 0 for height in heights) else "up or down"


def _height(shown: Parameters) -> float:
    return float(shown["height"]["value"]) if "height" in shown else 0.0


def without_pointer(finding: str) -> str:
    """A finding without what points a reader of a fit to an explanation: this is one."""
    return _POINTER.sub("", finding)
