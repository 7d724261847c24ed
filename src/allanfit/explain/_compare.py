"""A recording against a simulation: where they differ, and whether a coefficient is to blame."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.stats import f as fisher

from ..coefficient_units import UNITS
from ..coefficients import read_coefficients
from ..curves import unit_scale
from ..identify import Fit, fit_series
from ..physics import SYMBOLS, Sampling
from ..recording import Recording, RecordingError, is_recording, load

_SIGNIFICANT = 0.005
# Compared in bands of about an octave.
_BINS_A_BAND = 5


@dataclass(frozen=True)
class Reference:
    """What a channel is compared with, at the bins of the recording's own fit."""

    #: Coefficients Q, N, B, K of the simulation in SI.
    coefficients: Float[np.ndarray, " terms"]
    #: Frequencies [Hz], densities [u^2/Hz] and ordinates of a simulated recording; None for
    #: coefficients, whose density is exact.
    frequency: Float[np.ndarray, " bins"] | None = None
    density: Float[np.ndarray, " bins"] | None = None
    ordinates: Float[np.ndarray, " bins"] | None = None


def references(
    simulation: Path | str | Recording | None, recording: Recording, sampling: Sampling
) -> dict[str, Reference]:
    """What each channel is compared with, by its name or kind; the only one serves all.

    **Raises:** `ValueError` when no channel of the simulation goes with one of the recording.
    """
    if simulation is None:
        return {}
    if isinstance(simulation, (str, Path)) and not is_recording(Path(simulation)):
        found = {
            entry.channel: Reference(_of_entry(entry)) for entry in read_coefficients(simulation)
        }
    else:
        drawn = simulation if isinstance(simulation, Recording) else _loaded(simulation, recording)
        found = {
            channel.name: _of_series(channel.samples, channel.stretches, drawn.rate_hz, sampling)
            for channel in drawn.channels
        }
    names = [channel.name for channel in recording.channels]
    if len(found) == 1 and not found.keys() & UNITS.keys():
        return dict.fromkeys(names, next(iter(found.values())))
    # A data sheet speaks of kinds of sensors.
    common = {
        channel.name: found[key]
        for channel in recording.channels
        for key in (channel.kind, channel.name)
        if key in found
    }
    if not common:
        raise ValueError(
            f"The simulation has channels {', '.join(found)}, the recording has "
            f"{', '.join(names)}: name one of each alike, or choose one with --channel."
        )
    return common


def _loaded(path: Path | str, recording: Recording) -> Recording:
    unit = recording.channels[0].unit
    try:
        return load(path)
    except RecordingError:
        # A simulator's file may leave out what the recording's user gave on the command line.
        return load(path, rate_hz=recording.rate_hz, unit=unit or None)


def _of_entry(entry: Any) -> Float[np.ndarray, " terms"]:
    from ..recording._units import parse_unit

    factor = parse_unit(entry.unit).factor if entry.unit else 1.0
    return np.array([float(entry.values.get(symbol, 0.0)) * factor for symbol in SYMBOLS[:4]])


def _of_series(samples, stretches, rate_hz: float, sampling: Sampling) -> Reference:
    fit = fit_series(samples, rate_hz, sampling=sampling, stretches=stretches)
    values = np.array([float(fit.coefficients[symbol]) for symbol in SYMBOLS[:4]])
    return Reference(
        values,
        np.asarray(fit.design.frequency) * rate_hz,
        np.asarray(fit.estimate.statistics.density) / rate_hz,
        np.asarray(fit.design.ordinates),
    )


