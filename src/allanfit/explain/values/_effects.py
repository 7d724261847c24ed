"""Effects that values and their times tell by themselves, without a spectrum."""

from collections.abc import Sequence

import numpy as np

from ...physics import held_factor
from ...recording._checks import usable
from .._effect import Effect
from .._intervals import runs
from .._state import Finding, Investigation
from ..spectrum._structure import FILTERS, SHAPE, sieve
from ._losses import Lost

#: What is certain from the values alone is still only as certain as this, and a line.
SURE, LINE = 0.99, 0.97
# Of so few narrow bands losses are the cause: the log of how many to one.
_SELDOM = 3.0
# A strength that varies is told at so many times.
_KNOTS = 257


def seconds(state: Investigation, pairs: Sequence[tuple[int, int]], dt: float) -> list[list[float]]:
    """Intervals of values in seconds since the recording began."""
    return [[state.moment(a) * dt, state.moment(b) * dt] for a, b in pairs]


def probabilities(finding: Finding | None, name: str) -> tuple[float, dict[str, float]]:
    """Of the effect and of its rivals, from their scores (twice the log of the odds)."""
    rivals = {} if finding is None else dict(finding.rivals)
    if name not in rivals:
        return SURE, {}
    top = max(rivals.values())
    weights = {rival: np.exp((score - top) / 2) for rival, score in rivals.items()}
    total = sum(weights.values())
    shares = {rival: float(weight / total) for rival, weight in weights.items()}
    own = min(shares.pop(name), SURE)
    # What has no name takes its share, but is no rival that a measurement could tell apart.
    shares.pop("bump", None)
    return own, {rival: share for rival, share in shares.items() if share > 0.005}


def _dropped(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    lost: Lost = finding.detail
    drawn = lost.draws(state.values.size, rng)
    line = "" if lost.frequency is None else f"{lost.frequency / dt:.5g} Hz"
    told = {"fraction": lost.fraction}
    chance = min(SURE, 1 / (1 + float(np.exp(_SELDOM - lost.gain))))
    return [Effect("dropped_samples", chance, {}, {"fraction": drawn}, note=line, told=told)]


def _rounded(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    chance = min(SURE, state.rate_rounded)
    return [Effect("output_rounding", chance, {}, {"lsb": np.full(2, state.format.width)})]


def _held(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    repeat = finding.detail
    values = repeat.samples + repeat.deviation * rng.standard_normal(2000)
    if state.stride == 1:
        return [Effect("sample_hold", SURE, {}, {"repeat": values}, held=_held_of_white(state))]
    told, held = {"repeat": values, "regular": np.ones(2)}, held_factor(repeat.samples, True)
    return [Effect("sample_hold", SURE, {}, told, note=f"{1 / dt:.5g} Hz", held=held)]


def _held_of_white(state: Investigation) -> float:
    """How many times as large N is at low frequency, the filter before it considered."""
    shaping, before = state.model.kinds.shaping, None
    if shaping in FILTERS:
        before = sieve(shaping, state.model.theta[SHAPE], state.data.samples)
    return held_factor(state.data.repeat, False, before)


def _clipped(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    rails = state.format.rails
    told = {"limit": float(np.max(np.abs(rails)))}
    # Not as far below zero as above it: each by itself.
    if len(rails) == 1 or abs(sum(rails)) > state.format.width + 1e-6 * told["limit"]:
        middle = float(np.median(usable(state.values, state.pieces)))
        told |= {"low" if rail < middle else "high": rail for rail in rails}
    return [Effect("saturation", SURE, {}, {name: np.full(2, at) for name, at in told.items()})]


def _spiky(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    drawn = finding.detail.draws
    values = {"fraction": drawn[:, 0], "amplitude": drawn[:, 1]}
    if finding.detail.law == "alike":
        values["alike"] = np.ones(2)
    return [Effect("outliers", LINE, {}, values)]


def _modulated(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    changing = finding.detail
    times = seconds(state, runs(state.flags(changing.loud)), dt)
    ratio, lists = changing.draws, {"intervals": times}
    if changing.strength is not None:
        at = np.unique(np.linspace(0, changing.strength.size - 1, _KNOTS).round().astype(int))
        moments = [state.moment(int(value)) * dt for value in state.looked_at[at]]
        ratio = changing.extremes
        lists |= {"times": moments, "strengths": [float(each) for each in changing.strength[at]]}
    return [Effect("variance_modulation", 0.95, {"disturbance": 0.03}, {"ratio": ratio}, lists)]


def _knocked(state: Investigation, finding: Finding, dt: float, rng) -> list[Effect]:
    times = seconds(state, state.knocks, dt)
    others = {"variance_modulation": 0.08}
    return [Effect("disturbance", 0.9, others, {}, {"intervals": times})]


#: Makes the effects of a finding, by its name.
MAKERS = {
    "output_rounding": _rounded,
    "sample_hold": _held,
    "saturation": _clipped,
    "outliers": _spiky,
    "variance_modulation": _modulated,
    "disturbance": _knocked,
    "dropped_samples": _dropped,
}
