"""A recording against a simulation: where they differ, and whether a coefficient is to blame."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.stats import f as fisher

from ..coefficient_units import UNITS
from ..coefficients import Coefficients, read_coefficients
from ..curves import unit_scale
from ..identify import Fit, fit_series
from ..physics import EFFECTS, SYMBOLS, Sampling
from ..recording import Channel, Recording, is_recording, load
from ..recording._load import channel_of
from ..recording._recording import NoRateError
from ..recording._units import parse_unit
from ..simulate import simulate
from ._mismatch import span

_SIGNIFICANT = 0.005
# Compared in bands of about an octave.
_BINS_A_BAND = 5


@dataclass(frozen=True)
class Reference:
    """What a channel is compared with, at the bins of the recording's own fit."""

    #: Coefficients Q, N, B, K of the simulation in SI.
    coefficients: Float[np.ndarray, " terms"]
    #: Its unit as given, and what that measures: `gyro`, `accelerometer` or `other`.
    unit: str
    kind: str
    #: The simulated channel and its recording, where there is one: what it has beside the five
    #: terms is found as in any recording.
    simulated: tuple[Channel, Recording] | None = None
    #: Frequencies [Hz], densities [u^2/Hz] and ordinates of a simulated recording; None for
    #: coefficients, whose density is exact.
    frequency: Float[np.ndarray, " bins"] | None = None
    density: Float[np.ndarray, " bins"] | None = None
    ordinates: Float[np.ndarray, " bins"] | None = None


def references(
    simulation: Path | str | Recording | None, recording: Recording, sampling: Sampling
) -> dict[str, Reference]:
    """What each channel is compared with, by its name or kind; the only one serves all.

    A simulation without a unit is taken to be in the recording's. Coefficients with effects beside
    them are simulated, over as long a time.

    **Raises:** `ValueError` when no channel of the simulation goes with one of the recording, or
    one measures something else.
    """
    if simulation is None:
        return {}
    if isinstance(simulation, (str, Path)) and not is_recording(Path(simulation)):
        found = {
            entry.channel: _of_entry(entry, recording, sampling)
            for entry in read_coefficients(simulation)
        }
    else:
        drawn = simulation if isinstance(simulation, Recording) else _loaded(simulation, recording)
        found = {channel.name: _of_channel(channel, drawn, sampling) for channel in drawn.channels}
    chosen = _chosen(found, recording)
    for channel in recording.channels:
        other = chosen.get(channel.name)
        if other is not None and {other.kind, channel.kind} == {"gyro", "accelerometer"}:
            raise ValueError(
                f"The simulation of {channel.name} is in {other.unit}, the recording in "
                f"{channel.unit}: they do not measure the same; compare like with like, or "
                "correct the unit of one."
            )
    return chosen


def _chosen(found: dict[str, Reference], recording: Recording) -> dict[str, Reference]:
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
    # A simulator's file may leave out what the recording's user gave on the command line.
    try:
        found = load(path)
    except NoRateError:
        found = load(path, rate_hz=recording.rate_hz)
    if any(channel.unit for channel in found.channels):
        return found
    return replace(found, channels=tuple(_in_unit(each, recording) for each in found.channels))


def _in_unit(channel: Channel, recording: Recording) -> Channel:
    """A channel without a unit in that of the recording's."""
    unit = parse_unit(_own_unit(channel.name, recording))
    return channel_of(channel.name, channel.samples, unit, channel.stretches, channel.findings)


def _own_unit(name: str, recording: Recording) -> str:
    """The unit of the channel that is called so or of such a kind; of the first if none is."""
    return next(
        (channel.unit for channel in recording.channels if name in (channel.name, channel.kind)),
        recording.channels[0].unit,
    )


def _of_entry(entry: Coefficients, recording: Recording, sampling: Sampling) -> Reference:
    unit = parse_unit(entry.unit or _own_unit(entry.channel, recording))
    if entry.effects:
        si = entry.times(unit.factor, unit.si_unit)
        samples = len(recording.channels[0].samples)
        drawn = simulate(
            si.values,
            duration_s=samples / recording.rate_hz,
            rate_hz=recording.rate_hz,
            seed=0,
            sampling=si.sampling,
            effects=si.effects,
        )
        channel = Channel(
            entry.channel,
            unit.name,
            unit.factor,
            unit.si_unit,
            unit.kind,
            np.asarray(drawn, float),
            ((0, samples),),
            (),
        )
        made = Recording(entry.channel, recording.rate_hz, (channel,), (), (), "")
        return _of_channel(channel, made, sampling)
    values = [float(entry.values.get(symbol, 0.0)) * unit.factor for symbol in SYMBOLS[:4]]
    return Reference(np.array(values), unit.name, unit.kind)


def _of_channel(channel: Channel, recording: Recording, sampling: Sampling) -> Reference:
    rate_hz = recording.rate_hz
    fit = fit_series(channel.samples, rate_hz, sampling=sampling, stretches=channel.stretches)
    values = np.array([float(fit.coefficients[symbol]) for symbol in SYMBOLS[:4]])
    return Reference(
        values,
        channel.unit,
        channel.kind,
        (channel, recording),
        np.asarray(fit.design.frequency) * rate_hz,
        np.asarray(fit.estimate.statistics.density) / rate_hz,
        np.asarray(fit.design.ordinates),
    )


