"""How a table in text is laid out: separators, the header, where the numbers begin."""

import csv
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from ._csv_digits import check_blanks, check_digits, has_decimal_comma, is_grouped, is_number
from ._csv_header import Header, named, nameless, read_header
from ._recording import RecordingError
from ._text_clock import is_clock, is_date

MISSING = ("", "NA", "N/A", "#N/A", "null", "NULL", "None")
_COMMENT = ("#", "%")
# Enough for any header and the first lines below it.
HEAD = 65_536
# As many lines tell how the table is laid out, and titles above it take fewer.
_TELLING = 100
# In so many lines and more noise does not rise from each to the next, by steps that differ by less
# than such a part of the mean one, or by less than two roundings.
_RISING, _EVEN = 20, 1e-3
# Beyond the nanoseconds of any calendar; and sums of such numbers overflow nothing.
_NO_TIME = 1e30


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
    findings: tuple[str, ...] = ()
    """What was skipped above them."""


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
    # The first line may be a header in words, and others below it titles.
    told = Counter(_separator(lines[k]) for k in filled[1 : 1 + _TELLING] or filled)
    separator = told.most_common(1)[0][0]
    rows = [_fields(lines[k], separator) for k in filled]
    start = _start(file, rows, separator != ",")
    check_digits(file, rows[start or 0 :], filled[start or 0 :], separator)
    if start is None:
        raise RecordingError(f"{file} holds no table of numbers.")
    first, fields = filled[start], rows[start]
    comma = separator != "," and any(
        has_decimal_comma(each) for row in rows[start:] for each in row
    )
    if separator == ",":
        check_blanks(f"{file}, line {first + 1}", lines[first], fields)
    if start > 0:
        header = read_header(file, rows[:start], filled[:start], fields)
    else:
        commented = _commented(lines[:first], separator)
        header = named(file, commented, len(fields))
        if len(commented) != len(fields) and not all(
            is_number(each, comma) or each in MISSING or is_clock(each) or is_date(each)
            for each in fields
        ):
            raise RecordingError(
                f"{file}, line {first + 1}: {lines[first]!r:.60} mixes numbers and text: give the "
                "file a header line."
            )
        unnamed = header.names[0] == nameless(1)
        if unnamed and _begins_with_clock(rows[start:][:_TELLING], comma):
            header = Header(
                ["time", *header.names[1:]],
                header.units,
                ("The first column has no name and rises evenly: it is taken for time stamps.",),
            )
    offset = 0
    for _ in range(first):
        offset = text.index(b"\n", offset) + 1
    return Layout(
        header.names,
        header.units,
        fields,
        separator,
        comma,
        offset,
        first + 1,
        header.findings,
    )


def _start(file: str, rows: list[list[str]], comma: bool) -> int | None:
    """Which row begins the numbers; None if there is no number.

    Titles and notes may hold numbers too, but have another form than most rows, and a line of
    words between.

    **Raises** `RecordingError` when what stands above may be a table by itself.
    """
    numbers = [tuple(is_number(field, comma) or is_grouped(field) for field in row) for row in rows]
    forms = Counter(form for form in numbers[-_TELLING:] if any(form))
    if not forms:
        return None
    usual = forms.most_common(1)[0][0]
    start = next(k for k, form in enumerate(numbers) if form == usual)
    while start > 0 and any(numbers[start - 1]):
        start -= 1
    if start > _TELLING or any(map(all, numbers[:start])):
        raise RecordingError(
            f"{file}: {start} lines stand above the numbers, the first {' '.join(rows[0])!r:.60}, "
            "and they are no titles alone: remove them or begin them with #."
        )
    return start


def _begins_with_clock(rows: list[list[str]], comma: bool) -> bool:
    """Whether the first of several columns counts time; in steps of one it may count samples."""
    stamps = [row[0].replace(",", ".") if comma else row[0] for row in rows]
    if (
        len(rows) < _RISING
        or len(rows[0]) < 2
        or not all(is_number(each, False) for each in stamps)
    ):
        return False
    digits, times = max(len(each.partition(".")[2]) for each in stamps), np.array(stamps, float)
    if not np.all(np.abs(times) < _NO_TIME):
        return False
    steps = np.diff(times)
    uneven = max(_EVEN * float(steps.mean()), 2.1 * 10.0**-digits)
    return bool(steps.min() > 0 and np.ptp(steps) < uneven and np.any(steps != 1))


def _separator(line: str) -> str:
    return next((mark for mark in "\t;," if mark in line), " ")


def _fields(line: str, separator: str) -> list[str]:
    if separator == " ":
        # A unit in brackets belongs to the name before it.
        fields = re.findall(r"[^\s\[(]+(?:\s{0,9}[\[(][^\])]{0,80}[\])])?", line)
    else:
        fields = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    return [field.strip().strip('"') for field in fields]


def _commented(above: list[str], separator: str) -> list[str]:
    """The fields of the last comment above the numbers, which often is a header."""
    comments = [line for line in above if line.lstrip().startswith(_COMMENT)]
    if not comments:
        return []
    return _fields(comments[-1].lstrip().lstrip("".join(_COMMENT)), separator)
