"""How a table in text is laid out: separators, the header, where the numbers begin."""

import csv
import re
from dataclasses import dataclass

from ._recording import RecordingError

MISSING = ("", "NA", "N/A", "#N/A", "null", "NULL", "None")
_COMMENT = ("#", "%")
BRACKETED = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]")
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_GROUPED = re.compile(
    r"[-+]?\d{1,3}"
    r"(?:(?:[ '\u00a0\u2009\u202f]\d{3})+(?:[.,]\d*)?|(?:,\d{3})+\.\d*|(?:\.\d{3})+,\d*)"
)
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:,\d{3})+")
# Enough for any header and the first lines below it.
HEAD = 65_536
_LONGEST_NAME = 1000


@dataclass(frozen=True)
class Layout:
    """How the text is to be cut into columns."""

    names: list[str]
    units: dict[str, str]
    first: list[str]
    """The fields of the first line of numbers."""
    separator: str
    """One character; a blank stands for any white space."""
    decimal_comma: bool
    body: int
    """Where in the text the numbers begin, as an offset in bytes."""
    line: int
    """The number of the line there, counted from 1."""


def _decode(line: bytes) -> str:
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin-1")


def find_layout(file: str, text: bytes) -> Layout:
    """How to cut the text of a file, from its first lines.

    **Raises** `RecordingError` when they hold no table of numbers, with the line in the way.
    """
    lines = [_decode(line) for line in text[:HEAD].split(b"\n")]
    if len(text) > HEAD:
        # The last one is cut in two.
        lines = lines[:-1]
    filled = [
        k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(_COMMENT)
    ]
    if len(text) > HEAD and len(filled) < 2:
        raise RecordingError(
            f"{file} has lines of more than {HEAD // 1024} kB: write one sample of each channel "
            "in a line, or choose another format for so many channels."
        )
    if not filled:
        raise RecordingError(f"{file} holds no table of numbers.")
    # The first line may be a header in words, the second is one of numbers in any good file.
    separator = _separator(lines[filled[:2][-1]])
    rows = [_fields(lines[k], separator) for k in filled]
    _check_digits(file, rows, filled, separator)
    comma = separator != "," and any(
        _DECIMAL_COMMA.fullmatch(field) for row in rows for field in row
    )
    start = next(
        (at for at, row in enumerate(rows) if any(is_number(field, comma) for field in row)), None
    )
    if start is None:
        raise RecordingError(f"{file} holds no table of numbers.")
    first, fields = filled[start], rows[start]
    if start > 1:
        raise RecordingError(
            f"{file}: {start} lines stand above the numbers, the first {lines[filled[0]]!r:.60}, "
            "and only one header line may: remove the others or begin them with #."
        )
    _check_numbers(f"{file}, line {first + 1}", lines[first], separator)
    if start == 1:
        header = rows[0]
        _check_header(f"{file}, line {filled[0] + 1}", header, fields)
    else:
        header = _commented(lines[:first], separator)
        if not all(is_number(field, comma) or field in MISSING for field in fields):
            raise RecordingError(
                f"{file}, line {first + 1}: {lines[first]!r:.60} mixes numbers and text: give the "
                "file a header line."
            )
    names, units = _names(file, header, len(fields))
    offset = 0
    for _ in range(first):
        offset = text.index(b"\n", offset) + 1
    return Layout(names, units, fields, separator, comma, offset, first + 1)


def _separator(line: str) -> str:
    return next((mark for mark in "\t;," if mark in line), " ")


def _fields(line: str, separator: str) -> list[str]:
    if separator == " ":
        # A unit in brackets belongs to the name before it.
        fields = re.findall(r"[^\s\[(]+(?:\s{0,9}[\[(][^\])]{0,80}[\])])?", line)
    else:
        fields = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    return [field.strip().strip('"') for field in fields]


def is_number(field: str, decimal_comma: bool) -> bool:
    """Whether a field of the text is a number."""
    try:
        float(field.replace(",", ".") if decimal_comma else field)
    except ValueError:
        return False
    return True


def _check_numbers(where: str, line: str, separator: str) -> None:
    fields = _fields(line, separator)
    if separator == "," and any(re.fullmatch(r"[-+\d.]+\s+[-+\d.]+", field) for field in fields):
        raise RecordingError(
            f"{where}: {line!r:.60} mixes commas and blanks: write decimal points, or put "
            "semicolons between the columns."
        )


def _check_digits(file: str, rows: list[list[str]], lines: list[int], separator: str) -> None:
    """Refuse numbers whose commas, blanks or points do not divide columns from each other.

    A lone comma is a decimal one between other separators; between quotation marks it is not.
    """
    for line, row in zip(lines, rows, strict=True):
        for field in row:
            if _GROUPED.fullmatch(field) or (separator == "," and _THOUSANDS.fullmatch(field)):
                raise RecordingError(
                    f"{file}, line {line + 1}: {field!r:.40} has separators of thousands: write "
                    "numbers without them."
                )
    if separator != "," or any("." in field for row in rows for field in row):
        return
    for line, row in zip(lines, rows, strict=True):
        # No integer is written as -0; what is below 1 often begins so.
        if len(row) % 2 == 0 and any(field in ("-0", "+0") for field in row[::2]):
            raise RecordingError(
                f"{file}, line {line + 1}: {','.join(row)!r:.60} looks like decimal commas between "
                "commas: write decimal points, or put semicolons between the columns."
            )


def _check_header(where: str, header: list[str], fields: list[str]) -> None:
    if len(header) in (len(fields), len(fields) - (not fields[-1])):
        return
    hint = ""
    if len(fields) == 2 * len(header):
        hint = " (for decimal commas, put semicolons between the columns)"
    raise RecordingError(
        f"{where}: {' '.join(header)!r:.60} has {len(header)} fields and the numbers below it "
        f"{len(fields)}: correct it or begin it with #{hint}."
    )


def _commented(above: list[str], separator: str) -> list[str]:
    """The fields of the last comment above the numbers, which often is a header."""
    comments = [line for line in above if line.lstrip().startswith(_COMMENT)]
    if not comments:
        return []
    return _fields(comments[-1].lstrip().lstrip("".join(_COMMENT)), separator)


def _names(file: str, header: list[str], columns: int) -> tuple[list[str], dict[str, str]]:
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
    return names, units


def nameless(position: int) -> str:
    """What a column without a name is called, counted from 1."""
    return f"channel_{position}"