def compared(
    fit: Fit,
    reference: Reference,
    found: list[dict[str, Any]],
    simulated: list[dict[str, Any]] | None = None,
) -> list[dict[str, Any]]:
    """Bands in which recording and simulation differ, strongest first.

    `found` is where the recording differs from its five terms, and `simulated` where the
    simulation does, with the names of the effects. What both have is no difference, but for its
    size. A difference that the recording's own five terms reproduce is one of coefficients, and the
    term that dominates there is named; another is physics that one of the two does not have.
    """
    simulated = simulated or []
    dt = 1 / float(fit.rate_hz)
    frequency = np.asarray(fit.design.frequency) / dt
    density = np.asarray(fit.estimate.statistics.density, float) * dt
    ordinates = np.asarray(fit.design.ordinates)
    scale = np.asarray(unit_scale(dt), float)[:4]
    unit = np.asarray(fit.design.density) * dt
    own = np.array([float(fit.coefficients[symbol]) for symbol in SYMBOLS[:4]]) / scale
    model = unit @ own**2
    bands = range(0, frequency.size, _BINS_A_BAND)
    entries = []
    for begin in bands:
        part = slice(begin, begin + _BINS_A_BAND)
        end = frequency[begin + _BINS_A_BAND] if begin + _BINS_A_BAND < frequency.size else np.inf
        weight = ordinates[part]
        drawn, others = _simulated(
            reference, frequency, model, ordinates, unit / scale**2, part, end
        )
        if others == 0:
            continue
        # Sums over a band, not ratios of single bins: those of few ordinates have no mean.
        seen = float(np.sum(weight * density[part] / model[part]) / weight.sum())
        ratio = seen / drawn
        chance = _two_sided(ratio, weight.sum(), others, len(bands))
        if chance > _SIGNIFICANT:
            continue
        terms = unit[part] @ np.diag(np.maximum(own, reference.coefficients / scale) ** 2)
        dominant = SYMBOLS[int(np.argmax(terms.sum(axis=0)))]
        low, high = float(frequency[part][0]), float(frequency[part][-1])
        here = {"domain": "frequency", "low": low, "high": high}
        own_physics = _two_sided(seen, weight.sum(), 1e9, len(bands)) < _SIGNIFICANT
        both = next((each["effect"] for each in simulated if _meet(each, here)), None)
        if both is not None and any(_meet(each, here) for each in found):
            physics, dominant = False, both
        else:
            physics = own_physics or both is not None
        if not physics:
            cause = f"its {_plain(dominant)} is too {'small' if ratio > 1 else 'large'}"
        elif both is not None:
            cause = f"it has {EFFECTS[both].what}, which the recording has not"
        else:
            cause = "physics is absent from it"
        entries.append(
            {
                "domain": "frequency",
                "low": low,
                "high": high,
                "unit": "Hz",
                "ratio": ratio,
                "p_value": chance,
                "sentence": f"{span(low, high)} the recording has {ratio:.3g} times "
                f"the power of the simulation: {cause}.",
                "cause": "physics" if physics else "coefficient",
                "coefficient": None if physics else dominant,
                "absent_from": None
                if not physics
                else "simulation"
                if both is None
                else "recording",
            }
        )
    entries += [
        {**entry, "cause": "physics", "coefficient": None, "absent_from": "simulation"}
        for entry in found
        if not any(_meet(each, entry) for each in entries)
        and not any(_alike(each, entry) for each in simulated)
    ]
    return sorted(_joined(entries), key=lambda entry: entry["p_value"])


def _meet(one: dict[str, Any], other: dict[str, Any]) -> bool:
    return (
        one["domain"] == other["domain"]
        and one["low"] <= other["high"]
        and other["low"] <= one["high"]
    )


def _alike(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether two effects are one kind of thing: of one name, and of one band if it has a band."""
    if one["domain"] == other["domain"] == "time":
        return one["effect"] == other["effect"]
    return _meet(one, other)


def _plain(name: str) -> str:
    return name if len(name) == 1 else name.replace("_", " ")


def _simulated(
    reference: Reference,
    frequency: Float[np.ndarray, " bins"],
    model: Float[np.ndarray, " bins"],
    ordinates: Float[np.ndarray, " bins"],
    unit: Float[np.ndarray, "bins terms"],
    part: slice,
    end: float,
) -> tuple[float, float]:
    """Mean density of the simulation over the recording's model in a band, and its ordinates."""
    if reference.density is None or reference.frequency is None or reference.ordinates is None:
        exact = (unit @ reference.coefficients**2)[part] / model[part]
        return float(np.average(exact, weights=ordinates[part])), 1e9
    inside = (reference.frequency >= 0.999 * frequency[part][0]) & (reference.frequency < end)
    weight, at = reference.ordinates[inside], reference.frequency[inside]
    if not weight.size:
        return 0.0, 0.0
    there = np.exp(np.interp(np.log(at), np.log(frequency), np.log(model)))
    return float(weight @ (reference.density[inside] / there) / weight.sum()), float(weight.sum())


def _two_sided(ratio: float, ordinates: float, others: float, tests: int) -> float:
    above = float(fisher.sf(ratio, ordinates, others))
    below = float(fisher.cdf(ratio, ordinates, others))
    return min(1.0, 2 * tests * min(above, below))


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
            ratio = max(last["ratio"], entry["ratio"], key=lambda each: abs(np.log(each)))
            extreme = "up" if ratio > 1 else "down"
            last.update(
                high=entry["high"],
                ratio=ratio,
                p_value=strongest["p_value"],
                sentence=f"{span(last['low'], entry['high'])} the recording has "
                f"{extreme} to {ratio:.3g} times the power of the simulation: {cause}"
                if ": " in strongest["sentence"]
                else strongest["sentence"],
            )
        else:
            kept.append(dict(entry))
    return kept
