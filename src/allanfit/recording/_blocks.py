"""A recording in blocks, checked as they come: `read_in_blocks`, for files larger than memory."""

import itertools
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float64

from ._channel_units import about_units, units_of, why_state
from ._checks import (
    FEWEST_SAMPLES,
    about_samples,
    split,
    usable,
    why_too_large,
    why_useless,
)
from ._copies import about_copies, copies
from ._formats import read_blocks
from ._frozen import FrozenBlocks, frozen
from ._gravity import about_gravity
from ._lateness import CATCH_UP, about_wrong
from ._load import (
    about_beside,
    channel_of,
    check_lengths,
    check_rate,
    clock_of,
    columns_of,
)
from ._mistakes import about_mistakes
from ._recording import Channel, Progress, RecordingError, Table
from ._wording import count, left_out
from ._wraps import why_wraps

# Time stamps are judged over as many samples at least, as those of a short record are.
_FEWEST = 16 * CATCH_UP


@dataclass(frozen=True)
class Run:
    """Samples of one channel, in SI units, that follow one another without a gap."""

    channel: str
    samples: Float64[np.ndarray, " samples"]
    """Perhaps none, where only a stretch ends."""
    ends: bool
    """Whether the stretch that they belong to ends with them."""


class Blocks:
    """A recording whose samples come in runs, in order; iterate once.

    `findings`, `rate_hz` and `lost` are those of the whole recording once all runs have come.
    """

    def __init__(
        self,
        path: Path,
        channels: Sequence[str] | None,
        rate_hz: float | None,
        unit: str | None,
        topic: str | None,
        samples: int,
        progress: Progress,
    ):
        self.name = path.name
        self._path, self._progress = path, progress
        self._tables = self._read(read_blocks(path, samples, topic))
        first = next(self._tables, None)
        if first is None:
            raise RecordingError(f"{path.name} holds no samples.")
        if rate_hz is None and first.rate_hz is not None:
            rate_hz = first.rate_hz
            check_rate(rate_hz, f"rate_hz in {path.name}")
        self._given_hz = rate_hz
        self._stamps, aside, _, self._asked = columns_of(path, first, channels)
        self._first, self._unit = first, unit
        self._units = units_of(self._asked, aside, first, unit)
        self._findings = dict.fromkeys((*first.findings, *about_beside(first, aside, self._asked)))
        self._samples, self._seconds, self._lost, self._breaks = 0, 0.0, 0.0, 0
        self._gaps: list[tuple[int, float, int]] = []
        self._wrong: list[int] = []
        self._off_s = 0.0
        self._doubts: list[tuple[int, tuple[str, ...]]] = []
        self._judged, self._stamp_unit = 0, ""
        self._copies, self._rows_read = 0, 0
        self._missing = dict.fromkeys(self._asked, 0)
        self._frozen = dict.fromkeys(self._asked, 0)
        self._rows = self._checked(first)
        self._next = next(self._rows)
        self.channels = self._first_look(*self._next, channels)

    @property
    def rate_hz(self) -> float:
        """Samples a second, so far."""
        return self._given_hz or float(f"{self._samples / self._seconds:.9g}")

    @property
    def lost(self) -> float:
        """Share of the samples that were lost by the time stamps, as `Recording.lost`, so far."""
        return self._lost / self._samples

    @property
    def findings(self) -> tuple[str, ...]:
        """About the file and its time stamps, so far."""
        found = [
            *self._findings,
            *about_copies(self._copies, self._rows_read),
            *about_wrong(self._wrong, self._off_s),
        ]
        found += self._about_breaks()
        found += [
            f"Left out of {name} as {what}: {count(number, 'sample')}."
            for what, left_out in (
                ("missing or not finite", self._missing),
                ("frozen, repeats of one value", self._frozen),
            )
            for name, number in left_out.items()
            if number
        ]
        if self._doubts:
            first, said = self._doubts[0]
            found.append(
                f"Time stamps were judged block by block; {len(self._doubts)} of {self._judged} "
                f"blocks gave findings, first the one from sample {first}: {' '.join(said)}"
            )
        return tuple(found)

    def _about_breaks(self) -> list[str]:
        if not self._breaks:
            return []
        where, missing = "", "samples"
        if self._gaps:
            numbers = [number for _, _, number in self._gaps]
            longest = max(range(len(self._gaps)), key=lambda k: self._gaps[k][1])
            at, length_s, _ = self._gaps[longest]
            # What was missing before it took its time as well.
            time_s = (at + sum(numbers[:longest])) / self.rate_hz
            where = f"{length_s:.4g} s at {time_s:.6g} s"
            if self._breaks == 1:
                where = f", for {where}"
            else:
                whole_s = sum(length for _, length, _ in self._gaps)
                where = f", for {whole_s:.4g} s in all, the longest {where}"
            missing = f"about {sum(numbers)} samples"
        return [
            f"The time stamps break {count(self._breaks, 'time')}{where}: {missing} are missing "
            "there, and nothing is put in place."
        ]

    def __iter__(self) -> Iterator[Run]:
        looks = {channel.name: FrozenBlocks() for channel in self.channels}
        for values, breaks in itertools.chain([self._next], self._rows):
            for channel in self.channels:
                samples = values[channel.name] * channel.factor
                finite = np.isfinite(samples)
                if why := why_too_large(samples if finite.all() else samples[finite]):
                    raise RecordingError(
                        f"{self.name}: channel {channel.name} cannot be analysed: {why}."
                    )
                still = looks[channel.name](values[channel.name])
                self._missing[channel.name] += int(np.count_nonzero(~finite))
                self._frozen[channel.name] += int(np.count_nonzero(still))
                yield from _runs(channel.name, samples, finite & ~still, breaks)

    def _read(self, blocks: Iterator) -> Iterator[Table]:
        for block in blocks:
            yield block.table
            self._progress(block.read, block.whole)

    def _checked(self, first: Table) -> Iterator[tuple[dict[str, np.ndarray], tuple[int, ...]]]:
        """Columns of the channels, and where in them a gap ends."""
        held = None
        for table, following in itertools.pairwise(itertools.chain([first], self._tables, [None])):
            assert table is not None
            self._findings |= dict.fromkeys(table.findings)
            columns = self._columns(table)
            if held is not None:
                columns = {
                    name: np.concatenate([held[name], column]) for name, column in columns.items()
                }
            size = next(iter(columns.values())).size
            known = size
            if following is not None and self._stamps is not None:
                if size < _FEWEST:
                    held = columns
                    continue
                # Whether a step there is a gap is told by the samples to come.
                known = size - CATCH_UP
            known, breaks = self._judge(replace(table, columns=columns), known)
            held = {name: column[known:] for name, column in columns.items()}
            yield (
                {name: self._units[name].read(columns[name][:known]) for name in self._asked},
                breaks,
            )

    def _columns(self, table: Table) -> dict[str, np.ndarray]:
        size = max(column.size for column in table.columns.values())
        # A column without a value in all of a block is not told from none.
        columns = {name: table.columns.get(name, np.full(size, np.nan)) for name in self._asked}
        if self._stamps is not None:
            if self._stamps not in table.columns:
                raise RecordingError(
                    f"{self.name}: from sample {self._samples} on there are no time stamps."
                )
            columns[self._stamps] = table.columns[self._stamps]
        check_lengths(self._path, replace(table, columns=columns), list(columns))
        if self._stamps is None:
            return columns
        again = copies(columns[self._stamps], (columns[name] for name in self._asked))
        self._copies += int(again.sum())
        self._rows_read += again.size
        return {name: column[~again] for name, column in columns.items()}

    def _judge(self, table: Table, known: int) -> tuple[int, tuple[int, ...]]:
        """How many of the samples are known to the end, and where among them a gap ends."""
        if self._stamp_unit and self._stamps is not None:
            # As the first block was understood, so are all.
            table = replace(table, units={**table.units, self._stamps: self._stamp_unit})
        clock = clock_of(self._path, table, self._stamps, self._given_hz, known)
        self._stamp_unit = clock.unit
        known, breaks = clock.known or known, clock.breaks
        if clock.wrong and not self._wrong:
            self._off_s = clock.off_s
        self._wrong += [self._samples + at for at in clock.wrong]
        # Gaps and wrong stamps are told of all blocks together.
        wrong = about_wrong(clock.wrong, clock.off_s)
        said = tuple(
            each
            for each in clock.findings
            if not each.startswith("The time stamps have") and each not in wrong
        )
        if said:
            self._doubts.append((self._samples, said))
        self._judged += 1
        self._breaks += len(breaks)
        self._gaps += [(self._samples + at, long_s, lost) for at, long_s, lost in clock.gaps]
        self._samples += known
        self._seconds += known / clock.rate_hz
        self._lost += known * clock.lost
        return known, breaks

    def _first_look(
        self,
        values: dict[str, np.ndarray],
        breaks: tuple[int, ...],
        channels: Sequence[str] | None,
    ) -> tuple[Channel, ...]:
        """The channels without their samples, with what the first of these tell."""
        # What is constant so far is no sensor that a unit would help.
        kept, known = [], {}
        useless_for: dict[str, list[str]] = {}
        for name in self._asked:
            column, unit = values[name], self._units[name]
            still = frozen(column)
            stretches = split(
                np.isfinite(column) & ~still, tuple(at for at in breaks if at < column.size)
            )
            seen = usable(column, stretches)
            wanted = bool(channels) or len(self._asked) == 1
            # Of few samples chance might make a counter.
            enough = seen.size >= FEWEST_SAMPLES
            varies = bool(enough and seen.min() < seen.max())
            why = enough and (
                why_state(name, seen, unit, wanted)
                or (varies and (why_useless(seen) or why_wraps(seen, unit.name)))
            )
            if why:
                if wanted:
                    raise RecordingError(f"{self.name}: channel {name} cannot be analysed: {why}.")
                useless_for.setdefault(why, []).append(name)
                continue
            about = ()
            if seen.size and seen.min() < seen.max():
                known[name] = unit
            if enough and name in known:
                said = about_samples(column, still, stretches, unit.name, self.rate_hz)
                # Of all samples those that are missing or frozen are counted.
                about = tuple(
                    f"In the first {column.size} samples: {each}"
                    for each in said
                    if not each.startswith(("Left out as missing", "Left out as frozen"))
                )
            kept.append(channel_of(name, column, unit, stretches, about))
        if not kept:
            raise RecordingError(f"{self.name} has no channel to analyse.")
        self._findings |= dict.fromkeys(left_out(useless_for))
        self._findings |= dict.fromkeys(about_units(known, self._first, self._unit))
        if all(usable(channel.samples, channel.stretches).size for channel in kept):
            self._findings |= dict.fromkeys(about_gravity(kept))
            self._findings |= {
                f"In the first samples: {each}": None for each in about_mistakes(kept, self.rate_hz)
            }
        return tuple(replace(each, samples=np.empty(0), stretches=()) for each in kept)


