"""Tables in text: columns of numbers below an optional header."""

import codecs
import gzip
import io
import itertools
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl

from ._csv_digits import grouped, is_grouped, is_number
from ._csv_header import nameless
from ._csv_layout import HEAD, MISSING, Layout, find_layout
from ._files import refuse_bomb
from ._recording import Block, RecordingError, Table
from ._text_clock import TextClock, find_text_clock, is_date, lacks_seconds
from ._timestamps import is_time
from ._wording import count

# The parser panics on some quotation marks, which is no Exception to Python.
_PARSER = (pl.exceptions.PolarsError, pl.exceptions.PanicException)
_Stream = io.BufferedReader | gzip.GzipFile | codecs.StreamRecoder
_LONGEST_LINE = 1 << 24
_CHUNK = 1 << 24
# Integers of more digits lose some as floats; time stamps in ns since 1970 have 19.
_EXACT_DIGITS = 15
# The beginning of a line that is neither blank nor a comment.
_SAMPLE = re.compile(rb"^[ \t]*[^\s#%]", re.MULTILINE)


def read_csv(path: Path) -> Table:
    """Columns of numbers from `.csv`, `.txt`, `.tsv` or one of them gzipped.

    **Raises** `RecordingError` when the file is no such table, with the line that is in the way.
    """
    with path.open("rb") as file, _unpacked(path, file) as stream:
        text = _begun(path.name, _whole(path, stream))
    return _table(path.name, text, find_layout(path.name, text))


