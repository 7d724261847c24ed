"""What the words of data sheets mean: which coefficient, and how its number is to be read.

Three readings of a number x, which differ by more than most sensors do:

- "coefficient": x is Q, N, B, K or R itself. So are random walks.
- "one_sided_density": x = sqrt(2) N. A noise density is the root of a one-sided power spectral
  density, the one with which rms noise is density times the root of bandwidth, and white noise of
  N has the one-sided density 2 N^2.
- "allan_minimum": x is the lowest point of the Allan deviation, at or above 0.664 B. This is what
  in-run bias stability means, and what data sheets call bias instability.
"""

import math
import re
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Literal, NamedTuple, get_args

from ..physics import ALLAN_FLOOR, STANDARD_TERMS

Meaning = Literal["coefficient", "one_sided_density", "allan_minimum"]
Bound = Literal["typical", "max"]

#: Allan deviation of flicker alone over B (IEEE Std 952, annex C, bias instability).
FLICKER_FLOOR = math.sqrt(ALLAN_FLOOR)

_BESIDE = re.compile(r"(.*\S) ?\((.*)\)")
_MEANINGS_OF: dict[str, tuple[Meaning, ...]] = {
    "N": ("coefficient", "one_sided_density"),
    "B": ("coefficient", "allan_minimum"),
}


class Sense(NamedTuple):
    """A coefficient, and how a number stands for it."""

    symbol: str
    meaning: Meaning


_SPOKEN: dict[Sense, tuple[str, ...]] = {
    Sense("Q", "coefficient"): ("quantization noise", "quantisation", "quantisation noise"),
    Sense("N", "coefficient"): ("angular random walk", "arw", "vrw"),
    Sense("N", "one_sided_density"): (
        "noise density",
        "rate noise density",
        "acceleration noise density",
        "output noise density",
        "noise spectral density",
        "rate noise spectral density",
        "spectral noise density",
        "power spectral density",
        "noise power spectral density",
    ),
    Sense("B", "allan_minimum"): (
        "bias instability",
        "in-run bias instability",
        "in-run bias stability",
        "bias stability",
    ),
    Sense("K", "coefficient"): ("rrw",),
    Sense("R", "coefficient"): ("drift rate ramp",),
}
# The symbols and our own names stand for the coefficient, but for bias instability.
SENSES: dict[str, Sense] = {
    **{
        word: Sense(term.symbol, "coefficient")
        for term in STANDARD_TERMS
        for word in (term.symbol.lower(), term.names.gyro, term.names.accelerometer)
    },
    **{word: sense for sense, words in _SPOKEN.items() for word in words},
}


def sense_of(words: str) -> Sense | None:
    """What the words of a line mean; None where they are not known.

    An abbreviation may stand beside the words: angle random walk (ARW).
    """
    plain = _plain(words)
    beside = _BESIDE.fullmatch(plain)
    if beside is None:
        return SENSES.get(plain)
    meant = SENSES.get(beside[1])
    # Any other remark may change the meaning, as `over temperature` does.
    return meant if meant is not None and SENSES.get(beside[2]) == meant else None


def nearest(words: str) -> tuple[str, float]:
    """The known words that are most like these, and how much, 0 to 1."""
    alike = {
        known: SequenceMatcher(None, _plain(words), known).ratio()
        for known in SENSES
        if len(known) > 1
    }
    best = max(alike, key=lambda known: alike[known])
    return best, alike[best]


def _plain(words: str) -> str:
    return " ".join(words.lower().replace("in run", "in-run").split())


def meanings_of(symbol: str) -> tuple[Meaning, ...]:
    """The readings that a number for this coefficient may have."""
    return _MEANINGS_OF.get(symbol, get_args(Meaning)[:1])


@dataclass(frozen=True)
class Line:
    """One number of a data sheet."""

    section: str
    """`gyro`, `accelerometer`, or a channel's name."""
    words: str
    """What the data sheet calls it."""
    symbol: str
    meaning: Meaning
    kind: str
    """`gyro` or `accelerometer`, as the unit tells."""
    bound: Bound
    number: float
    unit: str
    factor: float
    """One `unit` in SI."""

    @property
    def indirectness(self) -> tuple[bool, bool]:
        """Rises with how far the number is from a typical value of the coefficient itself."""
        return self.meaning != "coefficient", self.bound != "typical"

    @property
    def coefficient(self) -> float:
        """The coefficient that the line allows [SI]; of a minimum, all of it taken as flicker."""
        share = {"coefficient": 1.0, "one_sided_density": math.sqrt(2)}
        return self.number * self.factor / share.get(self.meaning, FLICKER_FLOOR)
