"""Samples that were held, rounded or clipped, and whether their codes are those of an angle."""

import numpy as np

from ...recording._checks import usable
from .._refit import rebin, refit
from .._state import Finding, Investigation
from ..spectrum import _model
from ..spectrum._climb import log_scatter
from ._codes import UNROUNDED, Rounding, rounding
from ._held_out import of_codes, of_rails

# Beside this part of the noise a code's width says nothing.
_FINE = 0.05
# So many logs of rates for one of differences of an angle, among those with coarse codes.
_RATES = 3.0
# How exactly that Q is expected, in the logarithm of its square.
_ROUGH = 0.02
# Where quantization rules the samples, codes matter that add such a part to the power of N, if by
# twice the log-likelihood N is known to be there.
_ADDED, _KNOWN = 0.05, 30.0


def about_format(state: Investigation) -> None:
    """Samples that were held, rounded or clipped: known for sure, modelled as they were made."""
    made, used = state.format, usable(state.values, state.pieces)
    if made.repeat is not None:
        state.name_once(Finding("sample_hold", made.repeat.log_p, 0.0, detail=made.repeat))
        state.data = state.data._replace(repeat=made.repeat.samples)
        rebin(state)
    if made.coarse:
        _name_codes(state)
    name_fine_codes(state)
    if made.rails and state.finding("saturation") is None:
        state.name_once(Finding("saturation", -1e3, 0.0))
        state.gains["saturation"] = of_rails(used, made.rails)
    # Rounding is white noise behind any filter, however little.
    state.rounding = Rounding(made.width**2 / 12, 0.0, 0.0)
    if made.discrete and made.repeat is None:
        state.rounding = rounding(used, made.width, made.sigma)
    about_angle(state)
    refit(state)


def name_fine_codes(state: Investigation) -> None:
    """Name codes that are fine beside the samples, but not beside N, once N is known.

    Those of an angle add nothing to N.
    """
    of_angle = state.rate_rounded < 0.5
    if state.finding("output_rounding") is None and not of_angle and _beside_n(state):
        _name_codes(state)


def _name_codes(state: Investigation) -> None:
    used = usable(state.values, state.pieces)
    state.name_once(Finding("output_rounding", -1e3, 0.0))
    state.gains["output_rounding"] = of_codes(used, state.format.width)


def _beside_n(state: Investigation) -> bool:
    """Whether quantization rules the samples, and codes too fine to be seen there add to N."""
    quantization, white = np.exp(state.model.theta[:2])
    rules = 2 * quantization > state.format.sigma**2 / 2
    if not rules or state.format.width**2 / 12 < _ADDED * white:
        return False
    return _model.rise_without(1, state.model, state.data) > _KNOWN


def about_angle(state: Investigation) -> bool:
    """Codes of an angle are no rounding of the rate, since Q says it all; whether they are such.

    If so the structure has to be fitted again.
    """
    if state.rounding.added == 0:
        # Fine codes, or those of an angle already.
        return False
    state.rate_rounded = _rate_is_rounded(state)
    if state.rate_rounded >= 0.5:
        return False
    state.rounding = UNROUNDED
    state.findings = [each for each in state.findings if each.name != "output_rounding"]
    state.gains.pop("output_rounding", None)
    return True


def _rate_is_rounded(state: Investigation) -> float:
    """The probability that codes are of the values logged, and not of what was differenced.

    If an angle, or a velocity, is rounded and its differences are logged, Q is one code over
    sqrt(12), and there is nothing else to add; rounding of the rate leaves Q as it is, mostly zero.
    The two are compared by their evidence, all values of Q over ten e-folds being alike to the
    latter, and zero as likely.
    """
    width, model = state.format.width, state.model
    if state.format.angle is not None:
        return 0.0
    if width < _FINE * state.format.sigma or model.kinds.angle_filtered:
        # What is filtered after its angle was rounded has no codes any more.
        return 1.0
    _, covariance = log_scatter(model.theta, model.kinds, state.data)
    # Rounding an angle that moves by less than a code between samples is not quite white, and its
    # errors correlate by about exp(-2 (pi s)^2), s being that move in codes.
    move = np.exp(model.theta[1] / 2) / width
    alike = _ROUGH + 2 * np.exp(-2 * (np.pi * move) ** 2)
    deviation = float(np.hypot(np.sqrt(covariance[0, 0]), alike))
    score = (model.theta[0] - np.log(width**2 / 12)) / max(deviation, 1e-9)
    absent = _model.rise_without(0, model, state.data)
    # Between what was fitted and none at all nothing is worse than none.
    misfit = min(score**2, absent) if score > 0 else score**2
    vague = 0.5 * np.exp(-absent / 2) + 0.5 * min(deviation * np.sqrt(2 * np.pi) / 10, 1.0)
    return float(_RATES * vague / (_RATES * vague + np.exp(-misfit / 2)))
