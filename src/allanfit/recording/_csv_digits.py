"""Numbers in text whose commas, blanks or points may divide thousands, decimals or columns."""

import re

from ._recording import RecordingError

_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
# Two marks in a number divide thousands, and so does one before a decimal mark of another kind.
_GROUPED = re.compile(
    r"[-+]?\d{1,3}"
    r"(?:(?:[ '\u00a0\u2009\u202f]\d{3})+(?:[.,]\d*)?|(?:,\d{3})+\.\d*|(?:\.\d{3})+,\d*"
    r"|(?:,\d{3}){2,}|(?:\.\d{3}){2,})"
)
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:,\d{3})+")
_THREE_DIGITS = re.compile(r"[-+]?[1-9]\d{0,2}[.,]\d{3}")
_SMALL_INTEGER = re.compile(r"[-+]?\d{1,3}")
# As many of each kind in a column are no chance.
_ENOUGH = 20


def is_number(field: str, decimal_comma: bool) -> bool:
    """Whether a field of the text is a number."""
    try:
        float(field.replace(",", ".") if decimal_comma else field)
    except ValueError:
        return False
    return True


def has_decimal_comma(field: str) -> bool:
    """Whether a field is a number with a decimal comma, where commas divide nothing else."""
    return _DECIMAL_COMMA.fullmatch(field) is not None


def is_grouped(field: str) -> bool:
    """Whether a field is a number whose thousands are surely divided."""
    return _GROUPED.fullmatch(field) is not None


def grouped(file: str, line: int, field: str) -> RecordingError:
    """The error for a number with separators of thousands."""
    return RecordingError(
        f"{file}, line {line}: {field!r:.40} has separators of thousands: write numbers without "
        "them."
    )


def check_digits(file: str, rows: list[list[str]], lines: list[int], separator: str) -> None:
    """Refuse numbers whose commas, blanks or points do not divide columns from each other.

    A lone comma is a decimal one between other separators; between quotation marks it is not.

    **Raises** `RecordingError` with the first of `lines`, counted from 0, that shows it.
    """
    for line, row in zip(lines, rows, strict=True):
        for field in row:
            if is_grouped(field) or (separator == "," and _THOUSANDS.fullmatch(field)):
                raise grouped(file, line + 1, field)
    for column in range(max(map(len, rows))):
        fields = [row[column] if column < len(row) else "" for row in rows]
        at = [k for k, field in enumerate(fields) if _THREE_DIGITS.fullmatch(field)]
        whole = sum(_SMALL_INTEGER.fullmatch(field) is not None for field in fields)
        # Decimals that end in a zero would be printed as fewer, or else whole numbers with three.
        if min(len(at), whole) >= _ENOUGH and len(at) + whole == sum(map(bool, fields)):
            raise grouped(file, lines[at[0]] + 1, fields[at[0]])
    if separator != "," or any("." in field for row in rows for field in row):
        return
    for line, row in zip(lines, rows, strict=True):
        # No integer is written as -0; what is below 1 often begins so.
        if len(row) % 2 == 0 and any(field in ("-0", "+0") for field in row[::2]):
            raise RecordingError(
                f"{file}, line {line + 1}: {','.join(row)!r:.60} looks like decimal commas between "
                "commas: write decimal points, or put semicolons between the columns."
            )


def check_blanks(where: str, line: str, fields: list[str]) -> None:
    """Refuse a line that has blanks between numbers, and commas that may be decimal ones."""
    if any(re.fullmatch(r"[-+\d.]+\s+[-+\d.]+", field) for field in fields):
        raise RecordingError(
            f"{where}: {line!r:.60} mixes commas and blanks: write decimal points, or put "
            "semicolons between the columns."
        )
