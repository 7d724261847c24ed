"""Parquet: a table with a unit in the metadata of a column, or in brackets behind its name."""

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..extras import needs
from ._csv_header import BRACKETED
from ._damage import careful, each_guarded
from ._files import refuse_bomb
from ._names import is_rate, units_by_channel
from ._recording import Block, RecordingError, Table
from ._timestamps import is_time

_WHAT = "a Parquet file"
_UNIT_KEYS = (b"unit", b"units")


def read_parquet(path: Path) -> Table:
    """Each column of numbers a channel; `rate_hz` in the file's own metadata, if it is there.

    **Raises** `RecordingError` when the file is damaged or two columns have one name.
    """
    with careful(path, _WHAT), _opened(path) as file:
        wanted = _wanted(file.schema_arrow)
        refuse_bomb(path, 8 * file.metadata.num_rows * len(wanted))
        return _table(path, file.schema_arrow, file.read(columns=wanted))


def parquet_blocks(path: Path, samples: int) -> Iterator[Block]:
    """The same in blocks of at most so many samples."""
    yield from each_guarded(lambda: careful(path, _WHAT), _blocks(path, samples))


def _blocks(path: Path, samples: int) -> Generator[Block, None, None]:
    with _opened(path) as file:
        import pyarrow as arrow

        read, whole = 0, file.metadata.num_rows
        schema = file.schema_arrow
        for batch in file.iter_batches(samples, columns=_wanted(schema)):
            read += batch.num_rows
            table = arrow.Table.from_batches([batch])
            yield Block(_table(path, schema, table), read, whole)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    with needs("allanfit[io]", "Parquet files", RecordingError):
        import pyarrow.parquet as parquet
    with parquet.ParquetFile(path) as file:
        yield file


def _wanted(schema: Any) -> list[str]:
    """The columns to read: no texts, of which a few bytes may stand for many that are long."""
    from pyarrow import types

    return [
        field.name for field in schema if _is_number(field.type) or types.is_timestamp(field.type)
    ]


def _is_number(kind: Any) -> bool:
    from pyarrow import types

    return types.is_integer(kind) or types.is_floating(kind)


def _table(path: Path, schema: Any, table: Any) -> Table:
    import pyarrow as arrow

    columns, units, findings = {}, {}, ()
    read = dict(zip(table.column_names, table.columns, strict=True))
    for field in schema:
        kind = field.type
        bracketed = BRACKETED.fullmatch(field.name)
        name = bracketed[1] if bracketed else field.name
        if name in columns:
            raise RecordingError(f"{path.name} has two columns named {name}: rename one.")
        if _is_number(kind):
            columns[name] = read[field.name].to_numpy()
        elif arrow.types.is_timestamp(kind) and not any(map(is_time, columns)):
            columns["time"] = read[field.name].cast(arrow.int64()).to_numpy()
            units["time"] = kind.unit
            continue
        else:
            findings += (f"The column {name} holds {kind}, no real numbers, and is left out.",)
        stated = [(field.metadata or {}).get(key) for key in _UNIT_KEYS]
        unit = next((each.decode() for each in stated if each), bracketed and bracketed[2])
        if unit:
            units[name] = unit.strip()
    metadata = {
        key.decode(): text.decode(errors="replace") for key, text in (schema.metadata or {}).items()
    }
    own = units_by_channel(path.name, metadata.get("units"))
    if not columns:
        raise RecordingError(f"{path.name} holds no column of numbers.")
    rate_hz = None
    for key, text in metadata.items():
        if rate_hz is None and is_rate(key):
            try:
                rate_hz = float(text.lower().removesuffix("hz"))
            except ValueError:
                findings += (f"The rate {text!r} in the metadata is no number of Hz; not used.",)
    return Table(columns, own | units, rate_hz, findings)
