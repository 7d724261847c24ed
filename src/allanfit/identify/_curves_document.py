"""Both curves of a fit as plain data: points, bands and what each term puts into them."""

from typing import Any

import jax
import numpy as np
from scipy.stats import chi2

from ..curves import allan_variance_deviation, unit_scale
from ..physics import SYMBOLS, NoiseModel, standard_model
from ._fit import Fit


def curves_document(fit: Fit, factor: float) -> dict[str, Any]:
    """The `curves` of the fit JSON for one sensor, in units of `factor`.

    Bands hold the true expectation with 95 % probability, point by point: chi-square with the
    degrees of freedom that the fitted model gives each point, 2 E^2/Var.
    """
    # Both curves are kept for a sampling interval of one, in float64 whatever the data came in.
    with jax.enable_x64(True):
        dt = 1 / float(fit.rate_hz)
        scale = np.asarray(unit_scale(dt))
        coefficients = {
            symbol: float(value) / scale[i]
            for i, (symbol, value) in enumerate(fit.coefficients.items())
            # An unresolved ramp is as likely to point either way, and belongs on no line.
            if symbol != "R" or bool(fit.resolved["R"])
        }
        model = standard_model(coefficients)
        return {"allan": _allan(fit, model, dt, factor), "psd": _psd(fit, model, dt, factor)}


def _allan(fit: Fit, model: NoiseModel, dt: float, factor: float) -> dict[str, Any]:
    sizes = np.asarray(fit.design.cluster_sizes, float)
    power = {term.symbol: float(term.coefficient) ** 2 for term in model.terms}
    columns = zip(SYMBOLS, np.asarray(fit.design.allan).T, strict=True)
    expected = {symbol: power[symbol] * column for symbol, column in columns}
    mean = np.sum(list(expected.values()), axis=0)
    found = np.asarray(fit.estimate.statistics.allan, float) / factor**2
    spread = np.asarray(allan_variance_deviation(model, fit.design))
    low, high = _band(found, 2 * (mean / spread) ** 2)
    return {
        "tau_s": (sizes * dt).tolist(),
        "deviation": listed(np.sqrt(found)),
        "model": listed(np.sqrt(mean) / factor),
        "band_95": [listed(np.sqrt(low)), listed(np.sqrt(high))],
        "terms": {symbol: listed(np.sqrt(expected[symbol]) / factor) for symbol in SYMBOLS},
    }


def _psd(fit: Fit, model: NoiseModel, dt: float, factor: float) -> dict[str, Any]:
    frequency = np.asarray(fit.design.frequency)
    found = np.asarray(fit.estimate.statistics.density, float) * dt / factor**2
    noise = [term for term in model.terms if term.symbol != "R"]
    # The mean of the density over each bin, not its value at the centre.
    power = np.array([float(term.coefficient) ** 2 for term in noise])
    terms = np.asarray(fit.design.density) * power * dt / factor**2
    low, high = _band(found, np.asarray(fit.design.ordinates))
    by_symbol = {term.symbol: listed(terms[:, i]) for i, term in enumerate(noise)}
    return {
        "frequency_hz": (frequency / dt).tolist(),
        "density": listed(found),
        "model": listed(np.sum(terms, axis=1)),
        "band_95": [listed(low), listed(high)],
        "terms": by_symbol | {"R": [0.0] * len(frequency)},
    }


def _band(found: np.ndarray, freedom: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return found * freedom / chi2.ppf(0.975, freedom), found * freedom / chi2.ppf(0.025, freedom)


def listed(values: np.ndarray) -> list[float | None]:
    """JSON knows no NaN: what is undefined is null."""
    return [float(value) if np.isfinite(value) else None for value in values]
