"""The results on disk: a Parquet part a recording, whole or not there."""

import hashlib
import os
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ._errors import FleetError, fleet_extra
from ._rows import FAILED, SCHEMA, Row, arrow_schema

#: The folder of the parts within that of the output.
RESULTS = "results"
_OLD_S = 86400.0
_NAME_LETTERS = 80  # of a recording's name in that of its part, far below what disks allow


class Store:
    """The parts in an output folder.

    A part is written beside the folder of parts and then renamed into it: a reader of all parts
    never meets half of one, and what a killed run left behind is no part.
    """

    def __init__(self, folder: Path):
        """Make the folder, and find out now rather than after the work if it can be written.

        **Raises** `FleetError` if it cannot.
        """
        self.folder = folder
        self.parts = folder / RESULTS
        try:
            self.parts.mkdir(parents=True, exist_ok=True)
            self._forget_leftovers()
            probe = folder / f".probe.{os.getpid()}.part"
            probe.write_bytes(b"\0")
            probe.unlink()
            os.scandir(self.parts).close()
        except OSError as error:
            raise self._cannot_write(error) from error

    def part(self, recording: Path) -> Path:
        """Where the result of a recording is: named by it, and told apart by its whole path."""
        digest = hashlib.sha256(os.fsencode(os.path.realpath(recording))).hexdigest()[:12]
        name = recording.name.encode("utf-8", "replace").decode()[:_NAME_LETTERS]
        return self.parts / f"{name.lstrip('.')}-{digest}.parquet"

    def write(self, recording: Path, rows: Sequence[Row]) -> None:
        """Put the rows of a recording in place of those that were there.

        **Raises** `FleetError` if that is not possible.
        """
        import pyarrow
        import pyarrow.parquet

        target = self.part(recording)
        part = self.folder / f".{target.name}.{os.getpid()}.part"
        try:
            try:
                with part.open("wb") as stream:
                    table = pyarrow.Table.from_pylist(list(rows), schema=arrow_schema())
                    pyarrow.parquet.write_table(table, stream)
                    stream.flush()
                    os.fsync(stream.fileno())
                part.replace(target)
            finally:
                part.unlink(missing_ok=True)
        except OSError as error:
            raise self._cannot_write(error) from error

    def read(self, recording: Path) -> list[Row]:
        """The rows of a recording; none if there is no part, or none of this schema."""
        with fleet_extra():
            import pyarrow
            import pyarrow.parquet
        try:
            table = pyarrow.parquet.ParquetFile(self.part(recording)).read()
        except FileNotFoundError:
            return []
        except (OSError, pyarrow.ArrowException):
            return []  # damaged: what it held is made again
        metadata = table.schema.metadata or {}
        return table.to_pylist() if metadata.get(b"schema") == SCHEMA.encode() else []

    def read_all(self, recordings: Iterable[Path]) -> list[Row]:
        """The rows of many recordings, in their order."""
        return [row for each in recordings for row in self.read(each)]

    def others(self, recordings: Iterable[Path]) -> int:
        """How many parts there are beside those of these recordings."""
        mine = {self.part(each).name for each in recordings}
        return sum(each.name not in mine for each in self.parts.glob("*.parquet"))

    def _cannot_write(self, error: OSError) -> FleetError:
        return FleetError(
            f"Cannot write results to {self.folder} ({error.strerror or error}): give with "
            "--output a folder that is writable and has space; what is done stays done, and the "
            "same command goes on from there."
        )

    def _forget_leftovers(self) -> None:
        # Of runs killed while they wrote; a younger one may be of a run that lives.
        for left in self.folder.glob(".*.part"):
            if time.time() - left.stat().st_mtime > _OLD_S:
                left.unlink(missing_ok=True)


def still_good(rows: Sequence[Row], options: str, version: str) -> bool:
    """Whether rows that are there were made by these options and this version."""
    made: Any = {(row["options"], row["allanfit_version"]) for row in rows}
    return made == {(options, version)}


def known_checksum(rows: Sequence[Row]) -> str | None:
    """Of the file that the rows are the final word on, None if there is no such file."""
    return rows[0]["file_sha256"] if rows else None


def holds_results(rows: Sequence[Row]) -> bool:
    """Whether the rows are of channels, not of an error."""
    return bool(rows) and rows[0]["status"] != FAILED
