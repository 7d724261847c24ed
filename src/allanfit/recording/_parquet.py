"""Parquet: a table with a unit in the metadata of a column, or in brackets behind its name."""

from pathlib import Path

from ..extras import needs
from ._csv import BRACKETED
from ._damage import careful
from ._files import refuse_bomb
from ._names import is_rate, units_by_channel
from ._recording import RecordingError, Table
from ._timestamps import is_time

_UNIT_KEYS = (b"unit", b"units")


def read_parquet(path: Path) -> Table:
    """Each column of numbers a channel; `rate_hz` in the file's own metadata, if it is there.

    **Raises** `RecordingError` when the file is damaged or two columns have one name.
    """
    with needs("allanfit[io]", "Parquet files", RecordingError):
        import pyarrow as arrow
        import pyarrow.parquet as parquet

    def is_number(kind: arrow.DataType) -> bool:
        return arrow.types.is_integer(kind) or arrow.types.is_floating(kind)

    columns, units, findings = {}, {}, ()
    with careful(path, "a Parquet file"), parquet.ParquetFile(path) as file:
        schema = file.schema_arrow
        wanted = [
            field.name
            for field in schema
            if is_number(field.type) or arrow.types.is_timestamp(field.type)
        ]
        refuse_bomb(path, 8 * file.metadata.num_rows * len(wanted))
        # Texts are not unpacked: a few bytes may stand for many that are long and alike.
        table = file.read(columns=wanted)
        read = dict(zip(table.column_names, table.columns, strict=True))
        for field in schema:
            kind = field.type
            bracketed = BRACKETED.fullmatch(field.name)
            name = bracketed[1] if bracketed else field.name
            if name in columns:
                raise RecordingError(f"{path.name} has two columns named {name}: rename one.")
            if is_number(kind):
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
            key.decode(): text.decode(errors="replace")
            for key, text in (schema.metadata or {}).items()
        }
        own = units_by_channel(path.name, metadata.get("units"))
        rates = [float(text) for key, text in metadata.items() if is_rate(key)]
    if not columns:
        raise RecordingError(f"{path.name} holds no column of numbers.")
    return Table(columns, own | units, rates[0] if rates else None, findings)
