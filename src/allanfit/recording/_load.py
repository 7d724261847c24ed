"""From a file or arrays to a checked recording: `load` and `recording_of`."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import table_of
from ._channel_units import about_units, is_beside, units_of, why_state
from ._checks import FEWEST_SAMPLES, about_samples, split, usable, why_useless
from ._copies import about_copies, copies
from ._formats import read_table
from ._frozen import frozen
from ._gravity import about_gravity
from ._mistakes import about_mistakes
from ._other_sensors import about_others, is_field_or_attitude
from ._recording import Channel, NoRateError, Progress, Recording, RecordingError, Table
from ._temperature import is_temperature, read_temperature
from ._timestamps import Clock, read_clock, time_columns
from ._units import Unit
from ._wording import count, left_out
from ._wraps import why_wraps

# From a clock compared once a week to what no converter reaches.
_RATES = (1e-6, 1e9)


def load(
    path: str | os.PathLike[str],
    *,
    rate_hz: float | None = None,
    channels: Sequence[str] | None = None,
    unit: str | None = None,
    topic: str | None = None,
    progress: Progress | None = None,
) -> Recording:
    """Read a still recording, check it and convert it to SI units.

    **Arguments:**

    - `path`: a `.csv`, `.txt` or `.tsv` (each may be gzipped: `.csv.gz`), `.npy` or `.npz` file;
        with the extra `io` also `.parquet`, `.mat`, `.h5`, `.hdf5`, a ROS 1 or 2 bag, `.mcap` or
        PX4's `.ulg`. A column named `time`, `time_s`, `timestamp` or `t` holds time stamps.
    - `rate_hz`: samples a second. Without it the file's own is used, or else the time stamps'.
    - `channels`: names of the channels to analyse. Without it all are but time stamps and those of
        other sensors: temperatures, magnetometers, pressures, batteries and the like.
    - `unit`: the unit of the channels, `deg/s` for instance, in place of the file's. It applies
        to channels that have none or one of the same kind. Units of two kinds have a comma between
        them, `deg/s, g`; raw codes a scale factor before the unit, `1/131 deg/s`.
    - `topic`: which part of a file to read that holds several: a topic of a bag or log, a group
        of HDF5, a structure of a MAT-file. `allanfit.recording.contents` lists them.
    - `progress`: called now and then with the messages read and their number, for bags.

    **Returns:** a `Recording`. What is wrong with it but does not forbid an analysis is said in
    its `findings` and those of its channels. Nothing is interpolated: gaps, values that are not
    finite and frozen ones divide a channel into `stretches`.

    **Raises** `RecordingError` when the file cannot be read, no rate is known, a unit or a channel
    is unknown, or no channel has 256 usable samples that vary.

    ```python
    recording = allanfit.load("gyro.csv", rate_hz=200.0, unit="deg/s")
    recording.channels[0].samples  # in rad/s
    ```
    """
    path = Path(path)
    _check_given(rate_hz)
    return _recording(path, read_table(path, topic, progress), rate_hz, channels, unit)


def recording_of(
    data: Mapping[str, ArrayLike] | ArrayLike,
    *,
    rate_hz: float | None = None,
    channels: Sequence[str] | None = None,
    unit: str | None = None,
    units: Mapping[str, str] | None = None,
    name: str = "recording",
) -> Recording:
    """A recording of arrays, checked and converted as `load` does with those of a file.

    **Arguments:**

    - `data`: columns by name, as in a dictionary or a data frame, each of shape (samples,), time
        stamps and temperatures among them; or one array, (samples,) or (channels, samples).
    - `rate_hz`, `channels`, `unit`: as in `load`.
    - `units`: the unit of each column that is in another one, by its name.
    - `name`: what messages and documents call it.

    **Returns:** a `Recording`, for `explain`.

    **Raises** `RecordingError` as `load` does, and for what is no array of real numbers.

    >>> gyro = np.random.default_rng(0).standard_normal(1000)
    >>> recording_of({"gyro_x": gyro}, rate_hz=100, unit="deg/s").channels[0].unit
    'deg/s'
    """
    _check_given(rate_hz)
    if isinstance(units, str):
        raise RecordingError(
            "units gives the unit of each column by its name, as {'gyro_x': 'deg/s'} does; one for "
            f"all is unit={units!r}."
        )
    table = table_of(data, units or {})
    return _recording(Path(name), table, rate_hz, channels, unit)


def _check_given(rate_hz: float | None) -> None:
    if rate_hz is not None:
        check_rate(rate_hz, "the rate given")


def _recording(
    path: Path,
    table: Table,
    rate_hz: float | None,
    channels: Sequence[str] | None,
    unit: str | None,
) -> Recording:
    """What was read, checked and in SI units."""
    if isinstance(channels, str):
        channels = (channels,)
    if rate_hz is None and table.rate_hz is not None:
        rate_hz = table.rate_hz
        check_rate(rate_hz, f"rate_hz in {path.name}")
    stamps, aside, warm, asked = columns_of(path, table, channels)
    check_lengths(path, table, [*asked, *([stamps] if stamps else [])])
    if stamps:
        table = _without_copies(table, stamps, asked)
    # Of so few samples the time stamps tell no rate either.
    samples = max(table.columns[name].size for name in asked)
    if stamps and samples < FEWEST_SAMPLES:
        raise RecordingError(
            f"{path.name} cannot be analysed: it has {count(samples, 'sample')}, and at least "
            f"{FEWEST_SAMPLES} are needed."
        )
    clock = clock_of(path, table, stamps, rate_hz)
    units = units_of(asked, aside, table, unit)
    kept = []
    useless_for: dict[str, list[str]] = {}
    for name in asked:
        values = units[name].read(table.columns[name])
        still = frozen(values)
        stretches = split(np.isfinite(values) & ~still, clock.breaks)
        used = usable(values, stretches)
        wanted = bool(channels) or len(asked) == 1
        useless = (
            why_state(name, used, units[name], wanted)
            or why_useless(used)
            or why_wraps(used, units[name].name)
        )
        if useless and wanted:
            raise RecordingError(f"{path.name}: channel {name} cannot be analysed: {useless}.")
        if useless:
            useless_for.setdefault(useless, []).append(name)
            continue
        about = about_samples(values, still, stretches, units[name].name, clock.rate_hz)
        kept.append(channel_of(name, values, units[name], stretches, about))
    if not kept:
        raise RecordingError(f"{path.name} has no channel to analyse. {left_out(useless_for)[-1]}")
    auxiliary, doubts = _auxiliary(table, aside, warm, asked, clock)
    said = about_units({channel.name: units[channel.name] for channel in kept}, table, unit)
    beside = about_beside(table, aside, asked)
    findings = [*table.findings, *clock.findings, *said, *left_out(useless_for), *beside, *doubts]
    digest = hashlib.sha256()
    for channel in (*kept, *(each for each in auxiliary if each.kind == "temperature")):
        digest.update(channel.samples.data)
        digest.update(channel.si_unit.encode())
    return Recording(
        name=path.name,
        rate_hz=clock.rate_hz,
        channels=tuple(kept),
        auxiliary=auxiliary,
        findings=(*findings, *about_gravity(kept), *about_mistakes(kept, clock.rate_hz)),
        checksum=digest.hexdigest(),
        lost=clock.lost,
        losses=clock.losses,
        lost_deviation=clock.lost_deviation,
    )


def _without_copies(table: Table, stamps: str, asked: list[str]) -> Table:
    """The table without rows that were written twice."""
    again = copies(table.columns[stamps], (table.columns[name] for name in asked))
    if not again.any():
        return table
    columns = {
        name: column[~again] if column.size == again.size else column
        for name, column in table.columns.items()
    }
    about = about_copies(int(again.sum()), again.size)
    return replace(table, columns=columns, findings=(*table.findings, *about))


def check_rate(rate_hz: float, origin: str) -> None:
    """Raise `RecordingError` for a rate that is none; `origin` says where it is from."""
    low, high = _RATES
    if not low <= rate_hz <= high:
        raise RecordingError(
            f"A rate is a number of samples a second from {low:g} to {high:g}; {origin} is "
            f"{rate_hz:g}."
        )


def columns_of(
    path: Path, table: Table, channels: Sequence[str] | None
) -> tuple[str | None, set[str], set[str], list[str]]:
    """Time stamps, what is recorded beside the channels, temperatures in it, and the channels."""
    warm = {name for name in table.columns if is_temperature(name, table.unit(name), table)}
    times = [name for name in time_columns(table.columns, table.units) if name not in warm]
    names = [name for name in table.columns if name not in times]
    aside = {name for name in names if name in warm or is_field_or_attitude(name)}
    others = [name for name in names if name not in aside and is_beside(name, table)]
    asked = _asked(path, names, aside, others, channels)
    aside |= {name for name in others if name not in asked}
    return next(iter(times), None), aside, warm, asked


def about_beside(table: Table, aside: set[str], asked: list[str]) -> tuple[str, ...]:
    """A finding on columns that are set aside, where it may surprise."""
    left = (name for name in table.columns if name in aside and name not in asked)
    return about_others(name for name in left if is_beside(name, table))


def _asked(
    path: Path,
    names: list[str],
    aside: set[str],
    others: list[str],
    channels: Sequence[str] | None,
) -> list[str]:
    if not channels:
        # Where there is nothing else, they are what was recorded.
        chosen = [name for name in names if name not in (*aside, *others)] or others
        if not chosen:
            there = f": it holds {', '.join(names)}, which --channel can ask for" if names else ""
            raise RecordingError(f"{path.name} has no inertial channel{there}.")
        return chosen
    return list(dict.fromkeys(_called(path, name, names) for name in channels))


def _called(path: Path, name: str, names: list[str]) -> str:
    """The channel of that name, or the only one that differs from it in case alone."""
    alike = [each for each in names if each.casefold() == name.casefold()]
    if name in names:
        return name
    if len(alike) == 1:
        return alike[0]
    raise RecordingError(f"{path.name} has no channel {name}; it has {', '.join(names) or 'none'}.")


def check_lengths(path: Path, table: Table, names: list[str]) -> None:
    """Raise `RecordingError` for columns that are not equally long."""
    lengths = {table.columns[name].size: name for name in names}
    if len(lengths) > 1:
        told = " and ".join(f"{name} has {length}" for length, name in list(lengths.items())[:2])
        raise RecordingError(
            f"{path.name}: channels sampled together have equally many samples, but {told}."
        )


def clock_of(
    path: Path,
    table: Table,
    stamps: str | None,
    rate_hz: float | None,
    known: int | None = None,
) -> Clock:
    """The time axis by a given rate, the column `stamps`, or both; `known` as for `read_clock`."""
    if stamps is None:
        if rate_hz is None:
            raise NoRateError(
                " ".join(
                    (
                        f"{path.name} tells no sampling rate, neither by rate_hz nor by time "
                        "stamps: give it with --rate, in Hz, or call the time stamps `time`.",
                        *table.findings,
                    )
                )
            )
        return Clock(rate_hz, (), ())
    try:
        unit = table.units.get(stamps, "")
        clock = read_clock(table.columns[stamps], stamps, unit, rate_hz, known)
        check_rate(clock.rate_hz, "that of the time stamps")
    except RecordingError as error:
        if rate_hz is None:
            raise RecordingError(f"{path.name}: {error} Give the rate with --rate.") from error
        return Clock(rate_hz, (), (f"{error} Gaps, if there are any, are not seen.",))
    return clock if rate_hz is None else replace(clock, rate_hz=rate_hz)


def channel_of(
    name: str,
    values: np.ndarray,
    unit: Unit,
    stretches: tuple[tuple[int, int], ...],
    findings: tuple[str, ...],
) -> Channel:
    """A channel of `values` in its unit."""
    return Channel(
        name=name,
        unit=unit.name,
        factor=unit.factor,
        si_unit=unit.si_unit,
        kind=unit.kind,
        samples=values * unit.factor,
        stretches=stretches,
        findings=findings,
    )


def _auxiliary(
    table: Table, aside: set[str], warm: set[str], asked: list[str], clock: Clock
) -> tuple[tuple[Channel, ...], list[str]]:
    """Temperatures and magnetometers, sampled with the channels and not among them."""
    length = table.columns[asked[0]].size
    auxiliary, findings = [], []
    for name, column in table.columns.items():
        if name not in aside or name in asked:
            continue
        values, unit = column.astype(np.float64), table.unit(name)
        if name in warm:
            channel, doubts = read_temperature(name, values, unit, length, clock)
            findings += doubts
            if channel is not None:
                auxiliary.append(channel)
                continue
        if column.size == length:
            stretches = split(np.isfinite(values), clock.breaks)
            auxiliary.append(channel_of(name, values, Unit(unit, si_unit=unit), stretches, ()))
    return tuple(auxiliary), findings
