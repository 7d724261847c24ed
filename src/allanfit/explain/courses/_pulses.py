"""Processes that are neither normal nor switch between two levels: pulses, told as such."""

import numpy as np
from scipy.stats import kstest

from .._state import Investigation, Unknown
from ..spectrum._structure import EACH, shape_of
from ._switches import jumps_one_way, visits_of
from ._visits import Visits

# Of pulses at any time, times are as uneven as seldom as this; else the noise changes its strength.
_UNEVEN = 1e-3


def tell_pulses(state: Investigation, seed: int) -> bool:
    """Take the names of pulses from the model's processes, and say what they are; whether any is.

    A process that jumps one way and comes back neither wanders nor switches; nor does one whose
    two levels are no two levels.
    """
    found = pulses(state, seed)
    for place, unknown in found.items():
        state.disowned_noises.add(place)
        state.unknown.append(unknown)
    if found:
        # While they last they are louder than what is between them.
        state.disowned.add("variance_modulation")
    return bool(found)


def may_be_pulses(state: Investigation, seed: int) -> bool:
    """Whether a process of the model is pulses, or seems to switch and has too few to tell."""
    return any(unknown or unsure for unknown, unsure in _looked_at(state, seed).values())


def pulses(state: Investigation, seed: int) -> dict[int, Unknown]:
    """What is said of the model's processes that are pulses, by their place."""
    found = _looked_at(state, seed).items()
    return {place: unknown for place, (unknown, _) in found if unknown is not None}


def _looked_at(state: Investigation, seed: int) -> dict[int, tuple[Unknown | None, bool]]:
    """What is said of each process if it is pulses, and whether it has too few visits to tell."""
    kinds, found = state.model.kinds, {}
    for place, name in enumerate(kinds.added):
        if name != "gauss_markov":
            continue
        constant = _constant(state, place)
        corner = 1 / (2 * np.pi * constant)
        if jumps_one_way(state, kinds.first_slot + EACH * place, constant) < np.log(state.alarm):
            why = "the output jumps one way, again and again, and comes back by and by"
            like = "discharges, impacts, or something that heats up do so"
            found[place] = Unknown(corner, 1.0, why, like=like), False
            continue
        switches, visits = visits_of(state, place, constant, seed)
        found[place] = None, switches and visits is None
        if visits is None or visits.log_chance > np.log(state.alarm):
            continue
        if _at_any_time(visits, state):
            why = "pulses of differing heights come and go, where a telegraph has one height"
            like = "discharges, impacts, or several traps at once do so"
            first = state.longest[0]
            times = tuple((int(a) + first, int(b) + first) for a, b in visits.at)
            found[place] = Unknown(corner, 1.0, why, like=like, times=times), False
    return found


def _at_any_time(visits: Visits, state: Investigation) -> bool:
    """Whether the rarer level is visited in all parts of the longest stretch."""
    start, stop = state.longest
    return float(kstest(visits.at[:, 0] / (stop - start), "uniform").pvalue) > _UNEVEN


def _constant(state: Investigation, place: int) -> float:
    """The time constant of a process that the model adds, in values."""
    begin = state.model.kinds.first_slot + EACH * place
    three = state.model.theta[begin : begin + EACH]
    return float(shape_of("gauss_markov", three, state.data.samples)[0])
