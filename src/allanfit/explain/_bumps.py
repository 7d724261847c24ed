"""A bump, or what else has no name, in place of what was named in the spectrum or beside it."""

import numpy as np

from ._chance import INSIDE, log_chance, score
from ._state import Finding, Investigation
from .spectrum import _model, _search
from .spectrum._leakage import take_bump
from .spectrum._model import Model
from .spectrum._narrow import is_about, narrow_noises
from .spectrum._structure import ECHO, TERMS, UNNAMED, Kinds


def bump_instead(state: Investigation) -> None:
    """Whether a smooth bump describes the spectrum better than all that was named in it.

    Or a notch than the filter, with the noises that were found beside it.
    """
    kinds = state.model.kinds
    if not kinds.names or kinds.shaping in UNNAMED:
        return
    if state.disowned & set(kinds.names) or state.disowned_noises:
        return
    bares = [Model(Kinds(), state.model.theta[:TERMS], np.inf)]
    if kinds.filtering and kinds.added:
        bares.append(_model.without(state.model, 0))
    bares = _model.best([(each.kinds, each.theta) for each in bares], state.data)

    def worth(model: Model) -> float:
        """Over the five terms alone, as twice the log of odds."""
        usual = sum(
            _model.rarity(model, state.data, place)
            for place in range(len(model.kinds.added))
            if place not in state.wandering
        )
        costs = sum(score(name, 0.0) for name in model.kinds.names)
        return bares[0].deviance - model.deviance + costs + usual

    found = _search.bumps(bares[0], state.data)
    for bare in bares[1:]:
        beside = _search.bumps(bare, state.data)
        found += [bump for bump in beside if _model.is_narrow_notch(bump.model, state.data)]
    if not found:
        return
    bump = max(found, key=lambda each: worth(each.model))
    if bump.model.kinds == kinds:
        return
    outside = 0.0 if kinds.notches else INSIDE
    named, rival = worth(state.model), worth(bump.model) - outside
    instead = set(kinds.names) - set(bump.model.kinds.added)
    for finding in state.findings:
        if finding.name in instead and finding.rivals:
            own = finding.rivals.get(finding.name, 0.0)
            finding.rivals["bump"] = own + rival - named
    if rival > named:
        rivals = {kinds.names[0]: named, "bump": rival}
        state.findings = [f for f in state.findings if f.name not in instead]
        state.findings.append(Finding("bump", log_chance("bump", bump.gain), bump.gain, rivals))
        take_bump(state, bump)


def bump_for_filter(state: Investigation) -> None:
    """A bump in place of a filter that is none, if it says as much: N and Q would be others."""
    if "low_pass" not in state.disowned or not state.model.kinds.filtering:
        return
    bare = _model.without(state.model, 0)
    bare = _model.best([(bare.kinds, bare.theta)], state.data)[0]
    found = _search.bumps(bare, state.data)
    if not found or found[0].model.deviance > state.model.deviance:
        return
    state.findings = [each for each in state.findings if each.name != "low_pass"]
    if state.finding("bump") is None:
        gain = found[0].gain
        state.findings.append(Finding("bump", log_chance("bump", gain), gain))
    take_bump(state, found[0])


def bump_beside(state: Investigation) -> None:
    """What nothing of the catalogue explains, as a smooth bump."""
    if state.unexplained is not None or state.in_codes:
        # What codes make of what hides within one is theirs.
        return
    found = _search.bumps(state.model, state.data)
    if found and of_a_peak(state, found[0]):
        # That a peak has not quite its shape is no cause of its own.
        return
    if found and log_chance("bump", found[0].gain) < np.log(state.alarm):
        state.nearest = min(state.nearest, log_chance("bump", found[0].gain))
        take_bump(state, found[0])


def of_a_peak(state: Investigation, bump: _search.Candidate) -> bool:
    """Whether a bump is about a line or a resonance of the model."""
    if bump.model.kinds.shaping == ECHO:
        return False
    if bump.model.kinds.notches > state.model.kinds.notches:
        middle, _ = _model.notches(bump.model, state.data)[-1]
    else:
        middle, _ = _model.shaping_shape(bump.model, state.data)
    return is_about(middle, narrow_noises(state.model, float(state.data.samples)))
