"""What every format returns."""

import os
from typing import NamedTuple

from ..report._files import write_whole


class Exported(NamedTuple):
    """A file's text, and what its user must know before it is used: one sentence each."""

    text: str
    warnings: list[str]

    def write(self, target: str | os.PathLike[str]) -> None:
        """Write the text to a path, whole or not at all, or to standard output for "-".

        **Raises:** `ReportError` if it cannot be written.
        """
        write_whole(self.text, target)
