"""What is known of one channel while it is investigated."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ..curves import even_ends
from ..physics import Sampling
from .courses import _course
from .courses._course import Course, Sized
from .courses._sums import Moved, Products, Summing
from .lines._lines import Peak
from .lines._tracked import Followed
from .spectrum import _model
from .spectrum._model import Model
from .spectrum._ordinates import (
    Ordinates,
    above_leakage,
    bin_edges,
    binned,
    ordinates,
)
from .spectrum._search import Candidate
from .spectrum._structure import (
    Data,
    Kinds,
)
from .spectrum._whiten import level, whitened
from .strength._modulation import Modulation
from .values._codes import UNROUNDED, Rounding
from .values._contamination import Contamination
from .values._format import Format, sample_format
from .values._held_out import Gain

# Samples of which a spectrum's lowest ordinates are a small part.
_LONG = 256


@dataclass
class Finding:
    """One effect that was named."""

    name: str
    #: Log of the chance of the evidence without the effect, and twice the log-likelihood gained.
    log_p: float
    gain: float
    #: Rivals by name: what each would have gained less what it costs, the effect itself included.
    rivals: dict[str, float] = field(default_factory=dict)
    #: What the document needs of effects that no structure or course holds.
    detail: Any = None


class Unknown(NamedTuple):
    """Something without a name: where, how large, and why what describes it best is not it."""

    #: The middle [cycles per sample] and the width in e-folds.
    frequency: float
    width: float
    why: str
    #: Its period [samples], if it has one.
    period: float = 0.0
    #: Whether it shows in time alone.
    in_time: bool = False
    #: Whether it belongs to no band.
    bandless: bool = False
    #: What makes such things.
    like: str = ""
    #: When, as `[start, stop)` in values, if not always.
    times: tuple[tuple[int, int], ...] = ()
    #: Where it is in the beginning and in the end [cycles per sample], if it moves there evenly.
    ends: tuple[float, float] | None = None


class Summed(NamedTuple):
    """Sums over bins of what some courses do, and for which structure and bins they were made."""

    kinds: Kinds
    edges: Float[np.ndarray, " edges"]
    spectrum: Ordinates
    sums: Summing
    moved: tuple[Moved, ...]
    products: Products


class Searched(NamedTuple):
    """What a search for smooth effects found."""

    #: The structure, and how many peaks were known, when it was made.
    of: tuple[Kinds, int]
    candidates: list[Candidate]


@dataclass
class Investigation:
    """The state of knowledge of one channel."""

    #: The samples of the log, or where a sensor has a clock of its own, its fresh values.
    values: Float[np.ndarray, " samples"]
    pieces: tuple[tuple[int, int], ...]
    sampling: Sampling
    #: Chance of a false alarm for each family of tests on this channel.
    alarm: float
    format: Format
    spectrum: Ordinates
    edges: Float[np.ndarray, " edges"]
    data: Data
    #: The five terms alone, and all that is known now.
    first: Model
    model: Model
    first_data: Data
    #: Samples before which time went by that no value stands for, of which nothing tells how much.
    breaks: tuple[int, ...]
    #: When each of `values` was taken, with all that were lost between them but for the breaks.
    place: Float[np.ndarray, " samples"]
    #: Whether what was lost between them is in the values after.
    bridged: bool = False
    courses: list[Course] = field(default_factory=list)
    #: The amplitudes of the ordinates of each course, and the last sums over bins of `summed`.
    moved: list[Moved] = field(default_factory=list)
    last_summed: Summed | None = None
    sized: Sized | None = None
    #: The ordinates less the courses, if there are any.
    left_over: Ordinates | None = None
    findings: list[Finding] = field(default_factory=list)
    peaks: list[Peak] = field(default_factory=list)
    #: The last search for smooth effects beside the model.
    searched: Searched | None = None
    contamination: Contamination | None = None
    #: Log of the chance that the noise leans to one side as much, if it has long tails.
    leans: float = 0.0
    modulation: Modulation | None = None
    #: What was filtered out of loud times, if that was not white.
    vibration: Any = None
    knocks: list[tuple[int, int]] = field(default_factory=list)
    #: Variance of white noise that does not belong to N: of spikes and loud times, of the latter
    #: alone, and of codes.
    foreign: float = 0.0
    loud_variance: float = 0.0
    #: The part of N's square that only loud times have, if it passes a filter as N does.
    loud_part: float = 0.0
    #: Draws of what part of that is known by its statistics alone [u^2], less what `foreign` has.
    unseen: Float[np.ndarray, " draws"] | None = None
    rounding: Rounding = UNROUNDED
    #: The probability that codes are those of the rate, and not of an angle.
    rate_rounded: float = 1.0
    witnesses: list[dict[str, Any]] = field(default_factory=list)
    #: What findings gain on samples that they were not fitted to, by name of the effect.
    gains: dict[str, Gain] = field(default_factory=dict)
    #: Log of the chance of the strongest evidence within its family of tests.
    nearest: float = 0.0
    unexplained: Candidate | None = None
    #: What has no name, and the names, the model's added noises by their place, and the lines
    #: [cycles per sample] that are not what they seem.
    unknown: list[Unknown] = field(default_factory=list)
    disowned: set[str] = field(default_factory=set)
    disowned_noises: set[int] = field(default_factory=set)
    disowned_lines: list[float] = field(default_factory=list)
    #: Which of the model's added noises are lines that wander, whatever their shape.
    wandering: set[int] = field(default_factory=set)
    #: Lines that were followed in time, by the place of the noise.
    followed: dict[int, Followed] = field(default_factory=dict)
    #: When a line was stronger than at other times, as `[start, stop)`, if it was.
    line_times: list[tuple[int, int]] = field(default_factory=list)
    #: Whether it switches between two levels, so that no step and no loud time is one of its own.
    switching: bool = False
    #: Samples of the log for each of `values`, and which of the log's they are if not all.
    stride: float = 1.0
    at: Int[np.ndarray, " samples"] | None = None

    @property
    def left(self) -> Ordinates:
        """The ordinates less the courses."""
        return self.spectrum if self.left_over is None else self.left_over

    @property
    def in_codes(self) -> bool:
        """Whether the noise hides within a code: what is seen of it is what codes make."""
        return self.rounding.hidden > 0

    def ordinates_of(self, *pieces: Float[np.ndarray, " _"]) -> Ordinates:
        """Those of stretches of values that were made as this channel's are."""
        return ordinates(pieces, self.sampling, self.format.angle)

    @property
    def longest(self) -> tuple[int, int]:
        """The longest stretch."""
        return max(self.pieces, key=lambda piece: piece[1] - piece[0])

    @property
    def looked_at(self) -> Int[np.ndarray, " looked_at"]:
        """The samples that are asked whether the noise lasts: of all but the shortest stretches."""
        return np.concatenate([np.arange(*piece) for piece in self.long_pieces])

    @property
    def long_pieces(self) -> list[tuple[int, int]]:
        """The stretches that say by themselves how strong their noise is, and the longest."""
        longest = self.longest
        return [p for p in self.pieces if p == longest or p[1] - p[0] >= _LONG]

    @property
    def deviation(self) -> Float[np.ndarray, " values"]:
        """Of the noise of each value, over that of the quiet times."""
        whole = np.ones(self.values.size)
        if self.modulation is not None:
            whole[self.looked_at] = self.modulation.deviation()
        return whole

    def count_unsure(self, variance: float, unsure: Float[np.ndarray, " draws"]) -> None:
        """White variance that does not belong to N, and draws of its error, which N has as well."""
        self.foreign += variance
        self.unseen = (
            unsure if self.unseen is None else unsure + np.resize(self.unseen, unsure.size)
        )

    def flags(self, looked_at: Bool[np.ndarray, " looked_at"]) -> Bool[np.ndarray, " samples"]:
        """What is true of samples that were looked at, of all samples."""
        whole = np.zeros(self.values.size, bool)
        whole[self.looked_at] = looked_at
        return whole

    @property
    def lines(self) -> list[Course]:
        """The courses that are sinusoids."""
        return [course for course in self.courses if course.name == "sinusoid"]

    @property
    def drawn(self) -> Float[np.ndarray, " samples"] | None:
        """What all courses add to each sample [u]; None without courses."""
        if self.sized is None:
            return None
        return np.column_stack([course.draw() for course in self.courses]) @ self.sized.sizes

    @property
    def calm(self) -> Float[np.ndarray, " samples"]:
        """The samples less all courses."""
        drawn = self.drawn
        return self.values if drawn is None else self.values - drawn

    @property
    def variance(self) -> Float[np.ndarray, " ordinates"]:
        """What the model expects of each ordinate [u^2]."""
        return _course.ordinate_variance(self.spectrum, self.model, self.data)

    def moment(self, index: int | float) -> float:
        """When a value was taken, with all that were lost, in intervals of the values."""
        if self.at is None:
            last = min(int(index), self.place.size - 1)
            return float(self.place[last] + index - last)
        return float(self.at[min(int(index), self.at.size - 1)]) / self.stride

    def findings_of(self, names: Sequence[str]) -> list[Finding | None]:
        """Of each of the model's effects, or of the courses: all are in the order they were found.

        Findings of effects that were taken back by a new beginning come before.
        """
        left = {name: [each for each in self.findings if each.name == name] for name in names}
        return [left[name].pop() if left[name] else None for name in reversed(names)][::-1]

    def finding(self, name: str) -> Finding | None:
        """The first finding of this name."""
        return next((each for each in self.findings if each.name == name), None)

    def witness(self, name: str, statistic: float, p_value: float, sentence: str) -> None:
        """Tell what a test gave, in place of what it gave before."""
        told = {"name": name, "statistic": statistic, "p_value": p_value, "sentence": sentence}
        self.witnesses = [each for each in self.witnesses if each["name"] != name] + [told]

    def name_once(self, finding: Finding) -> None:
        """Add a finding, in place of an older one of its name."""
        self.findings = [each for each in self.findings if each.name != finding.name]
        self.findings.append(finding)

    @property
    def cost(self) -> float:
        """Minus twice the log-likelihood of what is known now."""
        return _course.cost(self.model, self.data)