def compared(fit: Fit, reference: Reference, found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Bands in which recording and simulation differ, strongest first.

    A difference that the recording's own five terms reproduce is one of coefficients, and the
    term that dominates there is named; another is physics that the simulation does not have.
    """
    dt = 1 / float(fit.rate_hz)
    frequency = np.asarray(fit.design.frequency) / dt
    density = np.asarray(fit.estimate.statistics.density, float) * dt
    ordinates = np.asarray(fit.design.ordinates)
    scale = np.asarray(unit_scale(dt), float)[:4]
    unit = np.asarray(fit.design.density) * dt
    own = np.array([float(fit.coefficients[symbol]) for symbol in SYMBOLS[:4]]) / scale
    if reference.density is None or reference.frequency is None or reference.ordinates is None:
        expected = unit @ (reference.coefficients / scale) ** 2
        freedom = np.full(frequency.size, 1e9)
    else:
        expected = np.exp(
            np.interp(np.log(frequency), np.log(reference.frequency), np.log(reference.density))
        )
        freedom = np.interp(frequency, reference.frequency, reference.ordinates)
    model = unit @ own**2
    bands = range(0, frequency.size, _BINS_A_BAND)
    entries = []
    for begin in bands:
        part = slice(begin, begin + _BINS_A_BAND)
        weight, other = ordinates[part], freedom[part]
        ratio = float(np.sum(weight * density[part] / expected[part]) / weight.sum())
        chance = _two_sided(ratio, weight.sum(), other.sum(), len(bands))
        if chance > _SIGNIFICANT:
            continue
        left = float(np.sum(weight * density[part] / model[part]) / weight.sum())
        physics = _two_sided(left, weight.sum(), 1e9, len(bands)) < _SIGNIFICANT
        terms = unit[part] @ np.diag(np.maximum(own, reference.coefficients / scale) ** 2)
        dominant = SYMBOLS[int(np.argmax(terms.sum(axis=0)))]
        low, high = float(frequency[part][0]), float(frequency[part][-1])
        cause = (
            "physics is absent from it"
            if physics
            else f"its {dominant} is too {'small' if ratio > 1 else 'large'}"
        )
        entries.append(
            {
                "domain": "frequency",
                "low": low,
                "high": high,
                "unit": "Hz",
                "ratio": ratio,
                "p_value": chance,
                "sentence": f"From {low:.4g} to {high:.4g} Hz the recording has {ratio:.3g} times "
                f"the power of the simulation: {cause}.",
                "cause": "physics" if physics else "coefficient",
                "coefficient": None if physics else dominant,
            }
        )
    entries += [
        {**entry, "cause": "physics", "coefficient": None}
        for entry in found
        if not any(
            each["domain"] == entry["domain"]
            and each["low"] <= entry["high"]
            and entry["low"] <= each["high"]
            for each in entries
        )
    ]
    return sorted(_joined(entries), key=lambda entry: entry["p_value"])


def _two_sided(ratio: float, ordinates: float, others: float, tests: int) -> float:
    above = float(fisher.sf(ratio, ordinates, others))
    return min(1.0, 2 * tests * min(above, 1 - above if above > 0.5 else 1.0))


def _joined(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Neighbouring bands with one cause, as one."""
    kept: list[dict[str, Any]] = []
    for entry in sorted(entries, key=lambda each: (each["domain"], each["low"])):
        last = kept[-1] if kept else None
        if (
            last is not None
            and last["domain"] == entry["domain"] == "frequency"
            and (last["cause"], last["coefficient"]) == (entry["cause"], entry["coefficient"])
            and (last["ratio"] > 1) == (entry["ratio"] > 1)
        ):
            strongest = min(last, entry, key=lambda each: each["p_value"])
            cause = strongest["sentence"].rpartition(": ")[2]
            ratio = strongest["ratio"]
            last.update(
                high=entry["high"],
                ratio=ratio,
                p_value=strongest["p_value"],
                sentence=f"From {last['low']:.4g} to {entry['high']:.4g} Hz the recording has up "
                f"to {ratio:.3g} times the power of the simulation: {cause}"
                if ": " in strongest["sentence"]
                else strongest["sentence"],
            )
        else:
            kept.append(dict(entry))
    return kept
