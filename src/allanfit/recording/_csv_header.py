"""What stands above the numbers of a table in text: titles, names, units."""

import re
from dataclasses import dataclass

from ._recording import RecordingError
from ._timestamps import is_time
from ._units import parse_unit
from ._wording import count

BRACKETED = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]")
_LONGEST_NAME = 1000


@dataclass(frozen=True)
class Header:
    """Names and units of columns."""

    names: list[str]
    units: dict[str, str]
    findings: tuple[str, ...] = ()
    """What was skipped."""


def read_header(file: str, rows: list[list[str]], lines: list[int], first: list[str]) -> Header:
    """The header in `rows`, which stand in `lines` (counted from 0) above the `first` numbers.

    It is the last of them, or the last but one where either of the two is a row of units.

    **Raises** `RecordingError` when it does not fit the numbers.
    """
    at, units = len(rows) - 1, None
    if at > 0 and len(rows[at]) == len(rows[at - 1]):
        upper, lower = _is_units(rows[at - 1]), _is_units(rows[at])
        if upper != lower:
            units = at - upper
            at -= lower
    _check_length(f"{file}, line {lines[at] + 1}", rows[at], first)
    header = named(file, rows[at], len(first))
    below = {} if units is None else dict(zip(header.names, map(_bare, rows[units]), strict=False))
    skipped = [" ".join(filter(None, row)) for k, row in enumerate(rows) if k not in (at, units)]
    skipped = list(filter(None, skipped))
    findings = ()
    if skipped:
        findings = (
            f"Skipped above the header: {count(len(skipped), 'line')}, the first "
            f"{skipped[0]!r:.60}.",
        )
    return Header(header.names, below | header.units, findings)


def _bare(unit: str) -> str:
    return unit.strip("[]() ")


def _is_units(row: list[str]) -> bool:
    """Whether a row holds units and nothing else."""
    fields = [_bare(field) for field in row]
    return any(field not in ("", "-") for field in fields) and all(map(_is_unit, fields))


def _is_unit(field: str) -> bool:
    try:
        parse_unit(field)
    except RecordingError:
        return is_time("", field)
    return True


def _check_length(where: str, header: list[str], fields: list[str]) -> None:
    if len(header) in (len(fields), len(fields) - (not fields[-1])):
        return
    hint = ""
    if len(fields) == 2 * len(header):
        hint = " (for decimal commas, put semicolons between the columns)"
    raise RecordingError(
        f"{where}: {' '.join(header)!r:.60} has {len(header)} fields and the numbers below it "
        f"{len(fields)}: correct it or begin it with #{hint}."
    )


def named(file: str, header: list[str], columns: int) -> Header:
    """Names of `columns` columns and the units that stand in brackets behind them."""
    if header and len(header) == columns - 1:
        # Lines that end in a separator.
        header = [*header, ""]
    if len(header) != columns:
        header = ["data"] if columns == 1 else [""] * columns
    names, units = [], {}
    for position, field in enumerate(header, start=1):
        if len(field) > _LONGEST_NAME:
            raise RecordingError(
                f"{file}: the name of column {position} has {len(field)} characters: shorten it."
            )
        bracketed = BRACKETED.fullmatch(field)
        name = (bracketed[1] if bracketed else field) or nameless(position)
        if name in names:
            raise RecordingError(f"{file} has two columns named {name}: rename one.")
        names.append(name)
        if bracketed:
            units[name] = bracketed[2].strip()
    return Header(names, units)


def nameless(position: int) -> str:
    """What a column without a name is called, counted from 1."""
    return f"channel_{position}"
