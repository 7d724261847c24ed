"""Tables in text: columns of numbers below an optional header."""

import csv
import gzip
import io
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import polars as pl

from ._files import refuse_bomb
from ._recording import Block, RecordingError, Table
from ._timestamps import is_time
from ._wording import count

_MISSING = ("", "NA", "N/A", "#N/A", "null", "NULL", "None")
_COMMENT = ("#", "%")
BRACKETED = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]")
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_GROUPED = re.compile(
    r"[-+]?\d{1,3}"
    r"(?:(?:[ '\u00a0\u2009\u202f]\d{3})+(?:[.,]\d*)?|(?:,\d{3})+\.\d*|(?:\.\d{3})+,\d*)"
)
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:,\d{3})+")
# The parser panics on some quotation marks, which is no Exception to Python.
_PARSER = (pl.exceptions.PolarsError, pl.exceptions.PanicException)
# Enough for any header and the first lines below it.
_HEAD = 65_536
_LONGEST_NAME = 1000
_LONGEST_LINE = 1 << 24
_CHUNK = 1 << 24
# Integers of more digits lose some as floats; time stamps in ns since 1970 have 19.
_EXACT_DIGITS = 15


@dataclass(frozen=True)
class _Layout:
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


def read_csv(path: Path) -> Table:
    """Columns of numbers from `.csv`, `.txt` or either of them gzipped.

    **Raises** `RecordingError` when the file is no such table, with the line that is in the way.
    """
    with path.open("rb") as file, _unpacked(path, file) as stream:
        text = _begun(path.name, _whole(path, stream))
    return _table(path.name, text, _layout(path.name, text))