def begin(
    values: Float[np.ndarray, " samples"],
    pieces: tuple[tuple[int, int], ...],
    sampling: Sampling,
    power: Float[np.ndarray, " terms"],
    alarm: float,
) -> Investigation:
    """Nothing known but the five terms; the arguments are those of `investigate`."""
    found = sample_format(values, pieces)
    spectrum = ordinates(between_even_ends(values, pieces, power), sampling, found.angle)
    edges = bin_edges(spectrum.longest)
    spectrum = above_leakage(spectrum, binned(spectrum, edges))
    bins = binned(spectrum, edges)
    averaging = float(sampling == "averaged")
    data = Data(bins, float(spectrum.longest), 0.0, 1.0, np.ones(4, bool), averaging)
    first = _model.five_terms(power, data)
    return Investigation(
        values,
        pieces,
        sampling,
        alarm,
        found,
        spectrum,
        edges,
        data,
        first,
        first,
        data,
        tuple(b for (_, a), (b, _) in pairwise(pieces) if a == b),
        np.arange(values.size, dtype=float),
    )


def between_even_ends(
    values: Float[np.ndarray, " samples"],
    pieces: tuple[tuple[int, int], ...],
    power: Float[np.ndarray, " terms"],
) -> tuple[Float[np.ndarray, " _"], ...]:
    """The stretches as their spectrum is made of them, by Q and N, the first two of `power`."""
    error, white = np.sqrt(power[:2]).tolist()
    return tuple(even_ends(values[start:stop], error, white) for start, stop in pieces)


def whitened_pieces(
    state: Investigation, notches=(), *, model_only: bool = False
) -> Float[np.ndarray, " looked_at"]:
    """All that are `looked_at`, each stretch made white by itself."""
    return np.concatenate(
        [whitened_piece(state, p, notches, model_only=model_only) for p in state.long_pieces]
    )


def whitened_piece(
    state: Investigation,
    piece: tuple[int, int],
    notches=(),
    *,
    model_only: bool = False,
    share: float = 1.0,
) -> np.ndarray:
    """A stretch less the courses, made white; by the model alone, or by what is left of it too."""
    expected = state.variance if model_only else level(state.left, state.variance)
    return whitened(state.calm[piece[0] : piece[1]], state.left, expected, notches, share)