def csv_blocks(path: Path, samples: int) -> Iterator[Block]:
    """The same line by line, in blocks of about `samples` lines."""
    size = path.stat().st_size
    with path.open("rb") as file, _unpacked(path, file) as stream:
        head = stream.read(4 * HEAD)
        length = max(len(head) // max(head.count(b"\n"), 1) * samples, len(head))
        layout, rest, ended = None, head, False
        while not ended:
            text = stream.read(length)
            ended = not text
            # Two bytes are a character in UTF-16.
            while text.endswith(b"\r") and (more := stream.read(2)):
                text += more
            text = rest + text
            text = (_begun if layout is None else _plain)(path.name, text)
            # Two lines wait for what comes after them: only the very last may be short, and it
            # makes no table by itself.
            cut = len(text) if ended else _before_last_lines(text)
            if not cut and len(text) > _LONGEST_LINE:
                raise RecordingError(f"{path.name} holds no table of numbers: a line has no end.")
            text, rest = text[:cut], text[cut:]
            if layout is None and cut:
                layout = find_layout(path.name, text)
            if layout is not None and _SAMPLE.search(text, layout.body):
                yield Block(_table(path.name, text, layout, ended), file.tell(), size)
            if layout is not None:
                line = layout.line + text.count(b"\n", layout.body)
                layout = replace(layout, body=0, line=line)


def _before_last_lines(text: bytes) -> int:
    """Where the last two whole lines of the text begin."""
    end = text.rstrip(b"\n").rfind(b"\n")
    for _ in range(2):
        end = text.rfind(b"\n", 0, max(end, 0))
    return end + 1


def _table(file: str, text: bytes, layout: Layout, ended: bool = True) -> Table:
    frame = _parse(file, _tidied(text, layout), layout, ended)
    frame.columns = layout.names
    texts = {
        name: field
        for name, field, column in zip(layout.names, layout.first, frame, strict=True)
        if column.dtype == pl.String
    }
    numbers = [name for name in layout.names if name not in texts]
    known = any(is_time(name, layout.units.get(name, "")) for name in numbers)
    clock = None if known else find_text_clock(texts)
    columns, units, findings = {}, layout.units, layout.findings
    if ended:
        findings += _about_end(text, layout)
    for position, (name, column) in enumerate(zip(layout.names, frame, strict=True), start=1):
        empty = column.null_count() == column.len()
        if clock is not None and name == clock.time:
            columns[name], unit = clock.read(frame)
            units = units | {name: unit}
        elif column.dtype == pl.String:
            findings += _about_text(name, texts[name], clock)
        # A nameless column without a value comes of lines that end in a separator.
        elif not (empty and name == nameless(position)):
            columns[name] = column.to_numpy()
    return Table(columns, units, findings=findings)


def _about_end(text: bytes, layout: Layout) -> tuple[str, ...]:
    """A finding when the last line is short of a field."""
    line = text.rstrip().rpartition(b"\n")[2]
    found = line.count(layout.separator.encode()) + 1
    # A separator at the end of a line divides nothing.
    needed = len(layout.names) - (not layout.first[-1])
    comment = line.lstrip().startswith((b"#", b"%"))
    if layout.separator == " " or comment or found >= needed:
        return ()
    return (
        f"The last line has {count(found, 'field')} of {needed}: the file was cut off there, and "
        "what is missing is left out.",
    )


def _about_text(name: str, first: str, clock: TextClock | None) -> tuple[str, ...]:
    if clock is not None and is_date(first):
        return ()
    if clock is None and lacks_seconds(first):
        return (
            f"The column {name} holds times without hours, minutes or seconds, such as "
            f"{first!r:.40}, and is left out: write them in full, as in 08:00:00.010.",
        )
    return (f"The column {name} holds text and is left out.",)


@contextmanager
def _unpacked(path: Path, file: io.BufferedReader) -> Iterator[_Stream]:
    """What is in the file, unzipped where it is a .gz, and in UTF-8 where a mark says UTF-16."""
    with _unzipped(path, file) as stream:
        marked = stream.peek(2)[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
        try:
            yield codecs.EncodedFile(stream, "utf-8", "utf-16") if marked else stream
        except UnicodeError as error:
            raise _not_plain(path.name) from error


@contextmanager
def _unzipped(path: Path, file: io.BufferedReader) -> Iterator[io.BufferedReader | gzip.GzipFile]:
    if path.suffix.lower() != ".gz":
        yield file
        return
    try:
        with gzip.GzipFile(fileobj=file) as stream:
            yield stream
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise RecordingError(
            f"{path.name} is not a complete gzip file: it may be cut off or of another kind."
        ) from error


def _whole(path: Path, stream: _Stream) -> bytes:
    text = io.BytesIO()
    while chunk := stream.read(_CHUNK):
        text.write(chunk)
        if path.suffix.lower() == ".gz":
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
    before, zero, _ = text.partition(b"\0")
    if zero:
        # What begins with lines of text is no spreadsheet.
        line = before.rpartition(b"\n")[0].rpartition(b"\n")[2].strip()
        if line and line.isascii() and line.decode().isprintable():
            raise RecordingError(
                f"{file} is not plain text: behind the line {line.decode()!r:.60} it is damaged, "
                "and holds bytes of zero; leave out what is damaged."
            )
        raise _not_plain(file)
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return text


def _not_plain(file: str) -> RecordingError:
    return RecordingError(
        f"{file} is not plain text: a spreadsheet has to be saved as CSV in UTF-8."
    )


def _tidied(text: bytes, layout: Layout) -> bytes:
    """The numbers and all lines between them, as the parser wants them."""
    body = text[layout.body :]
    if layout.separator == " ":
        body = re.sub(rb"[ \t]+", b" ", body)
        body = re.sub(rb"(?m)^ | $", b"", body)
    elif b" " in body:
        # White space around a field makes it text to the parser.
        mark = re.escape(layout.separator.encode())
        body = re.sub(rb"(?m)(?<! ) +(?=%b|$)|(?<=%b) +|^ +" % (mark, mark), b"", body)
    if b"#N/A" in body:
        # At the start of a line it is no comment.
        body = re.sub(rb"(?m)^#N/A", b"NA", body)
    # The parser knows one sign of a comment alone.
    return re.sub(rb"(?m)^%", b"#", body) if b"%" in body else body


def _parse(file: str, body: bytes, layout: Layout, ended: bool) -> pl.DataFrame:
    # A blank line is no sample, but it counts where a line is told by its number.
    filled = body.lstrip(b"\n")
    if b"\n\n" in filled:
        filled = re.sub(rb"\n\n+", b"\n", filled)

    def read(types: list[type]) -> pl.DataFrame:
        return pl.read_csv(
            filled,
            has_header=False,
            schema={str(k): kind for k, kind in enumerate(types)},
            separator=layout.separator,
            decimal_comma=layout.decimal_comma,
            null_values=list(MISSING),
            comment_prefix="#",
            encoding="utf8-lossy",
        )

    types = [
        _type(field, layout.decimal_comma, is_time(name, layout.units.get(name, "")))
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
        # Which numbers a short line lacks is not known; a logger that was stopped leaves one.
        _refuse_short(file, body.rstrip(b"\n").rpartition(b"\n")[0] if ended else body, layout)
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
                line, _ = next(itertools.islice(_lengths(body, layout), row, None))
                field = column[row].strip()
                if is_grouped(field):
                    raise grouped(file, line, field)
                raise RecordingError(
                    f"{file}, line {line}, column {name}: {field[:40]!r} is not a number."
                )
            if not failed.any():
                # Integers too long to be exact, which floats hold as well as they can.
                frame = frame.with_columns(text.cast(pl.Float64))
    return frame


def _ragged(file: str, body: bytes, layout: Layout) -> RecordingError:
    for line, found in _lengths(body, layout):
        if found != len(layout.names):
            return _other_length(file, line, found, layout)
    return RecordingError(f"{file} has a quotation mark that is not closed.")


def _refuse_short(file: str, body: bytes, layout: Layout) -> None:
    for line, found in _lengths(body, layout):
        if found < len(layout.names):
            raise _other_length(file, line, found, layout)


def _lengths(body: bytes, layout: Layout) -> Iterator[tuple[int, int]]:
    """The number of each line that holds samples, and how many fields it has."""
    mark = layout.separator.encode()
    for row, line in enumerate(body.split(b"\n")):
        if line and not line.startswith(b"#"):
            yield layout.line + row, line.count(mark) + 1


def _other_length(file: str, line: int, found: int, layout: Layout) -> RecordingError:
    return RecordingError(
        f"{file}, line {line} has {count(found, 'field')}, and the first line of numbers has "
        f"{len(layout.names)}: correct it or leave it out."
    )


def _type(field: str, decimal_comma: bool, time: bool) -> type:
    if not is_number(field, decimal_comma) and field not in MISSING:
        return pl.String
    return pl.Int64 if time and field.isdigit() and len(field) > _EXACT_DIGITS else pl.Float64