def csv_blocks(path: Path, samples: int) -> Iterator[Block]:
    """The same line by line, in blocks of about `samples` lines."""
    size = path.stat().st_size
    with path.open("rb") as file, _unpacked(path, file) as stream:
        head = stream.read(4 * _HEAD)
        length = max(len(head) // max(head.count(b"\n"), 1) * samples, len(head))
        layout, rest, ended = None, head, False
        while not ended:
            text = stream.read(length)
            ended = not text
            if text.endswith(b"\r"):
                text += stream.read(1)
            text = rest + text
            text = (_begun if layout is None else _plain)(path.name, text)
            cut = len(text) if ended else text.rfind(b"\n") + 1
            if not cut and len(text) > _LONGEST_LINE:
                raise RecordingError(f"{path.name} holds no table of numbers: a line has no end.")
            text, rest = text[:cut], text[cut:]
            if layout is None and cut:
                layout = _layout(path.name, text)
            if layout is not None and text[layout.body :].strip():
                yield Block(_table(path.name, text, layout), file.tell(), size)
            if layout is not None:
                layout = replace(layout, body=0, line=layout.line + text.count(b"\n"))


def _table(file: str, text: bytes, layout: _Layout) -> Table:
    frame = _parse(file, _body(text, layout), layout)
    columns, findings = {}, ()
    for position, (name, column) in enumerate(zip(layout.names, frame, strict=True), start=1):
        empty = column.null_count() == column.len()
        if column.dtype == pl.String:
            findings += (f"The column {name} holds text and is left out.",)
        # A nameless column without a value comes of lines that end in a separator.
        elif not (empty and name == _nameless(position)):
            columns[name] = column.to_numpy()
    return Table(columns, layout.units, findings=findings)


@contextmanager
def _unpacked(path: Path, file: io.BufferedIOBase) -> Iterator[io.BufferedIOBase]:
    """What is in the file, unzipped where it is a .gz."""
    if path.suffix != ".gz":
        yield file
        return
    try:
        with gzip.GzipFile(fileobj=file) as stream:
            yield stream
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise RecordingError(
            f"{path.name} is not a complete gzip file: it may be cut off or of another kind."
        ) from error


def _whole(path: Path, stream: io.BufferedIOBase) -> bytes:
    text = io.BytesIO()
    while chunk := stream.read(_CHUNK):
        text.write(chunk)
        if path.suffix == ".gz":
            refuse_bomb(path, text.tell())
    return text.getvalue()


def _begun(file: str, text: bytes) -> bytes:
    """The beginning of a table, or all of it."""
    text = text.removeprefix(b"\xef\xbb\xbf")
    if not text.strip():
        raise RecordingError(f"{file} is empty.")
    return _plain(file, text)


def _plain(file: str, text: bytes) -> bytes:
    """The text with line feeds alone at the ends of its lines."""
    if b"\0" in text:
        raise RecordingError(
            f"{file} is not plain text: a spreadsheet has to be saved as CSV in UTF-8."
        )
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return text


def _decode(line: bytes) -> str:
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin-1")


def _layout(file: str, text: bytes) -> _Layout:
    lines = [_decode(line) for line in text[:_HEAD].split(b"\n")]
    if len(text) > _HEAD:
        # The last one is cut in two.
        lines = lines[:-1]
    filled = [
        k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith(_COMMENT)
    ]
    if len(text) > _HEAD and len(filled) < 2:
        raise RecordingError(
            f"{file} has lines of more than {_HEAD // 1024} kB: write one sample of each channel "
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
        (at for at, row in enumerate(rows) if any(_is_number(field, comma) for field in row)), None
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
        if not all(_is_number(field, comma) or field in _MISSING for field in fields):
            raise RecordingError(
                f"{file}, line {first + 1}: {lines[first]!r:.60} mixes numbers and text: give the "
                "file a header line."
            )
    names, units = _names(file, header, len(fields))
    offset = 0
    for _ in range(first):
        offset = text.index(b"\n", offset) + 1
    return _Layout(names, units, fields, separator, comma, offset, first + 1)


def _separator(line: str) -> str:
    return next((mark for mark in "\t;," if mark in line), " ")


def _fields(line: str, separator: str) -> list[str]:
    if separator == " ":
        # A unit in brackets belongs to the name before it.
        fields = re.findall(r"[^\s\[(]+(?:\s{0,9}[\[(][^\])]{0,80}[\])])?", line)
    else:
        fields = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    return [field.strip().strip('"') for field in fields]


def _is_number(field: str, decimal_comma: bool) -> bool:
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
        name = (bracketed[1] if bracketed else field) or _nameless(position)
        if name in names:
            raise RecordingError(f"{file} has two columns named {name}: rename one.")
        names.append(name)
        if bracketed:
            units[name] = bracketed[2].strip()
    return names, units


def _nameless(position: int) -> str:
    return f"channel_{position}"


def _body(text: bytes, layout: _Layout) -> bytes:
    body = text[layout.body :]
    if layout.separator == " ":
        body = re.sub(rb"[ \t]+", b" ", body)
        body = re.sub(rb"(?m)^ | $", b"", body)
    elif b" " in body:
        # White space around a field makes it text to the parser.
        mark = re.escape(layout.separator.encode())
        body = re.sub(rb"(?m)(?<! ) +(?=%b|$)|(?<=%b) +|^ +" % (mark, mark), b"", body)
    if b"\n\n" in body:
        # A blank line is no sample.
        body = re.sub(rb"\n\n+", b"\n", body)
    return body


def _parse(file: str, body: bytes, layout: _Layout) -> pl.DataFrame:
    def read(types: list[type]) -> pl.DataFrame:
        return pl.read_csv(
            body,
            has_header=False,
            schema={str(k): kind for k, kind in enumerate(types)},
            separator=layout.separator,
            decimal_comma=layout.decimal_comma,
            null_values=list(_MISSING),
            comment_prefix="#",
            encoding="utf8-lossy",
        )

    types = [
        _type(name, field, layout.decimal_comma)
        for name, field in zip(layout.names, layout.first, strict=True)
    ]
    # On a mark at the very end the parser panics, and says so on its own.
    if body.count(b'"') % 2:
        raise _ragged(file, body, layout)
    try:
        frame = read(types)
    except _PARSER:
        # Once more as text, now only to say where the obstacle is.
        try:
            frame = read([pl.String for _ in types])
        except _PARSER as error:
            raise _ragged(file, body, layout) from error
    if 0 < frame.to_series(-1).null_count() < frame.height:
        _refuse_short(file, body, layout)
    for position, name in enumerate(layout.names):
        column = frame.to_series(position)
        if column.dtype == pl.String:
            text = column.str.replace(",", ".") if layout.decimal_comma else column
            failed = (
                text.cast(pl.Float64, strict=False).is_null() & column.is_not_null()
            ).to_numpy()
            # A word among numbers is an obstacle, a column of words is only left out.
            if failed.any() and (types[position] != pl.String or np.mean(failed) < 0.5):
                row = int(np.argmax(failed))
                raise RecordingError(
                    f"{file}, line {layout.line + row}, column {name}: "
                    f"{column[row].strip()[:40]!r} is not a number."
                )
            if not failed.any():
                # Integers too long to be exact, which floats hold as well as they can.
                frame = frame.with_columns(text.cast(pl.Float64))
    return frame


def _ragged(file: str, body: bytes, layout: _Layout) -> RecordingError:
    for line, found in _lengths(body, layout):
        if found > len(layout.names):
            return _other_length(file, line, found, layout)
    return RecordingError(f"{file} has a quotation mark that is not closed.")


def _refuse_short(file: str, body: bytes, layout: _Layout) -> None:
    # Which of its numbers a short line lacks is not known; a logger that was stopped leaves one.
    for line, found in _lengths(body.rstrip(b"\n").rpartition(b"\n")[0], layout):
        if found < len(layout.names):
            raise _other_length(file, line, found, layout)


def _lengths(body: bytes, layout: _Layout) -> Iterator[tuple[int, int]]:
    """The number of each line that holds samples, and how many fields it has."""
    mark = layout.separator.encode()
    for row, line in enumerate(body.split(b"\n")):
        if line and not line.startswith(b"#"):
            yield layout.line + row, line.count(mark) + 1


def _other_length(file: str, line: int, found: int, layout: _Layout) -> RecordingError:
    return RecordingError(
        f"{file}, line {line} has {count(found, 'field')}, and the first line of numbers has "
        f"{len(layout.names)}: correct it or leave it out."
    )


def _type(name: str, field: str, decimal_comma: bool) -> type:
    if not _is_number(field, decimal_comma) and field not in _MISSING:
        return pl.String
    exact = is_time(BRACKETED.sub(r"\1", name)) and field.isdigit() and len(field) > _EXACT_DIGITS
    return pl.Int64 if exact else pl.Float64