def read_in_blocks(
    path: str | os.PathLike[str],
    *,
    rate_hz: float | None = None,
    channels: Sequence[str] | None = None,
    unit: str | None = None,
    topic: str | None = None,
    block_samples: int = 2**20,
    progress: Progress = lambda read, whole: None,
) -> Blocks:
    """Read a recording in blocks of about `block_samples`, by the rules of `load`.

    CSV, NPY, NPZ, HDF5 and Parquet need no more memory than a few blocks. Other formats are read
    as a whole first. What a block tells of its time stamps and values is found block by block, and
    what takes all samples at once (saturation, repeats, code width) from the first of them.

    **Arguments:** as for `load`; `progress` is called after each block with how much of the file
    is read, and of how much.

    **Raises** `RecordingError` as `load` does, also while the runs come.

    ```python
    for run in read_in_blocks("gyro.csv", rate_hz=200.0, unit="deg/s"):
        run.channel, run.samples, run.ends
    ```
    """
    if rate_hz is not None:
        check_rate(rate_hz, "the rate given")
    if block_samples < CATCH_UP:
        raise RecordingError(f"Blocks need at least {CATCH_UP} samples; got {block_samples}.")
    if isinstance(channels, str):
        channels = (channels,)
    return Blocks(Path(path), channels, rate_hz, unit, topic, block_samples, progress)


def _runs(
    channel: str,
    samples: Float64[np.ndarray, " samples"],
    good: Bool[np.ndarray, " samples"],
    breaks: tuple[int, ...],
) -> Iterator[Run]:
    changes = () if good.all() else np.flatnonzero(np.diff(good)) + 1
    cuts = {*breaks, *map(int, changes)}
    for start, stop in itertools.pairwise((0, *sorted(cuts), samples.size)):
        used = stop if good[start:stop].all() else start
        ends = stop in cuts or used < stop
        if ends or used > start:
            yield Run(channel, samples[start:used], ends)
