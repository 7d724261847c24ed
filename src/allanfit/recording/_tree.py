"""Files of arrays in groups, as HDF5 and MAT-files are: which arrays are a recording's columns.

A topic is a group, and stands for all that is in it or below, or a single array. Rates and time
stamps hold for the group they are in and for the groups below.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ._csv_header import BRACKETED
from ._lateness import SHORTEST_STRETCH
from ._names import is_rate, is_unit, units_by_channel
from ._recording import RecordingError, Table
from ._temperature import is_temperature
from ._timestamps import is_time
from ._topics import Topic, topic_of

Place = tuple[str, ...]
"""Names from the root down."""


@dataclass(frozen=True)
class Leaf:
    """An array, a number or a text, and where it is."""

    place: Place
    values: np.ndarray | str
    unit: str = ""

    @property
    def name(self) -> str:
        """Its own name, without a unit in brackets."""
        return BRACKETED.sub(r"\1", self.place[-1])

    @property
    def group(self) -> Place:
        """The group that it is in."""
        return self.place[:-1]

    @property
    def array(self) -> np.ndarray:
        """Its numbers, without axes of length 1; empty for a text."""
        return np.empty(0) if isinstance(self.values, str) else np.squeeze(self.values)

    @property
    def length(self) -> int:
        """Samples, as the longer of two axes is time; 0 if it is no series of numbers."""
        array = self.array
        series = array.dtype.kind in "iuf" and array.ndim in (1, 2)
        return max(array.shape) if series and max(array.shape) >= SHORTEST_STRETCH else 0

    @property
    def is_clock(self) -> bool:
        """Whether it holds time stamps."""
        return self.array.ndim == 1 and self.length > 0 and is_time(self.name, self.unit)


@dataclass(frozen=True)
class Tree:
    """All of a file that could be a recording."""

    leaves: tuple[Leaf, ...]
    findings: tuple[str, ...]
    """What is in the file and cannot be read."""


def tree_table(path: Path, tree: Tree, topic: str | None, whole: Tree | None = None) -> Table:
    """The columns in `topic`, or in the whole file.

    A matrix has a column for each channel, and three are called x, y and z. Where `tree` has some
    rows of a file alone, `whole` has the shapes of all of it, with any values.

    **Raises** `RecordingError` when there are none, or arrays that do not belong together.
    """
    leaves = tree.leaves
    findings = _about_lengths(path, whole or tree, topic)
    inside, above = _parted(leaves, topic)
    series = _series(inside)
    clocks = _clocks(inside, above)
    _check_one_clock(path, (whole or tree).leaves, clocks)
    length = max(leaf.length for leaf in series)
    clock = next((leaf for leaf in clocks if leaf.length == length), None)
    columns = {clock.name: clock.array} if clock else {}
    units = {clock.name: _unit(clock)} if clock else {}
    stated = _stated_units(path, leaves)
    top = _common([leaf.group for leaf in series])
    for leaf in series:
        name = "_".join((*leaf.group[len(top) :], leaf.name))
        for column, values in _split(name, leaf.array).items():
            if column in columns:
                raise RecordingError(f"{path.name} has two arrays named {column}: rename one.")
            columns[column] = values
            units[column] = _unit(leaf) or stated.get(column, "") or stated.get(name, "")
    rates = _rates((*inside, *above))
    if len(rates) > 1:
        told = " and ".join(f"{rate:g} Hz" for rate in sorted(rates))
        findings += (f"The file states several sampling rates, {told}, and none is used.",)
    rate_hz = rates.pop() if len(rates) == 1 else None
    return Table(columns, {name: unit for name, unit in units.items() if unit}, rate_hz, findings)


def longest(tree: Tree, topic: str | None) -> int:
    """Samples of the longest channel in `topic`, 0 without one."""
    return max((leaf.length for leaf in _series(_parted(tree.leaves, topic)[0])), default=0)


def tree_topics(path: Path, tree: Tree) -> tuple[Topic, ...]:
    """The whole file where its arrays belong together, or else its parts.

    **Raises** `RecordingError` when nothing in it is a series of numbers.
    """
    try:
        return (topic_of(tree_table(path, tree, None)),)
    except RecordingError:
        parts = _parts(tree.leaves)
        if len(parts) < 2:
            raise
    names = map(_spelled, parts)
    return tuple(topic_of(tree_table(path, tree, name), name) for name in names)


def _place(topic: str | None) -> Place:
    return tuple(part for part in (topic or "").split("/") if part)


def _parted(leaves: Sequence[Leaf], topic: str | None) -> tuple[list[Leaf], list[Leaf]]:
    """What is in a topic, and what holds for it: all in the groups that it is in."""
    asked = _place(topic)
    inside = [leaf for leaf in leaves if leaf.place[: len(asked)] == asked]
    return inside, [leaf for leaf in leaves if leaf.group == asked[: len(leaf.group)]]


def _series(leaves: Sequence[Leaf]) -> list[Leaf]:
    return [leaf for leaf in leaves if leaf.length and not leaf.is_clock]


def _clocks(inside: list[Leaf], above: list[Leaf]) -> list[Leaf]:
    return [leaf for leaf in (*inside, *above) if leaf.is_clock]


def _about_lengths(path: Path, tree: Tree, topic: str | None) -> tuple[str, ...]:
    """What cannot be used of a tree; only the shapes of its arrays matter.

    **Raises** `RecordingError` when there is no channel, or some are longer than others.
    """
    leaves, findings = tree.leaves, tree.findings
    inside, above = _parted(leaves, topic)
    if _place(topic) and not inside:
        raise RecordingError(f"{path.name} has no topic {topic}; it has {_told(_parts(leaves))}.")
    for leaf in inside:
        if leaf.array.size > 1 and not leaf.length:
            findings += (
                f"The array {_spelled(leaf.place)} is left out: a channel is a series of real "
                f"numbers, and it has the shape {leaf.array.shape} of {leaf.array.dtype}.",
            )
    series = _series(inside)
    if not series:
        advice = "store each as an array of numbers"
        raise RecordingError(" ".join((f"{path.name} holds no channel: {advice}.", *findings)))
    # A temperature is allowed to be logged more rarely.
    lengths = {
        leaf.length for leaf in series if not is_temperature(leaf.name, leaf.unit, Table({}, {}))
    }
    clocks = _clocks(inside, above)
    differ = any(one.length != clocks[0].length for one in clocks if one.group != clocks[0].group)
    if len(lengths) > 1 or differ:
        _refuse_several(path, leaves)
    return findings + _about_clocks(series, clocks)


def _about_clocks(series: list[Leaf], clocks: list[Leaf]) -> tuple[str, ...]:
    """What is said of clocks that tell nothing of the channels, where no other does."""
    length = max(leaf.length for leaf in series)
    if any(clock.length == length for clock in clocks):
        return ()
    # A temperature may have a clock of its own beside it.
    timed = _common([leaf.group for leaf in series if leaf.length == length])
    return tuple(
        f"The time stamps {_spelled(clock.place)} have {clock.length} values and the channels "
        f"{length} samples: they are not used."
        for clock in clocks
        if clock.group == timed[: len(clock.group)]
    )


def _check_one_clock(path: Path, leaves: Sequence[Leaf], clocks: list[Leaf]) -> None:
    others = (one for one in clocks if one.group != clocks[0].group)
    if any(not np.array_equal(one.array, clocks[0].array) for one in others):
        _refuse_several(path, leaves)


def _refuse_several(path: Path, leaves: Sequence[Leaf]) -> None:
    parts = _parts(leaves)
    if len(parts) > 1:
        raise RecordingError(
            f"{path.name} holds arrays that were not sampled together: choose one of "
            f"{_told(parts)} with --topic."
        )


def _parts(leaves: Sequence[Leaf]) -> dict[Place, int]:
    """Groups of arrays of one length, or else single arrays, and their samples."""
    series = [leaf for leaf in leaves if leaf.length and not leaf.is_clock]
    parts = {}
    for group in dict.fromkeys(leaf.group for leaf in series):
        within = [leaf for leaf in series if leaf.group == group]
        if group and len({leaf.length for leaf in within}) == 1:
            parts[group] = within[0].length
        else:
            parts |= {leaf.place: leaf.length for leaf in within}
    return parts


def _told(parts: dict[Place, int]) -> str:
    told = (f"{_spelled(place)} ({length} samples)" for place, length in parts.items())
    return ", ".join(told) or "none"


def _spelled(place: Place) -> str:
    return "/".join(place)


def _common(groups: list[Place]) -> Place:
    """The innermost group that holds them all."""
    first, last = min(groups), max(groups)
    shared = 0
    while shared < min(len(first), len(last)) and first[shared] == last[shared]:
        shared += 1
    return first[:shared]


def _split(name: str, array: np.ndarray) -> dict[str, np.ndarray]:
    if array.ndim == 1:
        return {name: array}
    # A recording has more samples than channels, whichever way round it was saved.
    rows = array if array.shape[1] > array.shape[0] else array.T
    axes = "xyz" if len(rows) == 3 else [str(k) for k in range(1, len(rows) + 1)]
    return {
        f"{name}_{axis}": np.ascontiguousarray(row) for axis, row in zip(axes, rows, strict=True)
    }


def _unit(leaf: Leaf) -> str:
    bracketed = BRACKETED.fullmatch(leaf.place[-1])
    return (leaf.unit or (bracketed[2] if bracketed else "")).strip()


def _stated_units(path: Path, leaves: Sequence[Leaf]) -> dict[str, str]:
    """Units by channel from texts: a group `units` with one each, or an array `units` in JSON."""
    stated = {}
    for leaf in leaves:
        if not isinstance(leaf.values, str):
            continue
        if leaf.group and is_unit(leaf.group[-1]):
            stated[leaf.name] = leaf.values
        elif is_unit(leaf.name) and leaf.values.lstrip().startswith("{"):
            stated |= units_by_channel(path.name, leaf.values)
    return stated


def _rates(leaves: Sequence[Leaf]) -> set[float]:
    return {
        float(leaf.array)
        for leaf in leaves
        if leaf.array.ndim == 0 and leaf.array.dtype.kind in "iuf" and is_rate(leaf.name)
    }
