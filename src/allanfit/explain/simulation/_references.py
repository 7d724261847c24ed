"""What a recording is compared with: a simulated one, or coefficients."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ...coefficient_units import UNITS
from ...coefficients import Coefficients, read_coefficients
from ...identify import Fit, fit_series
from ...physics import SYMBOLS, Sampling
from ...recording import Channel, Recording, is_recording, load
from ...recording._load import channel_of
from ...recording._recording import NoRateError
from ...recording._units import parse_unit
from ...simulate import simulate

# Nobody simulates how the room's temperature went, and when it was moved or shaken.
_UNDRAWN = ("temperature", "disturbance", "vibration_rectification")


@dataclass(frozen=True)
class Reference:
    """What a channel is compared with, at the bins of the recording's own fit."""

    #: Q, N, B, K, R of the simulation in SI, and their standard deviations, which those of a file
    #: have none of. Those of a recording are of its five terms alone, until `explain` has found
    #: what else it has.
    coefficients: Float[np.ndarray, " terms"]
    deviations: Float[np.ndarray, " terms"]
    #: Its unit as given, and what that measures: `gyro`, `accelerometer` or `other`.
    unit: str
    kind: str
    #: The name of its file, and of the channel in it.
    recording: str
    channel: str
    #: The simulated channel and its recording, where there is one: what it has beside the five
    #: terms is found as in any recording.
    simulated: tuple[Channel, Recording] | None = None
    #: Frequencies [Hz], densities [u^2/Hz] and ordinates of a simulated recording; None for
    #: coefficients, whose density is exact.
    frequency: Float[np.ndarray, " bins"] | None = None
    density: Float[np.ndarray, " bins"] | None = None
    ordinates: Float[np.ndarray, " bins"] | None = None
    #: Whether it came without a unit, and is taken to be in the recording's.
    unit_assumed: bool = False
    #: Effects that its file names and that no drawn recording shows as the real one does.
    undrawn: tuple[str, ...] = ()

    @property
    def rate_hz(self) -> float | None:
        """The rate of a simulated recording; coefficients have none."""
        return None if self.simulated is None else self.simulated[1].rate_hz


def references(
    simulation: Path | str | Recording | None, recording: Recording, sampling: Sampling
) -> dict[str, Reference]:
    """What each channel is compared with, by its name or kind; the only one serves all.

    A simulation without a unit is taken to be in the recording's. Coefficients with effects beside
    them are simulated, over as long a time.

    **Raises:** `ValueError` when no channel of the simulation goes with one of the recording, or
    one measures something else or has no noise.
    """
    if simulation is None:
        return {}
    if isinstance(simulation, (str, Path)) and not is_recording(Path(simulation)):
        found = {
            entry.channel: _of_entry(entry, Path(simulation).name, recording, sampling)
            for entry in read_coefficients(simulation)
        }
    else:
        drawn = simulation if isinstance(simulation, Recording) else _loaded(simulation, recording)
        assumed = not any(channel.unit for channel in drawn.channels)
        if assumed:
            channels = tuple(_in_unit(each, recording) for each in drawn.channels)
            drawn = replace(drawn, channels=channels)
        found = {
            channel.name: replace(_of_channel(channel, drawn, sampling), unit_assumed=assumed)
            for channel in drawn.channels
        }
    chosen = _chosen(found, recording)
    for channel in recording.channels:
        other = chosen.get(channel.name)
        if other is not None and other.kind != channel.kind:
            ours, theirs = (each.unit or "no unit" for each in (channel, other))
            raise ValueError(
                f"The simulation of {channel.name} is in {theirs}, the recording in {ours}: they "
                "do not measure the same; compare like with like, or correct the unit of one."
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
        return load(path)
    except NoRateError:
        return load(path, rate_hz=recording.rate_hz)


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


def terms_of(fit: Fit) -> tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]]:
    """Q, N, B, K, R of a fit in SI, and their standard deviations.

    Noise is that of least squares, whose density is closest to the spectrum.
    """
    draws = np.asarray(fit.estimate.draws, float)
    values = np.abs(np.asarray(fit.estimate.least_squares, float))
    return values, np.append(np.abs(draws[:, :4]).std(axis=0), draws[:, 4].std())


def _of_entry(
    entry: Coefficients, name: str, recording: Recording, sampling: Sampling
) -> Reference:
    unit = parse_unit(entry.unit or _own_unit(entry.channel, recording))
    if entry.effects:
        si = entry.times(unit.factor, unit.si_unit)
        samples = len(recording.channels[0].samples)
        drawn = simulate(
            si.medians,
            duration_s=samples / recording.rate_hz,
            rate_hz=recording.rate_hz,
            seed=0,
            sampling=si.sampling,
            effects=tuple(each for each in si.effects if each.name not in _UNDRAWN),
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
        made = Recording(name, recording.rate_hz, (channel,), (), (), "")
        undrawn = tuple(each.name for each in si.effects if each.name in _UNDRAWN)
        return replace(
            _of_channel(channel, made, sampling), unit_assumed=not entry.unit, undrawn=undrawn
        )
    values = [abs(float(entry.medians.get(symbol, 0.0))) * unit.factor for symbol in SYMBOLS]
    if not any(values[:4]):
        raise ValueError(
            f"The simulation of {entry.channel} has no noise to compare: give one of Q, N, B and K."
        )
    return Reference(
        np.array(values),
        np.zeros(len(SYMBOLS)),
        unit.name,
        unit.kind,
        name,
        entry.channel,
        unit_assumed=not entry.unit,
    )


def _of_channel(channel: Channel, recording: Recording, sampling: Sampling) -> Reference:
    rate_hz = recording.rate_hz
    fit = fit_series(channel.samples, rate_hz, sampling=sampling, stretches=channel.stretches)
    return Reference(
        *terms_of(fit),
        channel.unit,
        channel.kind,
        recording.name,
        channel.name,
        (channel, recording),
        np.asarray(fit.design.frequency) * rate_hz,
        np.asarray(fit.estimate.statistics.density) / rate_hz,
        np.asarray(fit.design.ordinates),
    )
