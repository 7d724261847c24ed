"""What a recording is, once it is read and checked."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64

from ._unit_endings import unit_in_name


class RecordingError(ValueError):
    """A recording cannot be used; the message says why and what to do, in one sentence."""


class NoRateError(RecordingError):
    """Neither the file nor the user tells the rate."""


@dataclass(frozen=True)
class Channel:
    """One sensor axis, in SI units, with what the checks found in it."""

    name: str
    """Its name in the file."""
    unit: str
    """The unit the user gave, such as `deg/s`, `g` or `counts`; empty when none was given."""
    factor: float
    """One such unit in SI; 1 for a unit that is neither an angular rate nor an acceleration."""
    si_unit: str
    """`rad/s`, `m/s^2`, or the given unit when it is neither."""
    kind: str
    """`gyro`, `accelerometer` or `other`, as the unit says; `temperature` beside the channels."""
    samples: Float64[np.ndarray, " samples"]
    """All samples in SI, those outside `stretches` too."""
    stretches: tuple[tuple[int, int], ...]
    """`[start, stop)` of each run of good samples (finite, not frozen) without a gap, in order."""
    findings: tuple[str, ...]
    """One plain sentence each; empty for healthy samples."""


@dataclass(frozen=True)
class Recording:
    """Channels sampled together at one rate."""

    name: str
    """The name of the file."""
    rate_hz: float
    """Samples a second."""
    channels: tuple[Channel, ...]
    """What is to be analysed, never empty."""
    auxiliary: tuple[Channel, ...]
    """What may explain the channels: temperatures in degC, and magnetometers in their own units."""
    findings: tuple[str, ...]
    """About the file and its time stamps, one plain sentence each."""
    checksum: str
    """SHA-256 of the samples and SI units of the channels, in order, as float64, then of the
    temperatures beside them: of all that a result depends on, and nothing else of the file."""
    lost: float = 0.0
    """Share of the samples that, by the time stamps, were lost, where some were a few at a time."""
    losses: tuple[tuple[int, int], ...] = ()
    """Index of the first sample after each of these losses, and how many were lost."""
    lost_deviation: float = 0.0
    """Standard deviation of the logarithm of `lost`: one event may lose many."""


@dataclass(frozen=True)
class Table:
    """A file as it was read: columns of numbers, not yet told apart into time and channels."""

    columns: dict[str, np.ndarray]
    """1-D arrays of integers or floats by name; time stamps among them."""
    units: dict[str, str]
    """The unit of a column, where the file gives one."""
    rate_hz: float | None = None
    """Samples a second, where the file gives it."""
    findings: tuple[str, ...] = field(default=())
    """What was left out in reading."""

    def unit(self, name: str) -> str:
        """The unit of a column: as the file gives it, or else as its name ends, or else ""."""
        return self.units.get(name) or unit_in_name(name)


@dataclass(frozen=True)
class Block:
    """The next rows of a table that is read in pieces."""

    table: Table
    read: int
    """How much of the file is read up to the end of this block, of `whole`."""
    whole: int


Progress = Callable[[int, int], None]
"""To be called now and then with how much of a file is read, and of how much."""


def table_blocks(table: Table, samples: int) -> Iterator[Block]:
    """A table, perhaps one mapped from a file, in blocks of so many samples."""
    rows = max((column.size for column in table.columns.values()), default=0)
    for start in range(0, max(rows, 1), samples):
        stop = min(start + samples, rows)
        columns = {name: column[start:stop] for name, column in table.columns.items()}
        yield Block(replace(table, columns=columns), stop, rows)
