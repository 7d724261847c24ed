"""The simulation that a channel was compared with, as plain data: coefficients and curves."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ...curves import unit_scale
from ...identify import Fit
from ...identify._curves_document import listed
from ...identify._fit_document import coefficients_document, exact_document
from ...physics import SYMBOLS
from ...recording import Channel
from ._references import Reference


def simulation_document(reference: Reference, fit: Fit | None, channel: Channel) -> dict[str, Any]:
    """Its file, channel and coefficients, in the unit of the `channel` that it is compared with.

    `fit` is the best of a simulated recording, None for coefficients of a file. `assumed_unit` is
    the unit that a simulation without one is taken to be in, null if it has one.
    """
    if fit is None:
        values = dict(zip(SYMBOLS, map(float, reference.coefficients), strict=True))
        coefficients = exact_document(values, channel)
    else:
        coefficients = coefficients_document(fit, channel)
    return {
        "recording": reference.recording,
        "channel": reference.channel,
        "assumed_unit": (reference.unit or None) if reference.unit_assumed else None,
        "coefficients": coefficients,
    }


def simulation_curves(
    reference: Reference, simulated: Fit | None, fit: Fit, factor: float
) -> dict[str, list[float | None]]:
    """Its Allan deviation and density at the averaging times and frequencies of a recording's fit.

    Those of a `simulated` recording are interpolated, and null beyond its ends; those of
    coefficients are expectations.
    """
    dt, design = 1 / float(fit.rate_hz), fit.design
    tau, frequency = (np.asarray(each, float) for each in (design.cluster_sizes, design.frequency))
    if simulated is None:
        power = (reference.coefficients / np.asarray(unit_scale(dt), float)) ** 2
        variance = np.asarray(design.allan) @ power
        density = np.asarray(design.density) @ power[:4] * dt
    else:
        own, found = simulated.design, simulated.estimate.statistics
        step = 1 / float(simulated.rate_hz)
        variance = _between(
            tau * dt, np.asarray(own.cluster_sizes) * step, np.asarray(found.allan, float)
        )
        density = _between(
            frequency / dt,
            np.asarray(own.frequency) / step,
            np.asarray(found.density, float) * step,
        )
    return {
        "allan": listed(np.sqrt(variance) / factor),
        "psd": listed(density / factor**2),
    }


def _between(
    at: Float[np.ndarray, " points"], x: Float[np.ndarray, " known"], y: Float[np.ndarray, " known"]
) -> Float[np.ndarray, " points"]:
    """A curve that is straight between its points in logarithms."""
    # Two records of one length may differ in the last digit of their first frequency.
    ends = x[0] * 0.99, x[-1] * 1.01
    with np.errstate(divide="ignore"):
        found = np.exp(np.interp(np.log(at), np.log(x), np.log(y)))
    return np.where((at >= ends[0]) & (at <= ends[1]), found, np.nan)
